// Neighbour search with a regular grid of cells: the fastest for evenly spread particles.
//
// Semantics in search.hpp. The points are copied, sorted by cell (counting sort), in O(n), in
// parallel. `within` and `in_box` visit the cells that the ball or box overlaps; `nearest` visits
// shells of cells around the point until no unvisited cell can hold anything nearer.
//
// The cell size is a length. Without one, cells hold a few particles on average over their
// bounding box. Half the radius you will ask for is a good choice, and the radius itself is fine.
// Memory is O(n) whatever the particles do: there are at most 4 cells per particle (and 64), larger
// ones than asked for if need be. So one stray particle far away, or a cloud in tiny clusters, puts
// nearly all particles in a few cells, and queries cost up to O(n) there: still right, only slow.
// KdTree is the choice for those.
//
// find_neighbours with SearchMethod::cell_grid sorts in the same way, but treats many targets at a
// time, which is far faster than asking this class for one after another.
//
// Wrong input (a query point or radius that is not finite, a negative radius, a cell size that is
// not positive and finite, points of another dimension) throws InvalidArgument; k = 0 and an empty
// cloud find nothing.
#pragma once

#include <memory>

#include "recon/neighbourhood/search.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon {

namespace detail {
template <class S, int D>
class Cells;
}

template <class S, int D>
class CellGrid {
 public:
  using Scalar = S;
  using Point = std::array<Scalar, D>;
  using Found = std::vector<Neighbour<Scalar>>;
  static constexpr int dimension = D;

  explicit CellGrid(const PointCloud<Scalar>& points);  // cell size from the density
  CellGrid(const PointCloud<Scalar>& points, double cell_size, int threads = 0);
  CellGrid(CellGrid&&) noexcept;
  CellGrid& operator=(CellGrid&&) noexcept;
  ~CellGrid();

  std::size_t size() const;
  double cell_size() const;   // edge of a cell, after the limit on their number
  std::size_t cells() const;  // at most max(64, 4 size())

  void within(const Point& x, Scalar radius, Found& found) const;
  void nearest(const Point& x, std::size_t k, Found& found) const;
  void nearest_within(const Point& x, std::size_t k, Scalar radius, Found& found) const;
  void in_box(const Point& lower, const Point& upper, Found& found) const;

  // What the batch search reads; complete in the compiled part of recon only.
  const detail::Cells<Scalar, D>& sorted_cells() const;
  detail::Cells<Scalar, D>& sorted_cells();

 private:
  struct Grid;
  std::unique_ptr<Grid> grid_;
};

static_assert(NeighbourSearch<CellGrid<double, 3>>);

extern template class CellGrid<float, 1>;
extern template class CellGrid<float, 2>;
extern template class CellGrid<float, 3>;
extern template class CellGrid<double, 1>;
extern template class CellGrid<double, 2>;
extern template class CellGrid<double, 3>;

}  // namespace recon
