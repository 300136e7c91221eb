// The grid of a particle-in-cell code: square cells of edge h that fill a box.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {2, 1}, 0.25);  // 8 x 4 cells, 9 x 5 nodes
//   std::vector<double> nodal_mass(grid.size());               // the arrays are yours
//   const auto place = grid.position(17);                      // of node 17
// ```
//
// Nodes lie at lower + h (i, j, k), and their numbers run along the first axis first. A point
// belongs to the cell whose half-open box holds it. Points at or beyond the outer faces belong to
// the outermost cells. So a point on an edge, or outside of the box by rounding, is treated like
// its neighbours; contains() tells which points lie outside.
//
// Lengths are in the unit of h. D is the number of space dimensions, 1, 2 or 3.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>

#include "recon/points/structured_grid.hpp"

namespace recon {

template <int D>
using SpaceVector = Eigen::Matrix<double, D, 1>;
template <int D>
using SpaceMatrix = Eigen::Matrix<double, D, D>;

namespace detail {

[[noreturn]] void throw_coordinate(double x, int axis);
[[noreturn]] void throw_no_cells();

// The index of the cell of an axis, of so many from `lower` on, that x belongs to.
constexpr int cell_of_axis(double x, double lower, double h, int cells) {
  return static_cast<int>(std::clamp((x - lower) / h, 0.0, cells - 1.0));
}
// Whether x lies on the axis, up to a millionth of a cell.
constexpr bool lies_on_axis(double x, double lower, double upper, double h) {
  return x > lower - 1e-6 * h && x < upper + 1e-6 * h;
}

// Whether a point can be one in D dimensions: false only where its type says another number of
// coordinates.
template <class Point, int D>
constexpr bool may_have_dimension() {
  if constexpr (requires { std::tuple_size<Point>::value; })
    return std::tuple_size_v<Point> == D;
  else if constexpr (requires { Point::SizeAtCompileTime; })
    return Point::SizeAtCompileTime == D || Point::SizeAtCompileTime == Eigen::Dynamic;
  else if constexpr (std::is_bounded_array_v<Point>)
    return std::extent_v<Point> == D;
  else
    return true;
}
template <class Point, int D>
constexpr void require_dimension() {
  static_assert(may_have_dimension<std::remove_cvref_t<Point>, D>(),
                "a point must have as many coordinates as the grid has dimensions");
}

}  // namespace detail

template <int D>
class CartesianGrid {
  static_assert(D >= 1 && D <= 3);

 public:
  // No cells and no nodes, and h = 0: something to assign a grid to. Throws InvalidArgument where a
  // point is asked for in it.
  CartesianGrid() {
    nodes_.dimension = D;
    nodes_.counts.fill(0);
  }
  // Throws InvalidArgument unless h is positive and finite, upper - lower is a whole number of
  // cells on each axis, at least one and up to a millionth of it, neighbouring nodes have different
  // coordinates, and there are at most 2^32 - 2 nodes.
  CartesianGrid(const SpaceVector<D>& lower, const SpaceVector<D>& upper, double h)
      : lower_(lower), h_(h), inverse_h_(1 / h) {
    detail::require(h > 0 && std::isfinite(h), "grid spacing", h, "must be positive and finite");
    nodes_.dimension = D;
    for (int d = 0; d < D; ++d) {
      const double cells = (upper[d] - lower[d]) / h;
      if (!(cells > 0.5 && cells < 1e9 && std::abs(cells - std::round(cells)) < 1e-6 * cells))
        detail::throw_invalid(std::string("edge of the grid along ") + "xyz"[d] + " in cells",
                              cells, "must be a whole number of cells, at least one");
      cells_[d] = static_cast<int>(std::lround(cells));
      nodes_.origin[d] = lower[d];
      nodes_.spacing[d] = h;
      nodes_.counts[d] = static_cast<std::size_t>(cells_[d]) + 1;
    }
    nodes_.validate();
  }

  double h() const { return h_; }
  double inverse_h() const { return inverse_h_; }  // 1 / h
  const SpaceVector<D>& lower() const { return lower_; }
  double upper(int d) const { return lower_[d] + cells_[d] * h_; }
  int cells(int d) const { return cells_[d]; }
  std::size_t cell_count() const {
    std::size_t count = 1;
    for (const int cells : cells_) count *= static_cast<std::size_t>(cells);
    return count;
  }
  std::size_t size() const { return nodes_.size(); }  // number of nodes
  // The nodes as targets of a reconstruction.
  const StructuredGrid<double>& nodes() const { return nodes_; }

  // Throws InvalidArgument for a coordinate that is not finite, and where the grid has no cells.
  void require_coordinate(double x, int d) const {
    // The first is true for all points near the grid, and so the only thing that is looked at.
    if (std::isfinite((x - lower_[d]) / h_)) [[likely]]
      return;
    if (!(h_ > 0)) detail::throw_no_cells();
    if (!std::isfinite(x)) detail::throw_coordinate(x, d);
  }
  // The same for all coordinates of a point, anything with x[d].
  template <class Point>
  void require_point(const Point& x) const {
    detail::require_dimension<Point, D>();
    double zero = 0;  // and NaN where a coordinate is not finite
    for (int d = 0; d < D; ++d) zero += x[d] - x[d];
    if (zero == 0 && h_ > 0) [[likely]]
      return;
    for (int d = 0; d < D; ++d) require_coordinate(x[d], d);
  }
  // The index along axis d of the cell that x belongs to. Throws as require_coordinate() does.
  int cell(double x, int d) const {
    require_coordinate(x, d);
    return detail::cell_of_axis(x, lower_[d], h_, cells_[d]);
  }
  // The number of the cell of a point, anything with x[d]; the first axis runs fastest, as in
  // cell_centres(nodes()).
  template <class Point>
  std::size_t cell_number(const Point& x) const {
    detail::require_dimension<Point, D>();
    std::size_t number = 0;
    for (int d = D - 1; d >= 0; --d)
      number =
          number * static_cast<std::size_t>(cells_[d]) + static_cast<std::size_t>(cell(x[d], d));
    return number;
  }

  // The coordinate along axis d of the nodes with index i there.
  double node(int i, int d) const { return lower_[d] + i * h_; }
  SpaceVector<D> position(std::size_t node) const {
    SpaceVector<D> x;
    for (int d = 0; d < D; ++d) {
      const std::size_t count = static_cast<std::size_t>(cells_[d]) + 1;
      x[d] = this->node(static_cast<int>(node % count), d);
      node /= count;
    }
    return x;
  }
  // The number of the node with these indices.
  std::uint32_t number(const std::array<int, D>& index) const {
    std::size_t number = 0;
    for (int d = D - 1; d >= 0; --d)
      number = number * nodes_.counts[d] + static_cast<std::size_t>(index[d]);
    return static_cast<std::uint32_t>(number);
  }

  // Whether a point lies in the box, up to a millionth of a cell; not so one that is not finite.
  template <class Point>
  bool contains(const Point& x) const {
    detail::require_dimension<Point, D>();
    for (int d = 0; d < D; ++d)
      if (!detail::lies_on_axis(x[d], lower_[d], upper(d), h_)) return false;
    return true;
  }

 private:
  SpaceVector<D> lower_ = SpaceVector<D>::Zero();
  double h_ = 0, inverse_h_ = 0;
  std::array<int, D> cells_{};
  StructuredGrid<double> nodes_;
};

}  // namespace recon
