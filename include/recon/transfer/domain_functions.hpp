// The linear functions of a grid, averaged over what a particle is.
//
//     S_i = average of N_i over the domain ,   G_i = average of grad N_i over the domain
//
//   GimpFunctions   a box about x: uGIMP, whose box keeps its reference edges (Gong 2015, eq.
//                   6.19), and cpGIMP, whose edges are stretched by the diagonal of F (Bardenhagen,
//                   Kober 2004)
//   Cpdi1Functions  a parallelepiped deformed by F, N_i interpolated between its corners
//                   (Sadeghirad, Brannon, Burghardt 2011; Gong 2015, eq. 6.21-6.27)
//   Cpdi2Functions  the quadrilateral or hexahedron of any corners (Sadeghirad, Brannon, Guilkey
//                   2013; Gong 2015, eq. 6.28-6.32)
//
// sum_i S_i = 1, sum_i G_i = 0, and linear fields are interpolated exactly: sum_i S_i x_i is the
// centroid of the domain. A domain may extend beyond the grid: the functions of the outermost cells
// go on there.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   recon::GimpFunctions::Nodes<2> at;  // of any number: a box may cover many cells
//   recon::GimpFunctions{}.at(grid, recon::ugimp_domain<2>({0.3, 0.4}, half_edges), at);
//   const double density = at.value(nodal_density);
// ```
//
// H is the matrix of the half edges of the particle's reference domain, in columns, F its
// deformation gradient. Corner number a of a domain lies on the positive side of half edge d where
// bit d of a is set. Functions as in point_functions.hpp, where the points are; their `at` takes a
// domain for the point.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "recon/transfer/point_functions.hpp"

