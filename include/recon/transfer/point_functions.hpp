// The functions N_i of a grid at points: S_i = N_i(x), G_i = grad N_i(x).
//
//   LinearFunctions        the original material point method (Sulsky, Chen, Schreyer 1994)
//   SplineFunctions<P>     cardinal B-splines of degree P = 2, 3 about the nodes (Steffen, Kirby,
//                          Berzins 2008; Andersen, Andersen 2007, eq. 23)
//   MomentSplineFunctions  quadratic splines with the gradients of MLS-MPM (Hu et al. 2018)
//   NineNodeFunctions      quadratic elements of 2 x 2 cells: 3 nodes in 1-D, 27 in 3-D
//   EightNodeFunctions     serendipity elements of 2 x 2 cells without the node in the middle; 2-D
//   CellFunctions<P>       nodes seen through the cells (staggered grid: Liang, Zhang, Liu 2019): with
//                          k_c the B-spline of degree P = 1, 2 about the centre x_c of cell c,
//                          S_i = sum_c k_c(x) N_i(x_c) and G_i = sum_c k_c(x) grad N_i(x_c) for the
//                          linear functions N_i. G is not the gradient of S, but has the slope of
//                          linear fields, and is that of the spline of degree P + 1 on one axis
//
// (Elements: Andersen, Andersen 2007, section 3.4.) All of them live on the same nodes, so that
// they are compared at the same number of unknowns. Elements need an even number of cells along
// each axis; their functions are negative in parts, so the mass of a node may be negative.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   const recon::SplineFunctions<3> cubic{{recon::SplineBorder::corrected}};
//   recon::SplineFunctions<3>::Nodes<2> at;  // at most 16 nodes, no memory of the heap
//   cubic.at(grid, x, at);
//   const double density = at.value(nodal_density);
// ```
//
// Splines reach one node beyond the faces of the grid, and there are three ways to end them:
//   corrected     the value of that node is 2 u_0 - u_1: its function goes to the two nodes next
//                 to it, twice and minus once. Functions stay positive, sum to one, reproduce
//                 linear fields and are interpolating at the face, where boundaries hold values
//                 (the functions of Steffen, Kirby, Berzins 2008)
//   extra_column  that node is held at zero: its function is lost (Andersen, Andersen 2007). Near
//                 the face the sum is below one
//   linear_cells  linear functions in the outermost cells, splines inside; not continuous between
//
// A point beyond the grid is treated as the nearest one on its face, whatever the functions; ask
// CartesianGrid::contains() where that would hide an error. The coordinates of a point, anything
// with x[d], must be finite: else InvalidArgument.
//
// Functions are a small struct (the concept NodalFunctions in scatter.hpp): Nodes<D> is the type of
// what they give in D dimensions; at(grid, x, out) writes it; nodes_along(grid, x, d) returns the
// first and the last node that they touch on an axis; check(grid, x) throws what at() would throw,
// and does nothing else. Those that are products of functions of the axes also have axes(), which
// returns these.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "recon/transfer/node_functions.hpp"

