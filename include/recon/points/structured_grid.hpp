// A regular grid of targets: origin, spacing and number of nodes per axis.
#pragma once

#include <array>
#include <vector>

#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon {

// Node (i, j, k) lies at origin + (i, j, k) * spacing; the first axis runs fastest in a flat index.
// Entries of axes at and above `dimension` are not used: these axes have one node, at 0.
template <class Scalar>
struct StructuredGrid {
  int dimension = 3;
  std::array<Scalar, max_dimension> origin{};
  std::array<Scalar, max_dimension> spacing{1, 1, 1};
  std::array<std::size_t, max_dimension> counts{1, 1, 1};

  std::size_t count(int axis) const { return axis < dimension ? counts[axis] : 1; }
  std::size_t size() const { return count(0) * count(1) * count(2); }

  std::array<std::size_t, max_dimension> index(std::size_t node) const {
    return {node % count(0), node / count(0) % count(1), node / (count(0) * count(1))};
  }
  Scalar coordinate(std::size_t i, int axis) const {
    return origin[axis] + static_cast<Scalar>(i) * spacing[axis];
  }

  // All nodes, one array per axis: pass them to points_of, or use view().
  class Nodes {
   public:
    std::array<std::vector<Scalar>, max_dimension> axes;
    int dimension;
    PointsView<Scalar> view() const { return points_of_axes(axes, dimension); }
  };
  Nodes nodes() const;

  // Throws InvalidArgument for a dimension outside 1..3, a spacing that is not positive and finite
  // or so small that neighbouring nodes could have the same coordinate (below twice the rounding of
  // the coordinates), an origin or a last node that is not finite, and more than 2^32 - 2 nodes.
  void validate() const;
};

// The grid of the given spacing whose nodes lie at whole multiples of it and cover the box. On a
// periodic axis the grid starts at the lower border and the spacing is shrunk so that a whole
// number of cells fills the period; the node at the upper border is left out, being the one at the
// lower. Throws InvalidArgument as validate() does.
template <class Scalar>
StructuredGrid<Scalar> covering_grid(const Box<Scalar>& box, Scalar spacing,
                                     const PeriodicDomain<Scalar>& domain = {});

extern template struct StructuredGrid<float>;
extern template struct StructuredGrid<double>;
extern template StructuredGrid<float> covering_grid(const Box<float>&, float,
                                                    const PeriodicDomain<float>&);
extern template StructuredGrid<double> covering_grid(const Box<double>&, double,
                                                     const PeriodicDomain<double>&);

}  // namespace recon