namespace recon {

template <int D>
struct BoxDomain {
  SpaceVector<D> x, half_edges;  // length
};
template <int D>
struct ParallelepipedDomain {
  SpaceVector<D> x;
  SpaceMatrix<D> half_edges;  // columns: F H
};
template <int D>
using DomainCorners = std::array<SpaceVector<D>, 1 << D>;

// The box of uGIMP: H counts with the box about it where its edges are not along the axes.
template <int D>
BoxDomain<D> ugimp_domain(const SpaceVector<D>& x, const SpaceMatrix<D>& H) {
  BoxDomain<D> box{x, {}};
  for (int d = 0; d < D; ++d) box.half_edges[d] = H.row(d).cwiseAbs().sum();
  return box;
}
// That of cpGIMP.
template <int D>
BoxDomain<D> cpgimp_domain(const SpaceVector<D>& x, const SpaceMatrix<D>& H,
                           const SpaceMatrix<D>& F) {
  BoxDomain<D> box = ugimp_domain<D>(x, H);
  for (int d = 0; d < D; ++d) box.half_edges[d] *= std::abs(F(d, d));
  return box;
}

// Coordinate d of corner a.
template <int D>
double corner_along(const ParallelepipedDomain<D>& domain, int a, int d) {
  double at = domain.x[d];
  for (int e = 0; e < D; ++e) at += (a >> e & 1 ? 1.0 : -1.0) * domain.half_edges(d, e);
  return at;
}
template <int D>
DomainCorners<D> corners_of(const ParallelepipedDomain<D>& domain) {
  DomainCorners<D> at;
  for (int a = 0; a < 1 << D; ++a)
    for (int d = 0; d < D; ++d) at[a][d] = corner_along(domain, a, d);
  return at;
}

namespace detail {

// The nodes of a box on one axis; more would be no particle.
inline constexpr int widest_box = 34;

[[noreturn]] void throw_half_edge(double l, int axis);
// Of a parallelepiped: names the one that is not finite, or else their determinant. Of corners: a
// coordinate, or else the volume.
[[noreturn]] void throw_half_edges(const double* H, int dimension, double determinant);
[[noreturn]] void throw_corners(const double* corners, int count, int dimension, double volume);
[[noreturn]] void throw_width(double cells, int axis);

template <int D>
[[gnu::noinline]] void require_wide_box(const CartesianGrid<D>& grid, int d, double x, double l) {
  grid.require_coordinate(x, d);
  if (!(l > 0 && std::isfinite(l))) throw_half_edge(l, d);
  if (grid.cell(x + l, d) - grid.cell(x - l, d) + 2 > widest_box) throw_width(2 * l / grid.h(), d);
}
// Throws InvalidArgument for a box [x - l, x + l] that average() cannot take. A narrow one fits
// wherever it lies; a wide one may lie beyond the grid for the most part.
template <int D>
void require_box(const CartesianGrid<D>& grid, int d, double x, double l) {
  if (!(std::isfinite(x) && l > 0 && 2 * l <= (widest_box - 3) * grid.h())) [[unlikely]]
    require_wide_box(grid, d, x, l);
}

// Writes the averages over [x - l, x + l], summed cell by cell. The outermost cells continue
// beyond the grid.
template <int D>
void average(const CartesianGrid<D>& grid, int d, double x, double l,
             AxisFunctions<AtMost<widest_box>>& axis) {
  require_box(grid, d, x, l);
  const double per_h = grid.inverse_h(), per_edge = grid.h() / (2 * l);
  const int cells = grid.cell(x + l, d) - grid.cell(x - l, d);
  axis.first = grid.cell(x - l, d);
  axis.count = cells + 2;
  axis.S[0] = axis.G[0] = 0;
  // In cells from the first node on.
  const double lower = grid.node(axis.first, d);
  const double low = (x - l - lower) * per_h, high = (x + l - lower) * per_h;
  for (int k = 0; k <= cells; ++k) {
    const double begin = k == 0 ? low : k, end = k == cells ? high : k + 1;
    const double part = (end - begin) * per_edge;
    const double xi = (begin + end) / 2 - k;
    axis.S[k] += part * (1 - xi);
    axis.S[k + 1] = part * xi;
    axis.G[k] -= part * per_h;
    axis.G[k + 1] = part * per_h;
  }
}

// The nodes that the corners of a domain see: those of the box around them or, where that box is
// larger than this, those of each corner by itself.
template <int D>
inline constexpr int most_gathered = 2 << 2 * D;

// Sums over the corners a of a domain, S_i = sum_a weight_a N_i(corner_a) and G_i = sum_a slope_a
// N_i(corner_a): one entry for each node of the box around the corners or, where that box is large,
// one for each corner and node.
template <int D, class Count>
void from_corners(const CartesianGrid<D>& grid, const DomainCorners<D>& corners,
                  const std::array<double, 1 << D>& weight,
                  const std::array<SpaceVector<D>, 1 << D>& slope, NodeFunctions<D, Count>& out) {
  static_assert(takes<Count, AtMost<most_gathered<D>>>,
                "these functions have more nodes than the object takes: use their type Nodes<D>");
  constexpr int corner_count = 1 << D;
  std::array<std::array<int, D>, corner_count> cell;
  std::array<int, D> first, count;
  std::size_t nodes = 1;
  for (int d = 0; d < D; ++d) {
    int last = 0;
    for (int a = 0; a < corner_count; ++a) {
      cell[a][d] = grid.cell(corners[a][d], d);
      first[d] = a == 0 ? cell[a][d] : std::min(first[d], cell[a][d]);
      last = a == 0 ? cell[a][d] : std::max(last, cell[a][d]);
    }
    count[d] = last - first[d] + 2;
    nodes *= static_cast<std::size_t>(count[d]);
  }
  const bool gathered = nodes <= static_cast<std::size_t>(most_gathered<D>);
  out.resize(gathered ? nodes : static_cast<std::size_t>(corner_count) * corner_count);
  if (gathered) {
    std::array<int, D> index = first;
    for (std::size_t n = 0; n < nodes; ++n) {
      out.node[n] = grid.number(index);
      out.S[n] = 0;
      out.G[n].setZero();
      for (int d = 0; d < D && ++index[d] == first[d] + count[d]; ++d) index[d] = first[d];
    }
  }
  // From a corner's first node in the list to its others.
  std::array<std::size_t, corner_count> beyond{};
  for (int b = 0; b < corner_count; ++b)
    for (int d = 0, stride = 1; d < D; stride *= count[d], ++d)
      if (b >> d & 1) beyond[b] += static_cast<std::size_t>(stride);
  for (int a = 0; a < corner_count; ++a) {
    // The functions of the corner's cell, the first axis fastest.
    std::array<double, corner_count> N;
    N[0] = 1;
    std::size_t begin = 0;
    for (int d = D - 1; d >= 0; --d) {
      const double xi = (corners[a][d] - grid.node(cell[a][d], d)) * grid.inverse_h();
      for (int b = (1 << (D - 1 - d)) - 1; b >= 0; --b) {
        N[2 * b + 1] = N[b] * xi;
        N[2 * b] = N[b] * (1 - xi);
      }
      begin = begin * static_cast<std::size_t>(count[d]) +
              static_cast<std::size_t>(cell[a][d] - first[d]);
    }
    for (int b = 0; b < corner_count; ++b) {
      std::size_t n = begin + beyond[b];
      if (!gathered) {
        std::array<int, D> index;
        for (int d = 0; d < D; ++d) index[d] = cell[a][d] + (b >> d & 1);
        n = static_cast<std::size_t>(a * corner_count + b);
        out.node[n] = grid.number(index);
        out.S[n] = 0;
        out.G[n].setZero();
      }
      out.S[n] += weight[a] * N[b];
      out.G[n] += N[b] * slope[a];
    }
  }
}

// The nodes of the cells that hold corners: of the very corners that the functions are taken at, so
// that no other node is touched, not even by rounding. Of the coordinates of the corners along d.
template <int D>
std::pair<int, int> nodes_of_corners(const CartesianGrid<D>& grid,
                                     const std::array<double, 1 << D>& along, int d) {
  double least = along[0], most = along[0], zero = 0;  // and NaN where one is not finite
  for (const double x : along) {
    least = std::min(least, x);
    most = std::max(most, x);
    zero += x - x;
  }
  if (zero != 0) [[unlikely]]
    for (const double x : along) grid.require_coordinate(x, d);
  return {grid.cell(least, d), grid.cell(most, d) + 1};
}
template <int D>
std::pair<int, int> nodes_of_corners(const CartesianGrid<D>& grid, const DomainCorners<D>& corners,
                                     int d) {
  std::array<double, 1 << D> along;
  for (int a = 0; a < 1 << D; ++a) along[a] = corners[a][d];
  return nodes_of_corners<D>(grid, along, d);
}

// The nodes along an axis of what extends by `reach` to both sides of x.
template <int D>
std::pair<int, int> nodes_within(const CartesianGrid<D>& grid, double x, double reach, int d) {
  return {grid.cell(x - reach, d), grid.cell(x + reach, d) + 1};
}

}  // namespace detail

// Throws InvalidArgument for half edges that are not positive and finite, or reach over more than 32
// cells.
struct GimpFunctions {
  template <int D>
  using Nodes = NodeFunctions<D>;