namespace recon {

enum class SplineBorder { corrected, extra_column, linear_cells };
std::string_view name_of(SplineBorder border);

namespace detail {

// What functions of an axis ask of a grid is what CartesianGrid has of these names: lower(), h(),
// inverse_h(), cells(d), cell(x, d), node(i, d), require_coordinate(x, d).

// A point on the edge of its cell, or beyond it by rounding, is treated as lying inside the cell by
// this part of its edge. So every node that gets a force from the gradient at the point also gets
// some of its mass, and with it its velocity.
inline constexpr double hair = 1e-14;
// x where it lies between a hair and `upper`, else the nearer of these. (std::clamp takes
// references, and code of a GPU has none to a constant of the processor.)
constexpr double clamp_by_hair(double x, double upper) {
  const double lower = hair;
  return std::clamp(x, lower, upper);
}

// The linear functions of a cell; xi runs from 0 to 1 over it. Here and below `per_h` is 1 / h.
template <class Count = Exactly<2>>
constexpr AxisFunctions<Count> linear_axis(double xi, double per_h, int cell) {
  AxisFunctions<Count> axis;
  axis.first = cell;
  axis.set_count(2);
  axis.S[0] = 1 - xi;
  axis.S[1] = xi;
  axis.G[0] = -per_h;
  axis.G[1] = per_h;
  return axis;
}
// At s cells from the lower face.
template <class Count = Exactly<2>>
constexpr AxisFunctions<Count> linear_axis_at(double s, double per_h, int cell) {
  return linear_axis<Count>(clamp_by_hair(s - cell, 1 - hair), per_h, cell);
}

// The quadratic functions of the element that spans cells 2 e and 2 e + 1; xi runs from
// -1 to 1 over it.
inline AxisFunctions<Exactly<3>> quadratic_axis_at(double x, double lower, double h, int cell) {
  AxisFunctions<Exactly<3>> axis;
  axis.first = cell / 2 * 2;
  const double xi = std::clamp((x - lower) / h - axis.first - 1, -1 + hair, 1 - hair);
  axis.S[0] = xi * (xi - 1) / 2;
  axis.S[1] = (1 - xi) * (1 + xi);
  axis.S[2] = xi * (xi + 1) / 2;
  axis.G[0] = (xi - 0.5) / h;
  axis.G[1] = -2 * xi / h;
  axis.G[2] = (xi + 0.5) / h;
  return axis;
}

// Ends splines at the faces: the function of the node before the first one goes to the first two
// nodes, and that of the node beyond the last one to the last two.
template <class Count>
constexpr void end_splines(AxisFunctions<Count>& axis, int cells, SplineBorder border) {
  const double twice = border == SplineBorder::corrected ? 2 : 0, once = twice / 2;
  const auto give = [&](int from, int next, int after) {
    for (auto* value : {&axis.S, &axis.G}) {
      (*value)[next] += twice * (*value)[from];
      (*value)[after] -= once * (*value)[from];
    }
  };
  if (axis.first < 0) {
    give(0, 1, 2);
    for (auto* value : {&axis.S, &axis.G})
      std::copy(value->begin() + 1, value->begin() + axis.count, value->begin());
    ++axis.first;
    --axis.count;
  }
  if (axis.first + axis.count - 1 > cells) {
    const int last = axis.count - 1;
    give(last, last - 1, last - 2);
    --axis.count;
  }
}

// The B-splines of degree 1 or 2 about the centres of cells: k of the cells first, first + 1, ..., of
// which the first may be -1 and the last one beyond the grid. They sum to one.
template <int degree>
struct CellSplines {
  static_assert(degree == 1 || degree == 2);
  static constexpr int count = degree + 1;
  int first;
  std::array<double, count> k;

