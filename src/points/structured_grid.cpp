#include "recon/points/structured_grid.hpp"
#include "core/instantiate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace recon {

namespace {

using detail::require;

constexpr double most_nodes = 4294967294.0;  // 2^32 - 2: node numbers are 32-bit

std::string along(const char* what, int axis) {
  return std::string(what) + " along " + "xyz"[axis];
}

// Two neighbours have different coordinates, whatever the rounding of these, where the spacing is
// twice as large as the rounding of the largest.
template <class Scalar>
void require_distinct_nodes(const StructuredGrid<Scalar>& grid, int axis) {
  const Scalar last = grid.coordinate(grid.counts[axis] - 1, axis);
  if (!std::isfinite(last))
    detail::throw_invalid(along("last node of the grid", axis), last, "must be finite");
  const Scalar rounding = std::numeric_limits<Scalar>::epsilon() *
                          std::max(std::abs(grid.origin[axis]), std::abs(last));
  if (grid.counts[axis] > 1 && !(grid.spacing[axis] >= 2 * rounding))
    detail::throw_invalid(along("grid spacing", axis), grid.spacing[axis],
                          "must be larger: from the origin " + detail::to_text(grid.origin[axis]) +
                              " to " + detail::to_text(last) +
                              " neighbouring nodes would have the same coordinate in " +
                              (sizeof(Scalar) == sizeof(float) ? "float" : "double"));
}

}  // namespace

template <class Scalar>
void StructuredGrid<Scalar>::validate() const {
  require(dimension >= 1 && dimension <= max_dimension, "dimension of the grid", dimension,
          "must be 1, 2 or 3");
  double nodes = 1;
  for (int d = 0; d < dimension; ++d) {
    if (!(std::isfinite(spacing[d]) && spacing[d] > 0))
      detail::throw_invalid(along("grid spacing", d), spacing[d], "must be positive and finite");
    if (!std::isfinite(origin[d]))
      detail::throw_invalid(along("grid origin", d), origin[d], "must be finite");
    if (counts[d] < 1)
      detail::throw_invalid(along("grid nodes", d), counts[d], "must be at least 1");
    require_distinct_nodes(*this, d);
    nodes *= static_cast<double>(counts[d]);
  }
  require(nodes <= most_nodes, "grid nodes", nodes,
          "must be at most 2^32 - 2 (choose a larger spacing)");
}

template <class Scalar>
typename StructuredGrid<Scalar>::Nodes StructuredGrid<Scalar>::nodes() const {
  validate();
  Nodes nodes;
  nodes.dimension = dimension;
  for (int d = 0; d < dimension; ++d) nodes.axes[d].reserve(size());
  for (std::size_t n = 0; n < size(); ++n) {
    const auto at = index(n);
    for (int d = 0; d < dimension; ++d) nodes.axes[d].push_back(coordinate(at[d], d));
  }
  return nodes;
}

template <class Scalar>
StructuredGrid<Scalar> covering_grid(const Box<Scalar>& box, Scalar spacing,
                                     const PeriodicDomain<Scalar>& domain) {
  require(std::isfinite(spacing) && spacing > 0, "grid spacing", spacing,
          "must be positive and finite");
  require(!box.is_empty(), "box of the grid", "empty", "must contain a point");
  StructuredGrid<Scalar> grid;
  grid.dimension = box.dimension;
  double nodes = 1;
  for (int d = 0; d < box.dimension; ++d) {
    double count;
    if (domain.periodic[d]) {
      // Round up, but do not let rounding of period / spacing add a cell.
      count =
          std::max(1.0, std::ceil(static_cast<double>(domain.period(d)) / spacing * (1 - 1e-6)));
      grid.origin[d] = domain.lower[d];
      grid.spacing[d] = domain.period(d) / static_cast<Scalar>(count);
    } else {
      const double first = std::floor(static_cast<double>(box.lower[d]) / spacing + 1e-6);
      const double last =
          std::max(first, std::ceil(static_cast<double>(box.upper[d]) / spacing - 1e-6));
      count = last - first + 1;
      grid.origin[d] = static_cast<Scalar>(first * spacing);
      grid.spacing[d] = spacing;
    }
    nodes *= count;
    require(nodes <= most_nodes, "grid spacing", spacing,
            "gives more than 2^32 - 2 nodes: choose a larger one");
    grid.counts[d] = static_cast<std::size_t>(count);
  }
  grid.validate();
  return grid;
}

RECON_FLOAT(template struct StructuredGrid<float>;)
template struct StructuredGrid<double>;
RECON_FLOAT(template StructuredGrid<float> covering_grid(const Box<float>&, float,
                                                         const PeriodicDomain<float>&);)
template StructuredGrid<double> covering_grid(const Box<double>&, double,
                                              const PeriodicDomain<double>&);

}  // namespace recon
