#include "recon/neighbourhood/kd_tree.hpp"

#include <nanoflann.hpp>

#include "core/instantiate.hpp"
#include "neighbourhood/query.hpp"

namespace recon {

namespace {

#if NANOFLANN_VERSION >= 0x150
using SearchParameters = nanoflann::SearchParameters;
SearchParameters exact_search() {
  return {0.0f, false};
}
#else
using SearchParameters = nanoflann::SearchParams;
SearchParameters exact_search() {
  return {32, 0.0f, false};
}
#endif

// nanoflann's view of the points; the tree finds the bounding box itself.
template <class Scalar, int D>
struct Points {
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
struct Distance {
  using ElementType = Scalar;
  using DistanceType = Scalar;
  const Points<Scalar, D>& points;

  explicit Distance(const Points<Scalar, D>& all) : points(all) {}

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
struct Collector {
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

}  // namespace

template <class S, int D>
struct KdTree<S, D>::Tree {
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Distance<S, D>, Points<S, D>, D, ParticleIndex>;

  Points<S, D> points;
  Box<S> box;
  Index index;

  explicit Tree(const PointCloud<S>& cloud)
      : points{detail::gathered<D>(cloud)}, box(cloud.box()), index(D, points, {leaf_size}) {}

  // take(index, distance2) for at least all particles with distance2 <= worst().
  template <class Take, class Worst>
  void visit(const Point& x, Take take, Worst worst) const {
    if (points.x.empty()) return;
    const auto wide = [&] { return detail::widened(worst()); };
    Collector<S, Take, decltype(wide)> collector{take, wide};
    static_cast<void>(index.findNeighbors(collector, x.data(), exact_search()));
  }

  static constexpr std::size_t leaf_size = 12;
};

template <class S, int D>
KdTree<S, D>::KdTree(const PointCloud<S>& points) : tree_(std::make_unique<Tree>(points)) {}
template <class S, int D>
KdTree<S, D>::KdTree(KdTree&&) noexcept = default;
template <class S, int D>
KdTree<S, D>& KdTree<S, D>::operator=(KdTree&&) noexcept = default;
template <class S, int D>
KdTree<S, D>::~KdTree() = default;

template <class S, int D>
std::size_t KdTree<S, D>::size() const {
  return tree_->points.x.size();
}

template <class S, int D>
void KdTree<S, D>::within(const Point& x, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  found.clear();
  const S radius2 = radius * radius;
  const auto take = [&](ParticleIndex i, S distance2) {
    if (distance2 <= radius2) found.push_back({i, distance2});
  };
  tree_->visit(x, take, [&] { return radius2; });
  detail::sort_by_index(found);
}

template <class S, int D>
void KdTree<S, D>::nearest(const Point& x, std::size_t k, Found& found) const {
  nearest_within(x, k, std::numeric_limits<S>::max(), found);
}

template <class S, int D>
void KdTree<S, D>::nearest_within(const Point& x, std::size_t k, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  detail::NearestSet<S> set(found, std::min(k, size()), radius * radius);
  if (k == 0) return;
  const auto take = [&](ParticleIndex i, S distance2) { set.offer(i, distance2); };
  tree_->visit(x, take, [&] { return set.worst(); });
  set.sort();
}

template <class S, int D>
void KdTree<S, D>::in_box(const Point& lower, const Point& upper, Found& found) const {
  detail::require_finite(lower, "lower corner");
  detail::require_finite(upper, "upper corner");
  found.clear();
  // The ball around what the box has in common with the box of all particles.
  const Box<S>& box = tree_->box;
  Point middle, corner;
  for (int d = 0; d < D; ++d) {
    const S low = std::max(lower[d], box.lower[d]), high = std::min(upper[d], box.upper[d]);
    if (!(low <= high)) return;
    middle[d] = low + (high - low) / 2;
    corner[d] = middle[d] + std::max(middle[d] - low, high - middle[d]);
  }
  const S radius2 = detail::widened(squared_distance(middle, corner));
  const auto take = [&](ParticleIndex i, S) {
    if (detail::inside(tree_->points.x[i], lower, upper)) found.push_back({i, 0});
  };
  tree_->visit(middle, take, [&] { return radius2; });
  detail::sort_by_index(found);
}

#define RECON_INSTANTIATE(S, D) template class KdTree<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon
