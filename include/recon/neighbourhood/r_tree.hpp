// Neighbour search with an R-tree (Boost.Geometry): boxes, and particles that come, go and move.
//
// Semantics in search.hpp. The points are copied. Building packs the tree in O(n log n); queries
// cost O(log n) plus what they find; insert, erase and move cost O(log n) each. Queries in boxes
// are its strength, the k nearest cost more than with KdTree. Where the k-th distance is shared by
// several particles (lattices), a second query within that distance decides which index wins.
//
// Particles keep the index they were given: 0, 1, ... for those of the constructor, any unused one
// for those inserted later (memory grows with the largest index in use). Updates and queries must
// not run at the same time.
//
// Where recon is built without Boost (RECON_WITH_BOOST=OFF) the constructors throw InvalidArgument
// that says so.
//
// Wrong input (points or radii that are not finite, a negative radius, an index in use, one that is
// not there, points of another dimension) throws InvalidArgument; k = 0 and an empty tree find
// nothing.
#pragma once

#include <memory>

#include "recon/neighbourhood/search.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon {

template <class S, int D>
class RTree {
 public:
  using Scalar = S;
  using Point = std::array<Scalar, D>;
  using Found = std::vector<Neighbour<Scalar>>;
  static constexpr int dimension = D;

  RTree();
  explicit RTree(const PointCloud<Scalar>& points);
  RTree(RTree&&) noexcept;
  RTree& operator=(RTree&&) noexcept;
  ~RTree();

  std::size_t size() const;  // particles that are there now
  void within(const Point& x, Scalar radius, Found& found) const;
  void nearest(const Point& x, std::size_t k, Found& found) const;
  void nearest_within(const Point& x, std::size_t k, Scalar radius, Found& found) const;
  void in_box(const Point& lower, const Point& upper, Found& found) const;

  bool contains(ParticleIndex particle) const;
  void insert(ParticleIndex particle, const Point& x);
  void erase(ParticleIndex particle);
  void move(ParticleIndex particle, const Point& x);

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

static_assert(NeighbourSearch<RTree<double, 3>>);

extern template class RTree<float, 1>;
extern template class RTree<float, 2>;
extern template class RTree<float, 3>;
extern template class RTree<double, 1>;
extern template class RTree<double, 2>;
extern template class RTree<double, 3>;

}  // namespace recon