  // At s cells from the lower face.
  CellSplines(double s, int cells) {
    s = clamp_by_hair(s, cells * (1 - hair));
    if constexpr (degree == 1) {
      first = static_cast<int>(s + 0.5) - 1;
      const double z = s - 0.5 - first;
      k = {1 - z, z};
    } else {
      const int cell = std::min(static_cast<int>(s), cells - 1);
      const double z = s - 0.5 - cell;
      first = cell - 1;
      k = {(0.5 - z) * (0.5 - z) / 2, 0.75 - z * z, (0.5 + z) * (0.5 + z) / 2};
    }
  }
};

// A cell has the mean of its two nodes. Where a cell beyond a face counts, its outer node has
// 2 u_0 - u_1 as with splines: the cell is mirrored about the face.
template <int degree>
AxisFunctions<AtMost<degree + 2>> cell_axis_at(double s, double per_h, int cells,
                                               SplineBorder border) {
  AxisFunctions<AtMost<degree + 2>> axis;
  const int cell = std::clamp(static_cast<int>(s), 0, cells - 1);
  if (border == SplineBorder::linear_cells && (cell == 0 || cell == cells - 1))
    return linear_axis_at<AtMost<degree + 2>>(s, per_h, cell);
  const CellSplines<degree> at(s, cells);
  axis.first = at.first;
  axis.set_count(degree + 2);
  for (int n = 0; n < degree + 2; ++n) {
    const double before = n > 0 ? at.k[n - 1] : 0, after = n <= degree ? at.k[n] : 0;
    axis.S[n] = (before + after) / 2;
    axis.G[n] = (before - after) * per_h;
  }
  end_splines(axis, cells, border);
  return axis;
}

template <int degree>
constexpr AxisFunctions<AtMost<degree + 1>> spline_axis_at(double s, double per_h, int cells,
                                                           SplineBorder border) {
  static_assert(degree == 2 || degree == 3);
  AxisFunctions<AtMost<degree + 1>> axis;
  s = clamp_by_hair(s, cells * (1 - hair));
  const int cell = std::min(static_cast<int>(s), cells - 1);
  if (border == SplineBorder::linear_cells && (cell == 0 || cell == cells - 1))
    return linear_axis_at<AtMost<degree + 1>>(s, per_h, cell);
  axis.set_count(degree + 1);
  if constexpr (degree == 2) {
    const int nearest = static_cast<int>(s + 0.5);
    const double z = s - nearest;
    axis.first = nearest - 1;
    axis.S[0] = (0.5 - z) * (0.5 - z) / 2;
    axis.S[1] = 0.75 - z * z;
    axis.S[2] = (0.5 + z) * (0.5 + z) / 2;
    axis.G[0] = (z - 0.5) * per_h;
    axis.G[1] = -2 * z * per_h;
    axis.G[2] = (z + 0.5) * per_h;
  } else {
    const double xi = s - cell, rest = 1 - xi;
    axis.first = cell - 1;
    axis.S[0] = rest * rest * rest / 6;
    axis.S[1] = 2.0 / 3 - xi * xi * (2 - xi) / 2;
    axis.S[2] = 2.0 / 3 - rest * rest * (2 - rest) / 2;
    axis.S[3] = xi * xi * xi / 6;
    axis.G[0] = -rest * rest * (per_h / 2);
    axis.G[1] = xi * (1.5 * xi - 2) * per_h;
    axis.G[2] = -rest * (1.5 * rest - 2) * per_h;
    axis.G[3] = xi * xi * (per_h / 2);
  }
  end_splines(axis, cells, border);
  return axis;
}

struct LinearAxis {
  using AxisCount = Exactly<2>;
  template <class Grid>
  constexpr AxisFunctions<AxisCount> axis(const Grid& grid, double x, int d) const {
    return linear_axis_at((x - grid.lower()[d]) / grid.h(), grid.inverse_h(), grid.cell(x, d));
  }
};

struct ContinuedLinearAxis {
  using AxisCount = Exactly<2>;
  template <class Grid>
  constexpr AxisFunctions<AxisCount> axis(const Grid& grid, double x, int d) const {
    const int cell = grid.cell(x, d);
    return linear_axis((x - grid.lower()[d]) / grid.h() - cell, grid.inverse_h(), cell);
  }
};

// Throws InvalidArgument where elements of 2 x 2 cells do not fill the grid.
template <int D>
void require_even(const CartesianGrid<D>& grid, int d) {
  if (grid.cells(d) % 2 != 0) [[unlikely]]
    throw_invalid(std::string("cells of the grid along ") + "xyz"[d], grid.cells(d),
                  "must be even with elements of 2 x 2 cells");
}

struct QuadraticAxis {
  using AxisCount = Exactly<3>;
  template <int D>
  AxisFunctions<AxisCount> axis(const CartesianGrid<D>& grid, double x, int d) const {
    require_even(grid, d);
    return quadratic_axis_at(x, grid.lower()[d], grid.h(), grid.cell(x, d));
  }
  template <int D>
  static void check_grid(const CartesianGrid<D>& grid) {
    for (int d = 0; d < D; ++d) require_even(grid, d);
  }
};

template <int degree>
struct SplineAxis {
  using AxisCount = AtMost<degree + 1>;
  SplineBorder border = SplineBorder::corrected;
  template <class Grid>
  constexpr AxisFunctions<AxisCount> axis(const Grid& grid, double x, int d) const {
    grid.require_coordinate(x, d);
    return spline_axis_at<degree>((x - grid.lower()[d]) / grid.h(), grid.inverse_h(), grid.cells(d),
                                  border);
  }
};

struct MomentSplineAxis : SplineAxis<2> {
  template <class Grid>
  constexpr AxisFunctions<AxisCount> axis(const Grid& grid, double x, int d) const {
    AxisFunctions<AxisCount> axis = SplineAxis<2>::axis(grid, x, d);
    if (axis.count == 2) return axis;
    double second = 0;
    for (int k = 0; k < axis.count; ++k) {
      axis.G[k] = grid.node(axis.first + k, d) - x;
      const double offset = axis.G[k];
      second += axis.S[k] * offset * offset;
    }
    for (int k = 0; k < axis.count; ++k) axis.G[k] *= axis.S[k] / second;
    return axis;
  }
};

template <int degree>
struct CellAxis {
  using AxisCount = AtMost<degree + 2>;
  static constexpr int cell_degree = degree;
  SplineBorder border = SplineBorder::corrected;
  template <int D>
  AxisFunctions<AxisCount> axis(const CartesianGrid<D>& grid, double x, int d) const {
    grid.require_coordinate(x, d);
    return cell_axis_at<degree>((x - grid.lower()[d]) / grid.h(), grid.inverse_h(), grid.cells(d),
                                border);
  }
};

// Products of functions of the axes.
template <class Axis>
struct ProductFunctions : Axis {
  template <int D>
  using Nodes = NodeFunctions<D, typename Product<typename Axis::AxisCount, D>::Count>;

  template <int D, class Point>
  std::array<AxisFunctions<typename Axis::AxisCount>, D> axes(const CartesianGrid<D>& grid,
                                                              const Point& x) const {
    require_dimension<Point, D>();
    std::array<AxisFunctions<typename Axis::AxisCount>, D> all;
    for (int d = 0; d < D; ++d) all[d] = this->axis(grid, x[d], d);
    return all;
  }
  template <int D, class Point, class Count>
  void at(const CartesianGrid<D>& grid, const Point& x, NodeFunctions<D, Count>& out) const {
    static_assert(takes<Count, typename Product<typename Axis::AxisCount, D>::Count>,
                  "these functions have more nodes than the object takes: use their type Nodes<D>");
    tensor_product<D>(grid, axes(grid, x), out);
  }
  template <int D, class Point>
  std::pair<int, int> nodes_along(const CartesianGrid<D>& grid, const Point& x, int d) const {
    const auto axis = this->axis(grid, x[d], d);
    return {axis.first, axis.first + axis.count - 1};
  }
  template <int D, class Point>
  void check(const CartesianGrid<D>& grid, const Point& x) const {
    if constexpr (requires { Axis::check_grid(grid); }) Axis::check_grid(grid);
    grid.require_point(x);
  }
};

}  // namespace detail

using LinearFunctions = detail::ProductFunctions<detail::LinearAxis>;
// The same, but beyond the grid as the outermost cells go on, so that linear fields are reproduced
// there too: for corners of domains and what moves with them.
using ContinuedLinearFunctions = detail::ProductFunctions<detail::ContinuedLinearAxis>;
using NineNodeFunctions = detail::ProductFunctions<detail::QuadraticAxis>;
// SplineFunctions<3>{{border}} where the border is not `corrected`.
template <int degree>
using SplineFunctions = detail::ProductFunctions<detail::SplineAxis<degree>>;
// Quadratic splines with other gradients: G is the slope of the least-squares plane through the
// nodes, weighted by S, G_i = S_i D^-1 (x_i - x) with D = sum_i S_i (x_i - x)(x_i - x)^T, which is
// h^2 / 4 on quadratic splines (Hu et al. 2018, MLS-MPM). sum_i G_i = 0, and gradients of linear
// fields are exact. Next to a face only two nodes are left on an axis, and both kinds of gradient
// are the same.
using MomentSplineFunctions = detail::ProductFunctions<detail::MomentSplineAxis>;
// CellFunctions<2>{{border}} where the border is not `corrected`.
template <int degree>
using CellFunctions = detail::ProductFunctions<detail::CellAxis<degree>>;

// N = (1 + xi xi_i)(1 + eta eta_i)(xi xi_i + eta eta_i - 1) / 4 at corners,
// (1 - xi^2)(1 + eta eta_i) / 2 at the middle of sides, with xi and eta from -1 to 1 over the
// element. InvalidArgument in other dimensions than 2.
struct EightNodeFunctions {
  template <int D>
  using Nodes = NodeFunctions<D, Exactly<8>>;

  template <int D, class Point, class Count>
  void at(const CartesianGrid<D>& grid, const Point& x, NodeFunctions<D, Count>& out) const {
    static_assert(detail::takes<Count, Exactly<8>>,
                  "these functions have more nodes than the object takes: use their type Nodes<D>");
    detail::require_dimension<Point, D>();
    if constexpr (D == 2) {
      std::array<int, 2> first;
      SpaceVector<2> xi;
      for (int d = 0; d < 2; ++d) {
        detail::require_even(grid, d);
        first[d] = grid.cell(x[d], d) / 2 * 2;
        xi[d] = std::clamp((x[d] - grid.lower()[d]) / grid.h() - first[d] - 1, -1 + detail::hair,
                           1 - detail::hair);
      }
      out.resize(8);
      for (int n = 0, place = 0; place < 9; ++place) {
        const int i = place % 3 - 1, j = place / 3 - 1;
        if (i == 0 && j == 0) continue;
        const double a = 1 + i * xi[0], b = 1 + j * xi[1];
        out.node[n] = grid.number({first[0] + i + 1, first[1] + j + 1});
        if (i != 0 && j != 0) {
          out.S[n] = a * b * (a + b - 3) / 4;
          out.G[n] =
              SpaceVector<2>(i * b * (2 * a + b - 3), j * a * (a + 2 * b - 3)) / (4 * grid.h());
        } else if (i == 0) {
          out.S[n] = (1 - xi[0] * xi[0]) * b / 2;
          out.G[n] = SpaceVector<2>(-2 * xi[0] * b, j * (1 - xi[0] * xi[0])) / (2 * grid.h());
        } else {
          out.S[n] = (1 - xi[1] * xi[1]) * a / 2;
          out.G[n] = SpaceVector<2>(i * (1 - xi[1] * xi[1]), -2 * xi[1] * a) / (2 * grid.h());
        }
        ++n;
      }
    } else {
      detail::throw_invalid("dimension of the 8-node elements", D, "must be 2");
    }
  }
  template <int D, class Point>
  std::pair<int, int> nodes_along(const CartesianGrid<D>& grid, const Point& x, int d) const {
    const int first = grid.cell(x[d], d) / 2 * 2;
    return {first, first + 2};
  }
  template <int D, class Point>
  void check(const CartesianGrid<D>& grid, const Point& x) const {
    if constexpr (D != 2) detail::throw_invalid("dimension of the 8-node elements", D, "must be 2");
    detail::QuadraticAxis::check_grid(grid);
    grid.require_point(x);
  }
};

}  // namespace recon
