// The geometry of a reconstruction on a grid: which nodes a particle sees, along each axis.
//
// Let u be the position of a particle in units of the spacing, node i at u = i, and s = rho /
// spacing. The particle sees the nodes with |u - i| < s. With c = floor(u - s) these are among c +
// 1 .. c + n, n = ceil(2 s): all particles with the same c form a cell. Cells are numbered k = c +
// n, so that cell k sees the nodes k - n + 1 .. k, and the cells 0 .. N + n - 2 are those that see
// any of the N nodes at all. For cardinal splines of odd degree the cells are those of the grid;
// for even degrees a cell lies about each node.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "grid/row_kernel.hpp"
#include "recon/core/error.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/points/structured_grid.hpp"
#include "recon/shape/options.hpp"

namespace recon {

// What was asked that sums of moments cannot give, as an error that names it; none where they can.
template <class Scalar>
std::optional<InvalidArgument> beyond_moments(const StructuredGrid<Scalar>& grid,
                                              const Options& options, const GridApply& apply);

struct GridAxis {
  std::int64_t nodes = 1, cells = 1;
  int stencil = 1;                               // n
  double origin = 0, per_spacing = 1;            // u = (x - origin) * per_spacing
  double support = 1, per_support = 1, rho = 1;  // s, and as a length

  // The position of a coordinate in spacings from the lower border of cell 0: cell k is [k, k + 1).
  // (No floor(): that is a function call where the instruction set has none.)
  double place(double x) const { return (x - origin) * per_spacing + (stencil - support); }
  // The cell k of a coordinate; -1 where it sees no node.
  std::int64_t cell(double x) const {
    const double at = place(x);
    return at >= 0 && at < static_cast<double>(cells) ? static_cast<std::int64_t>(at) : -1;
  }
  // The offset (x - centre of cell k) / rho.
  double offset(double x, std::int64_t k) const {
    return (place(x) - static_cast<double>(k) + support - 0.5 * (stencil + 1)) * per_support;
  }
  // The offset (node a of the stencil - centre of the cell) / rho.
  double node_offset(int a) const { return (a - 0.5 * (stencil - 1)) / support; }
};

template <class Scalar>
struct GridPlan {
  StructuredGrid<Scalar> grid;
  Options options;  // without the particle weights
  WeightForm form;
  InstructionSet set;
  int components;
  std::array<GridAxis, max_dimension> axes;  // beyond the dimension: one node, seen by one cell
  std::array<std::vector<Scalar>, max_dimension> node_offsets;
  RowKernel<Scalar> kernel;
  WeightFunction::Function<Scalar> weight;
  Scalar least_weight;

  // Throws InvalidArgument for bad options and grids; nothing is asked that is beyond moments.
  GridPlan(const StructuredGrid<Scalar>& grid, const Options& options, int components);

  int dimension() const { return grid.dimension; }
  int quantities() const { return kernel.quantities(components); }
  std::array<int, max_dimension> stencil() const {
    return {axes[0].stencil, axes[1].stencil, axes[2].stencil};
  }
  std::size_t node(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * axes[1].nodes + j) * axes[0].nodes + i);
  }
};

extern template std::optional<InvalidArgument> beyond_moments(const StructuredGrid<float>&,
                                                              const Options&, const GridApply&);
extern template std::optional<InvalidArgument> beyond_moments(const StructuredGrid<double>&,
                                                              const Options&, const GridApply&);
extern template struct GridPlan<float>;
extern template struct GridPlan<double>;

}  // namespace recon
