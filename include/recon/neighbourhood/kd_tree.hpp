// Neighbour search with a k-d tree (nanoflann): robust for any distribution of particles.
//
// Semantics in search.hpp. The points are copied. Building costs O(n log n), a query O(log n) plus
// what it finds: good for the k nearest, and for clouds whose density varies. in_box looks through
// the ball around the part of the box that holds particles: for long thin boxes RTree and CellGrid
// are better. A tree is built once; for particles that move, RTree can be updated. Where recon is
// built without nanoflann (RECON_WITH_NANOFLANN=OFF) it is a plain tree of recon's own, as fast to
// within a factor of two, with the same answers.
//
// Wrong input (a query point or radius that is not finite, a negative radius, points of another
// dimension) throws InvalidArgument; k = 0 and an empty cloud find nothing.
#pragma once

#include <memory>

#include "recon/neighbourhood/search.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon {

template <class S, int D>
class KdTree {
 public:
  using Scalar = S;
  using Point = std::array<Scalar, D>;
  using Found = std::vector<Neighbour<Scalar>>;
  static constexpr int dimension = D;

  explicit KdTree(const PointCloud<Scalar>& points);
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;
  ~KdTree();

  std::size_t size() const;
  void within(const Point& x, Scalar radius, Found& found) const;
  void nearest(const Point& x, std::size_t k, Found& found) const;
  void nearest_within(const Point& x, std::size_t k, Scalar radius, Found& found) const;
  void in_box(const Point& lower, const Point& upper, Found& found) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

static_assert(NeighbourSearch<KdTree<double, 3>>);

extern template class KdTree<float, 1>;
extern template class KdTree<float, 2>;
extern template class KdTree<float, 3>;
extern template class KdTree<double, 1>;
extern template class KdTree<double, 2>;
extern template class KdTree<double, 3>;

}  // namespace recon
