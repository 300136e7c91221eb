// Neighbour search by looking at every particle: the reference that all other searches must equal.
//
// Semantics in search.hpp. The points are copied. Cost of a query O(n), plus sorting what was
// found; building O(n). For a few dozen particles nothing is faster. Wrong input (a query point or
// radius that is not finite, a negative radius, points of another dimension) throws
// InvalidArgument; k = 0 and an empty cloud find nothing.
#pragma once

#include "recon/neighbourhood/search.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon {

template <class S, int D>
class BruteForce {
 public:
  using Scalar = S;
  using Point = std::array<Scalar, D>;
  using Found = std::vector<Neighbour<Scalar>>;
  static constexpr int dimension = D;

  explicit BruteForce(const PointCloud<Scalar>& points);

  std::size_t size() const { return points_.size(); }
  void within(const Point& x, Scalar radius, Found& found) const;
  void nearest(const Point& x, std::size_t k, Found& found) const;
  void nearest_within(const Point& x, std::size_t k, Scalar radius, Found& found) const;
  void in_box(const Point& lower, const Point& upper, Found& found) const;

 private:
  std::vector<Point> points_;
};

static_assert(NeighbourSearch<BruteForce<double, 3>>);

extern template class BruteForce<float, 1>;
extern template class BruteForce<float, 2>;
extern template class BruteForce<float, 3>;
extern template class BruteForce<double, 1>;
extern template class BruteForce<double, 2>;
extern template class BruteForce<double, 3>;

}  // namespace recon
