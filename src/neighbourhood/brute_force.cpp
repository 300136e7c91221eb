#include "recon/neighbourhood/brute_force.hpp"

#include "core/instantiate.hpp"
#include "neighbourhood/query.hpp"

namespace recon {

template <class S, int D>
BruteForce<S, D>::BruteForce(const PointCloud<S>& points) : points_(detail::gathered<D>(points)) {}

template <class S, int D>
void BruteForce<S, D>::within(const Point& x, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  found.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const S distance2 = squared_distance(x, points_[i]);
    if (distance2 <= radius * radius) found.push_back({static_cast<ParticleIndex>(i), distance2});
  }
}

template <class S, int D>
void BruteForce<S, D>::nearest(const Point& x, std::size_t k, Found& found) const {
  nearest_within(x, k, std::numeric_limits<S>::max(), found);
}

template <class S, int D>
void BruteForce<S, D>::nearest_within(const Point& x, std::size_t k, S radius, Found& found) const {
  within(x, radius, found);
  k = std::min(k, found.size());
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(k), found.end(),
                    detail::nearer<S>);
  found.resize(k);
}

template <class S, int D>
void BruteForce<S, D>::in_box(const Point& lower, const Point& upper, Found& found) const {
  detail::require_finite(lower, "lower corner");
  detail::require_finite(upper, "upper corner");
  found.clear();
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (detail::inside(points_[i], lower, upper))
      found.push_back({static_cast<ParticleIndex>(i), 0});
}

#define RECON_INSTANTIATE(S, D) template class BruteForce<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon
