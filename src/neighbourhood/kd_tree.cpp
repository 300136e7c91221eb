#include "recon/neighbourhood/kd_tree.hpp"

#include "core/instantiate.hpp"
#include "neighbourhood/query.hpp"
#ifdef RECON_WITH_NANOFLANN
#include "neighbourhood/nanoflann_tree.hpp"
#else
#include "neighbourhood/plain_tree.hpp"
#endif

namespace recon {

template <class S, int D>
struct KdTree<S, D>::Tree {
#ifdef RECON_WITH_NANOFLANN
  using Index = detail::NanoflannTree<S, D>;
#else
  using Index = detail::PlainTree<S, D>;
#endif
  Box<S> box;
  Index index;

  explicit Tree(const PointCloud<S>& cloud) : box(cloud.box()), index(detail::gathered<D>(cloud)) {}

  // take(index, x_p, distance2) for at least all particles with distance2 <= worst().
  template <class Take, class Worst>
  void visit(const Point& x, Take take, Worst worst) const {
    if (index.size() > 0) index.visit(x, take, [&] { return detail::widened(worst()); });
  }
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
  return tree_->index.size();
}

template <class S, int D>
void KdTree<S, D>::within(const Point& x, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  found.clear();
  const S radius2 = radius * radius;
  const auto take = [&](ParticleIndex i, const Point&, S distance2) {
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
  const auto take = [&](ParticleIndex i, const Point&, S distance2) { set.offer(i, distance2); };
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
  const auto take = [&](ParticleIndex i, const Point& particle, S) {
    if (detail::inside(particle, lower, upper)) found.push_back({i, 0});
  };
  tree_->visit(middle, take, [&] { return radius2; });
  detail::sort_by_index(found);
}

#define RECON_INSTANTIATE(S, D) template class KdTree<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon
