// The background grid: square cells of edge h that fill a box.
//
// A point belongs to the cell whose half-open box holds it. Points at or beyond the outer faces
// belong to the outermost cells, whose linear functions continue there. So a point on an edge, or
// outside of the box by rounding, is treated like its neighbours.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "recon/mpm/types.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon::mpm {

template <int D>
class Grid {
 public:
  Grid() = default;
  // Throws InvalidArgument unless h > 0 and upper - lower is a whole number of cells on each axis.
  Grid(const Vector<D>& lower, const Vector<D>& upper, double h) : lower_(lower), h_(h) {
    recon::detail::require(h > 0 && std::isfinite(h), "grid spacing", h,
                           "must be positive and finite");
    nodes_.dimension = D;
    for (int d = 0; d < D; ++d) {
      const double cells = (upper[d] - lower[d]) / h;
      recon::detail::require(
          cells > 0.5 && cells < 1e9 && std::abs(cells - std::round(cells)) < 1e-6 * cells,
          "edge of the grid in cells", cells, "must be a whole number of cells, at least one");
      cells_[d] = static_cast<int>(std::lround(cells));
      nodes_.origin[d] = lower[d];
      nodes_.spacing[d] = h;
      nodes_.counts[d] = static_cast<std::size_t>(cells_[d]) + 1;
    }
    nodes_.validate();
  }

  double h() const { return h_; }
  int cells(int d) const { return cells_[d]; }
  std::size_t size() const { return nodes_.size(); }  // number of nodes
  const StructuredGrid<double>& nodes() const { return nodes_; }
  const Vector<D>& lower() const { return lower_; }
  double upper(int d) const { return lower_[d] + cells_[d] * h_; }

  int cell(double x, int d) const {
    const double cell = std::floor((x - lower_[d]) / h_);
    return static_cast<int>(std::clamp(cell, 0.0, cells_[d] - 1.0));
  }
  double node(int i, int d) const { return lower_[d] + i * h_; }
  Vector<D> position(std::size_t node) const {
    const auto index = nodes_.index(node);
    Vector<D> x;
    for (int d = 0; d < D; ++d) x[d] = this->node(static_cast<int>(index[d]), d);
    return x;
  }
  // The number of the node with these indices.
  std::uint32_t number(const std::array<int, D>& index) const {
    std::size_t number = 0;
    for (int d = D - 1; d >= 0; --d)
      number = number * nodes_.counts[d] + static_cast<std::size_t>(index[d]);
    return static_cast<std::uint32_t>(number);
  }

  // Whether a point lies in the box, up to a millionth of a cell.
  bool contains(const Vector<D>& x) const {
    for (int d = 0; d < D; ++d)
      if (!(x[d] > lower_[d] - 1e-6 * h_ && x[d] < upper(d) + 1e-6 * h_)) return false;
    return true;
  }

 private:
  Vector<D> lower_ = Vector<D>::Zero();
  double h_ = 1;
  std::array<int, D> cells_{};
  StructuredGrid<double> nodes_;
};

}  // namespace recon::mpm
