// What all searches share: checks of the query, margins for rounding, and the set of the k nearest.
//
// A tree or a grid only proposes candidates; squared_distance (or a comparison of coordinates)
// decides. So it may propose too many but never too few, and its own bounds are widened by the
// margins here: a relative one for the rounding of a few dozen operations, an absolute one for
// squares that underflow.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/neighbourhood/search.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

// Relative error that the sum of squares in a bound can have gathered (on the way down a tree, at
// most two roundings per level).
template <class Scalar>
inline constexpr Scalar bound_slack = 256 * std::numeric_limits<Scalar>::epsilon();

// A squared distance, widened: nothing whose true squared distance is at most distance2 has a bound
// computed elsewhere that is larger. Infinite stays infinite.
template <class Scalar>
Scalar widened(Scalar distance2) {
  return std::numeric_limits<Scalar>::min() + distance2 * (1 + bound_slack<Scalar>);
}

template <class Scalar, std::size_t D>
void require_finite(const std::array<Scalar, D>& x, const char* name) {
  for (std::size_t d = 0; d < D; ++d)
    if (!std::isfinite(x[d])) [[unlikely]]
      throw_invalid(std::string("coordinate ") + "xyz"[d] + " of the " + name, x[d],
                    "must be finite");
}

// A query point like those of a PointCloud: no squared distance between two of them overflows.
template <class Scalar, std::size_t D>
void require_query_point(const std::array<Scalar, D>& x) {
  require_finite(x, "query point");
  Scalar size2 = 0;
  for (const Scalar c : x) size2 += 4 * c * c;
  require(std::isfinite(size2), "squared size of the query point", size2, "must be representable");
}

template <class Scalar>
void require_radius(Scalar radius) {
  require(radius >= 0 && std::isfinite(radius), "radius", radius, "must be at least 0 and finite");
}

template <class Scalar, std::size_t D>
bool inside(const std::array<Scalar, D>& x, const std::array<Scalar, D>& lower,
            const std::array<Scalar, D>& upper) {
  for (std::size_t d = 0; d < D; ++d)
    if (!(lower[d] <= x[d] && x[d] <= upper[d])) return false;
  return true;
}

// The points of a cloud one after another, checked to have dimension D.
template <int D, class Scalar>
std::vector<std::array<Scalar, D>> gathered(const PointCloud<Scalar>& cloud) {
  require(cloud.dimension() == D, "dimension of the points", cloud.dimension(),
          "must be the dimension of the search");
  std::vector<std::array<Scalar, D>> points(cloud.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = cloud.template point<D>(i);
  return points;
}

template <class Scalar>
bool nearer(const Neighbour<Scalar>& a, const Neighbour<Scalar>& b) {
  return a.distance2 < b.distance2 || (a.distance2 == b.distance2 && a.index < b.index);
}

template <class Scalar>
void sort_by_index(std::vector<Neighbour<Scalar>>& found) {
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.index < b.index; });
}

// The k nearest of all particles offered, among those with distance2 <= limit2; ties go to the
// smaller index. Kept in `found` as a heap with the farthest in front.
template <class Scalar>
class NearestSet {
 public:
  NearestSet(std::vector<Neighbour<Scalar>>& found, std::size_t k,
             Scalar limit2 = std::numeric_limits<Scalar>::infinity())
      : found_(found), k_(k), limit2_(limit2) {
    found_.clear();
  }

  bool full() const { return found_.size() == k_; }

  // Nothing farther than this can enter.
  Scalar worst() const { return full() ? found_.front().distance2 : limit2_; }

  void offer(ParticleIndex index, Scalar distance2) {
    const Neighbour<Scalar> candidate{index, distance2};
    if (!full()) {
      if (!(distance2 <= limit2_)) return;
      found_.push_back(candidate);
      if (full()) std::make_heap(found_.begin(), found_.end(), nearer<Scalar>);
    } else if (nearer(candidate, found_.front())) {
      std::pop_heap(found_.begin(), found_.end(), nearer<Scalar>);
      found_.back() = candidate;
      std::push_heap(found_.begin(), found_.end(), nearer<Scalar>);
    }
  }

  void sort() { std::sort(found_.begin(), found_.end(), nearer<Scalar>); }

 private:
  std::vector<Neighbour<Scalar>>& found_;
  std::size_t k_;
  Scalar limit2_;
};

}  // namespace recon::detail
