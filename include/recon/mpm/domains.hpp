// Particle domains: the linear functions of the grid, averaged over what a particle is.
//
//     S_ip = average of N_i over the domain,   G_ip = average of grad N_i over the domain.
//
//   UniformGimp    a box about x_p that keeps its reference edges (Gong 2015, eq. 6.19)
//   StretchedGimp  the same, edges stretched by the diagonal of F (cpGIMP)
//   Cpdi1          a parallelepiped deformed by F, N_i interpolated between its corners
//                  (eq. 6.21-6.27)
//   Cpdi2          corners that move with the grid, quadrilaterals and hexahedra (eq. 6.28-6.32)
//
// sum_i S_ip = 1, sum_i G_ip = 0, and linear fields are interpolated exactly. Policies as in
// bases.hpp, where the points are.
#pragma once

#include <span>
#include <vector>

#include "recon/mpm/bases.hpp"

namespace recon::mpm {

namespace detail {

// The averages over [x - l, x + l], summed cell by cell. The outermost cells continue
// beyond the grid.
template <int D>
AxisShape average(const Grid<D>& grid, int d, double x, double l) {
  AxisShape axis;
  const double h = grid.h();
  const int last = grid.cell(x + l, d);
  axis.first = grid.cell(x - l, d);
  axis.count = last - axis.first + 2;
  recon::detail::require(axis.count <= AxisShape::most, "particle domain in cells", 2 * l / h,
                         "must be at most 32 along an axis");
  std::fill_n(axis.S.begin(), axis.count, 0.0);
  std::fill_n(axis.G.begin(), axis.count, 0.0);
  for (int c = axis.first; c <= last; ++c) {
    const double begin = c == axis.first ? x - l : grid.node(c, d);
    const double end = c == last ? x + l : grid.node(c + 1, d);
    const double part = (end - begin) / (2 * l);
    const double xi = ((begin + end) / 2 - grid.node(c, d)) / h;
    const int k = c - axis.first;
    axis.S[k] += part * (1 - xi);
    axis.S[k + 1] += part * xi;
    axis.G[k] -= part / h;
    axis.G[k + 1] += part / h;
  }
  return axis;
}

// Sums over the corners a of a domain, S_i = sum_a weight_a N_i(corner_a) and G_i = sum_a slope_a
// N_i(corner_a): one entry for each node of the box around the corners or, where that box is large,
// one for each corner and node.
template <int D>
void from_corners(const Grid<D>& grid, const typename Particles<D>::Corners& corners,
                  const std::array<double, 1 << D>& weight,
                  const std::array<Vector<D>, 1 << D>& slope, ShapeFunctions<D>& out) {
  constexpr int corner_count = 1 << D;
  constexpr std::size_t most_gathered = 2 * corner_count * corner_count;
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
  const bool gathered = nodes <= most_gathered;
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
  for (int a = 0; a < corner_count; ++a) {
    Vector<D> xi;
    for (int d = 0; d < D; ++d) xi[d] = (corners[a][d] - grid.node(cell[a][d], d)) / grid.h();
    for (int b = 0; b < corner_count; ++b) {
      double N = 1;
      std::size_t n = 0;
      std::array<int, D> index;
      for (int d = D - 1; d >= 0; --d) {
        const int upper = b >> d & 1;
        N *= upper ? xi[d] : 1 - xi[d];
        index[d] = cell[a][d] + upper;
        n = n * static_cast<std::size_t>(count[d]) + static_cast<std::size_t>(index[d] - first[d]);
      }
      if (!gathered) {
        n = static_cast<std::size_t>(a * corner_count + b);
        out.node[n] = grid.number(index);
        out.S[n] = 0;
        out.G[n].setZero();
      }
      out.S[n] += weight[a] * N;
      out.G[n] += N * slope[a];
    }
  }
}

}  // namespace detail

// A policy whose domain extends by Domain::reach() to both sides of x_p along an axis.
template <class Domain>
struct Reaching : detail::Memoryless {
  template <int D>
  static std::pair<int, int> nodes_along(const Grid<D>& grid, const Particles<D>& particles,
                                         std::size_t p, int d) {
    const double x = particles.x[p][d], reach = Domain::reach(particles, p, d);
    return {grid.cell(x - reach, d), grid.cell(x + reach, d) + 1};
  }
};

// Domains that are boxes: reach() is the half edge along an axis.
template <bool stretched>
struct Gimp : Reaching<Gimp<stretched>> {
  template <int D>
  static double reach(const Particles<D>& particles, std::size_t p, int d) {
    const double l = particles.half_edges[p].row(d).cwiseAbs().sum();
    return stretched ? l * std::abs(particles.F[p](d, d)) : l;
  }
  // Not inlined: the loops over particles, whose calls all are inlined, would be a quarter slower.
  template <int D>
  [[gnu::noinline]] static double shape(const Grid<D>& grid, const Particles<D>& particles,
                                        std::size_t p, ShapeFunctions<D>& out) {
    std::array<detail::AxisShape, D> axes;
    for (int d = 0; d < D; ++d)
      axes[d] = detail::average(grid, d, particles.x[p][d], reach(particles, p, d));
    detail::tensor_product<D>(grid, axes, out);
    return particles.volume(p);
  }
};
using UniformGimp = Gimp<false>;
using StretchedGimp = Gimp<true>;

struct Cpdi1 : Reaching<Cpdi1> {
  template <int D>
  static double reach(const Particles<D>& particles, std::size_t p, int d) {
    return (particles.F[p] * particles.half_edges[p]).row(d).cwiseAbs().sum();
  }
  // With x = x_p + H xi, xi in [-1, 1]^D: the function of a corner has the average 1 / 2^D, and its
  // gradient the average H^-T s / 2^D, with s the signs of the corner.
  template <int D>
  static double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
                      ShapeFunctions<D>& out) {
    constexpr int corner_count = 1 << D;
    const Matrix<D> turned = (particles.F[p] * particles.half_edges[p]).inverse() / corner_count;
    std::array<double, corner_count> weight;
    std::array<Vector<D>, corner_count> slope;
    for (int a = 0; a < corner_count; ++a) {
      Vector<D> sign;
      for (int d = 0; d < D; ++d) sign[d] = a >> d & 1 ? 1 : -1;
      weight[a] = 1.0 / corner_count;
      slope[a] = turned.transpose() * sign;
    }
    detail::from_corners<D>(grid, particles.domain(p), weight, slope, out);
    return particles.volume(p);
  }
};

struct Cpdi2 : Reaching<Cpdi2> {
  template <int D>
  static double reach(const Particles<D>& particles, std::size_t p, int d) {
    double most = 0;
    for (const Vector<D>& corner : particles.corners[p])
      most = std::max(most, std::abs(corner[d] - particles.x[p][d]));
    return most;
  }

  // Averages of the corners' multilinear functions and of their gradients over the cell that the
  // corners span; two Gauss points an axis are exact (they replace eq. 6.29-6.32, of which the
  // first two are misprinted: docs/misprints.md, G23).
  template <int D>
  struct Cell {
    std::array<double, 1 << D> weight{};
    std::array<Vector<D>, 1 << D> slope;
    double volume = 0;

    explicit Cell(const typename Particles<D>::Corners& corners) {
      constexpr int count = 1 << D;
      slope.fill(Vector<D>::Zero());
      for (int g = 0; g < count; ++g) {
        Matrix<D> J = Matrix<D>::Zero();
        for (int a = 0; a < count; ++a) J += corners[a] * gauss().local[g][a].transpose();
        const double part = J.determinant();
        const Matrix<D> turned = J.inverse().transpose() * part;
        volume += part;
        for (int a = 0; a < count; ++a) {
          weight[a] += part * gauss().N[g][a];
          slope[a] += turned * gauss().local[g][a];
        }
      }
      for (int a = 0; a < count; ++a) {
        weight[a] /= volume;
        slope[a] /= volume;
      }
    }

   private:
    // The function of corner a at Gauss point g, and its gradient in [-1, 1]^D.
    struct Gauss {
      double N[1 << D][1 << D];
      Vector<D> local[1 << D][1 << D];
      Gauss() {
        for (int g = 0; g < 1 << D; ++g)
          for (int a = 0; a < 1 << D; ++a) {
            N[g][a] = 1;
            local[g][a].setOnes();
            for (int d = 0; d < D; ++d) {
              const double xi = (g >> d & 1 ? 1 : -1) / std::sqrt(3.0), sign = a >> d & 1 ? 1 : -1;
              N[g][a] *= (1 + sign * xi) / 2;
              for (int e = 0; e < D; ++e) local[g][a][e] *= e == d ? sign / 2 : (1 + sign * xi) / 2;
            }
          }
      }
    };
    static const Gauss& gauss() {
      static const Gauss made;
      return made;
    }
  };

  template <int D>
  static double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
                      ShapeFunctions<D>& out) {
    const Cell<D> cell(particles.corners[p]);
    detail::from_corners<D>(grid, particles.corners[p], cell.weight, cell.slope, out);
    return cell.volume;
  }
  // Corners move with the grid; the particle is their centroid.
  template <int D, class Velocity>
  static void move(const Grid<D>& grid, Particles<D>& particles, std::size_t p,
                   const Velocity& velocity, double dt) {
    thread_local ShapeFunctions<D> at;
    for (Vector<D>& corner : particles.corners[p]) {
      std::array<detail::AxisShape, D> axes;
      for (int d = 0; d < D; ++d)  // beyond the grid as the outermost cell goes on, as in shape()
        axes[d] = detail::linear_on(corner[d], grid.lower()[d], grid.h(), grid.cell(corner[d], d));
      detail::tensor_product<D>(grid, axes, at);
      corner += dt * at.value(velocity);
    }
    const Cell<D> cell(particles.corners[p]);
    particles.x[p].setZero();
    for (int a = 0; a < (1 << D); ++a) particles.x[p] += cell.weight[a] * particles.corners[p][a];
  }
};

}  // namespace recon::mpm
