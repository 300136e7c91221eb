// The tree of KdTree where recon is built with nanoflann.
#pragma once

#include <algorithm>
#include <nanoflann.hpp>
#include <utility>
#include <vector>

#include "neighbourhood/query.hpp"

namespace recon::detail {

#if NANOFLANN_VERSION >= 0x150
using SearchParameters = nanoflann::SearchParameters;
inline SearchParameters exact_search() {
  return {0.0f, false};
}
#else
using SearchParameters = nanoflann::SearchParams;
inline SearchParameters exact_search() {
  return {32, 0.0f, false};
}
#endif

// nanoflann's view of the points; the tree finds the bounding box itself.
template <class Scalar, int D>
struct NanoflannPoints {
  std::vector<std::array<Scalar, D>> x;

  std::size_t kdtree_get_point_count() const { return x.size(); }
  Scalar kdtree_get_pt(std::size_t i, std::size_t d) const { return x[i][d]; }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

// The distance of recon, so that the numbers nanoflann hands to a result set are the ones to
// compare.
template <class Scalar, int D>
struct NanoflannDistance {
  using ElementType = Scalar;
  using DistanceType = Scalar;
  const NanoflannPoints<Scalar, D>& points;

  explicit NanoflannDistance(const NanoflannPoints<Scalar, D>& all) : points(all) {}

  Scalar evalMetric(const Scalar* x, std::size_t i, std::size_t) const {
    std::array<Scalar, D> at;
    std::copy_n(x, D, at.begin());
    return squared_distance(at, points.x[i]);
  }
  template <class A, class B>
  Scalar accum_dist(A a, B b, std::size_t) const {
    return (a - b) * (a - b);
  }
};

// What nanoflann asks of a result set; `Take` is called as take(index, distance2). nanoflann passes
// on candidates nearer than worstDist() and skips branches beyond it.
template <class Scalar, class Take, class Worst>
struct NanoflannCollector {
  using DistanceType = Scalar;
  using IndexType = ParticleIndex;
  using CountType = std::size_t;
  Take take;
  Worst worst;

  bool addPoint(Scalar distance2, ParticleIndex index) {
    take(index, distance2);
    return true;
  }
  Scalar worstDist() const { return worst(); }
  bool full() const { return true; }
  bool empty() const { return false; }
  std::size_t size() const { return 0; }
  void sort() {}
};

template <class S, int D>
class NanoflannTree {
 public:
  using Point = std::array<S, D>;

  explicit NanoflannTree(std::vector<Point> x) : points_{std::move(x)}, tree_(D, points_, {12}) {}
  NanoflannTree(const NanoflannTree&) = delete;  // the tree refers to the points
  NanoflannTree& operator=(const NanoflannTree&) = delete;

  std::size_t size() const { return points_.x.size(); }

  // take(index, x_p, distance2) for at least all particles nearer than bound(), a squared distance
  // that may shrink on the way. There must be a particle.
  template <class Take, class Bound>
  void visit(const Point& x, const Take& take, const Bound& bound) const {
    const auto with_point = [&](ParticleIndex i, S distance2) { take(i, points_.x[i], distance2); };
    NanoflannCollector<S, decltype(with_point), Bound> collector{with_point, bound};
    static_cast<void>(tree_.findNeighbors(collector, x.data(), exact_search()));
  }

 private:
  NanoflannPoints<S, D> points_;
  nanoflann::KDTreeSingleIndexAdaptor<NanoflannDistance<S, D>, NanoflannPoints<S, D>, D,
                                      ParticleIndex>
      tree_;
};

}  // namespace recon::detail