  // Of each axis; the functions are the products.
  template <int D>
  using Axes = std::array<detail::AxisFunctions<AtMost<detail::widest_box>>, D>;
  template <int D>
  static void write_axes(const CartesianGrid<D>& grid, const BoxDomain<D>& box, Axes<D>& axes) {
    for (int d = 0; d < D; ++d) detail::average(grid, d, box.x[d], box.half_edges[d], axes[d]);
  }
  // Not inlined: where all calls of a loop over particles are, it would be a quarter slower.
  template <int D>
  [[gnu::noinline]] static void at(const CartesianGrid<D>& grid, const BoxDomain<D>& box,
                                   NodeFunctions<D>& out) {
    Axes<D> axes;
    write_axes<D>(grid, box, axes);
    detail::tensor_product<D>(grid, axes, out);
  }
  template <int D>
  static std::pair<int, int> nodes_along(const CartesianGrid<D>& grid, const BoxDomain<D>& box,
                                         int d) {
    detail::require_box(grid, d, box.x[d], box.half_edges[d]);
    return detail::nodes_within(grid, box.x[d], box.half_edges[d], d);
  }
  template <int D>
  static void check(const CartesianGrid<D>& grid, const BoxDomain<D>& box) {
    for (int d = 0; d < D; ++d) detail::require_box(grid, d, box.x[d], box.half_edges[d]);
  }
};

// With x' = x + F H xi, xi in [-1, 1]^D: the function of a corner has the average 1 / 2^D, and its
// gradient the average (F H)^-T s / 2^D, with s the signs of the corner. Throws InvalidArgument for
// half edges that are not finite, and for a domain without volume.
struct Cpdi1Functions {
  template <int D>
  using Nodes = NodeFunctions<D, AtMost<detail::most_gathered<D>>>;

  template <int D, class Count>
  static void at(const CartesianGrid<D>& grid, const ParallelepipedDomain<D>& domain,
                 NodeFunctions<D, Count>& out) {
    constexpr int corner_count = 1 << D;
    const SpaceMatrix<D> turned = inverse_of(domain) / corner_count;
    std::array<double, corner_count> weight;
    std::array<SpaceVector<D>, corner_count> slope;
    for (int a = 0; a < corner_count; ++a) {
      SpaceVector<D> sign;
      for (int d = 0; d < D; ++d) sign[d] = a >> d & 1 ? 1 : -1;
      weight[a] = 1.0 / corner_count;
      slope[a] = turned.transpose() * sign;
    }
    detail::from_corners<D>(grid, corners_of(domain), weight, slope, out);
  }
  template <int D>
  static std::pair<int, int> nodes_along(const CartesianGrid<D>& grid,
                                         const ParallelepipedDomain<D>& domain, int d) {
    std::array<double, 1 << D> along;
    for (int a = 0; a < 1 << D; ++a) along[a] = corner_along(domain, a, d);
    return detail::nodes_of_corners<D>(grid, along, d);
  }
  template <int D>
  static void check(const CartesianGrid<D>& grid, const ParallelepipedDomain<D>& domain) {
    grid.require_point(domain.x);
    inverse_of(domain);
    // The farthest corner along each axis.
    const SpaceVector<D> reach = domain.half_edges.cwiseAbs().rowwise().sum();
    grid.require_point(SpaceVector<D>(domain.x.cwiseAbs() + reach));
  }
  // Of the half edges.
  template <int D>
  static SpaceMatrix<D> inverse_of(const ParallelepipedDomain<D>& domain) {
    SpaceMatrix<D> inverse = domain.half_edges.inverse();
    // The inverse of what is infinite may be finite.
    if (!inverse.allFinite() || !domain.half_edges.allFinite()) [[unlikely]]
      detail::throw_half_edges(domain.half_edges.data(), D, domain.half_edges.determinant());
    return inverse;
  }
};

namespace detail {

// The multilinear functions of 2^D corners in [-1, 1]^D: that of corner a at Gauss point g, and its
// gradient.
template <int D>
struct CornerGauss {
  double N[1 << D][1 << D];
  double local[1 << D][1 << D][D];

  CornerGauss() {
    for (int g = 0; g < 1 << D; ++g)
      for (int a = 0; a < 1 << D; ++a) {
        N[g][a] = 1;
        for (int d = 0; d < D; ++d) local[g][a][d] = 1;
        for (int d = 0; d < D; ++d) {
          const double xi = (g >> d & 1 ? 1 : -1) / std::sqrt(3.0), sign = a >> d & 1 ? 1 : -1;
          N[g][a] *= (1 + sign * xi) / 2;
          for (int e = 0; e < D; ++e) local[g][a][e] *= e == d ? sign / 2 : (1 + sign * xi) / 2;
        }
      }
  }
};

// Writes the averages of the functions of corners and of their gradients over the cell that they
// span, D numbers for each corner and gradient, and returns the volume; nothing of use where that
// is zero. M is a type of matrices, Eigen's or one with the same functions.
template <class M>
constexpr double average_over_corners(const CornerGauss<M::RowsAtCompileTime>& gauss,
                                      const double* corners, double* weight, double* slope) {
  constexpr int D = M::RowsAtCompileTime, count = 1 << D;
  double volume = 0;
  for (int a = 0; a < count; ++a) weight[a] = 0;
  for (int a = 0; a < count * D; ++a) slope[a] = 0;
  for (int g = 0; g < count; ++g) {
    M J = M::Zero();
    for (int a = 0; a < count; ++a)
      for (int c = 0; c < D; ++c)
        for (int r = 0; r < D; ++r) J(r, c) += corners[a * D + r] * gauss.local[g][a][c];
    const double part = J.determinant();
    const M turned = J.inverse().transpose() * part;
    volume += part;
    for (int a = 0; a < count; ++a) {
      weight[a] += part * gauss.N[g][a];
      for (int r = 0; r < D; ++r) {
        double along = turned(r, 0) * gauss.local[g][a][0];
        for (int c = 1; c < D; ++c) along += turned(r, c) * gauss.local[g][a][c];
        slope[a * D + r] += along;
      }
    }
  }
  for (int a = 0; a < count; ++a) weight[a] /= volume;
  for (int a = 0; a < count * D; ++a) slope[a] /= volume;
  return volume;
}

}  // namespace detail

// The cell that corners span, with the averages of their multilinear functions (`weight`, which sum
// to one) and of the gradients of these (`slope`, 1 / length, which sum to zero) over it. Two Gauss
// points an axis are exact (they replace Gong 2015, eq. 6.29-6.32, of which the first two are
// misprinted: docs/misprints.md, G23). The volume is negative where the corners are turned inside
// out. Throws InvalidArgument where it is zero or not finite, or a corner is not.
template <int D>
struct CornerDomain {
  DomainCorners<D> corners;
  std::array<double, 1 << D> weight{};
  std::array<SpaceVector<D>, 1 << D> slope;
  double volume = 0;  // length^D

  explicit CornerDomain(const DomainCorners<D>& at) : corners(at) {
    static const detail::CornerGauss<D> gauss;
    volume = detail::average_over_corners<SpaceMatrix<D>>(gauss, corners[0].data(), weight.data(),
                                                          slope[0].data());
    if (!(volume != 0 && std::isfinite(volume))) [[unlikely]]
      detail::throw_corners(corners[0].data(), 1 << D, D, volume);
  }

  SpaceVector<D> centroid() const {
    SpaceVector<D> sum = SpaceVector<D>::Zero();
    for (int a = 0; a < (1 << D); ++a) sum += weight[a] * corners[a];
    return sum;
  }
};

struct Cpdi2Functions {
  template <int D>
  using Nodes = NodeFunctions<D, AtMost<detail::most_gathered<D>>>;

  template <int D, class Count>
  static void at(const CartesianGrid<D>& grid, const CornerDomain<D>& domain,
                 NodeFunctions<D, Count>& out) {
    detail::from_corners<D>(grid, domain.corners, domain.weight, domain.slope, out);
  }
  // Needs no more of a domain than its corners.
  template <int D>
  static std::pair<int, int> nodes_along(const CartesianGrid<D>& grid,
                                         const DomainCorners<D>& corners, int d) {
    return detail::nodes_of_corners<D>(grid, corners, d);
  }
  template <int D>
  static std::pair<int, int> nodes_along(const CartesianGrid<D>& grid,
                                         const CornerDomain<D>& domain, int d) {
    return detail::nodes_of_corners<D>(grid, domain.corners, d);
  }
  // The rest has been checked where the domain was made.
  template <int D>
  static void check(const CartesianGrid<D>& grid, const CornerDomain<D>& domain) {
    grid.require_coordinate(domain.corners[0][0], 0);
  }
};

}  // namespace recon
