// The periodic images of one point, those nearest to a box first.
//
// To find the images of particles near x, a search is asked at x - shift * period for every shift
// that brings the point near enough to the box of all particles. The images come one at a time by
// increasing distance to the box, so that a search for the k nearest can stop as soon as no
// particle of a later image can be nearer. A support may exceed the period many times; only
// shifts beyond +-127, which ImageShift cannot hold, throw InvalidArgument.
//
// How: along each axis the shifts are ordered by the distance of that coordinate to the box; the
// sum of three such sequences is enumerated in order with a small heap. Cost O(log images) each.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/domain.hpp"

namespace recon::detail {

template <class Scalar, int D>
class PeriodicImages {
 public:
  using Point = std::array<Scalar, D>;

  struct Image {
    Point x;           // the point, moved by -shift * period
    ImageShift shift;  // of the particles that are near x seen from the point itself
    Scalar distance2;  // of x to the box, squared
  };

  PeriodicImages() = default;
  PeriodicImages(const PeriodicDomain<Scalar>& domain, const Box<Scalar>& box) {
    begin(domain, box);
  }
  // For points of another domain, with the memory that there is. The box must lie in the domain, and
  // so must the points given to start().
  void begin(const PeriodicDomain<Scalar>& domain, const Box<Scalar>& box) {
    domain_ = domain;
    box_ = box;
  }

  void start(const Point& x) {
    x_ = x;
    for (int d = 0; d < D; ++d) {
      axes_[d].steps.clear();
      axes_[d].above = 1;
      axes_[d].below = -1;
      axes_[d].zero_taken = false;
    }
    waiting_.clear();
    push({});
  }

  // The nearest image not given yet, if there is one at squared distance limit2 or less.
  bool next(Scalar limit2, Image& image) {
    if (waiting_.empty()) return false;
    const Combination nearest = waiting_.front();
    // The margin covers compilers that fuse the multiplications of a squared distance with its sum.
    if (nearest.distance2 > limit2 * (1 + 16 * std::numeric_limits<Scalar>::epsilon()))
      return false;
    std::pop_heap(waiting_.begin(), waiting_.end(), farther);
    waiting_.pop_back();
    image.shift = {};
    image.distance2 = nearest.distance2;
    for (int d = 0; d < D; ++d) {
      const Step& step = axes_[d].steps[nearest.at[d]];
      require(step.shift >= -most_shift && step.shift <= most_shift, "shift of a periodic image",
              step.shift, "must be from -127 to 127 (the support is too large for the period)");
      image.x[d] = step.x;
      image.shift[d] = static_cast<std::int8_t>(step.shift);
    }
    // Each combination has one predecessor: the one with its first nonzero place lowered by one.
    for (int d = 0; d < D; ++d) {
      auto at = nearest.at;
      ++at[d];
      push(at);
      if (nearest.at[d] != 0) break;
    }
    return true;
  }

 private:
  static constexpr int most_shift = 127;

  // One shift along one axis.
  struct Step {
    int shift;
    Scalar x, distance2;
  };
  struct Axis {
    std::vector<Step> steps;  // by increasing distance, as far as they were asked for
    int above, below;         // the next positive and negative shift; distances grow with them
    bool zero_taken;
  };
  using Places = std::array<std::uint16_t, D>;
  struct Combination {
    Scalar distance2;
    Places at;  // place in the steps of each axis
  };
  static bool farther(const Combination& a, const Combination& b) {
    return a.distance2 > b.distance2;
  }

  Step step(int d, int shift) const {
    const Scalar x = shift == 0 ? x_[d] : x_[d] - static_cast<Scalar>(shift) * domain_.period(d);
    const Scalar outside = std::max({Scalar(0), box_.lower[d] - x, x - box_.upper[d]});
    return {shift, x, outside * outside};
  }

  void grow(int d) {
    Axis& axis = axes_[d];
    if (!domain_.periodic[d]) {
      axis.steps.push_back(step(d, 0));
      return;
    }
    Step best = step(d, axis.above);
    const Step below = step(d, axis.below);
    if (below.distance2 < best.distance2) best = below;
    if (!axis.zero_taken) {
      const Step zero = step(d, 0);
      if (zero.distance2 <= best.distance2) best = zero;
    }
    if (best.shift > 0) ++axis.above;
    if (best.shift < 0) --axis.below;
    if (best.shift == 0) axis.zero_taken = true;
    axis.steps.push_back(best);
  }

  void push(const Places& at) {
    Combination combination{0, at};
    for (int d = 0; d < D; ++d) {
      if (!domain_.periodic[d] && at[d] > 0) return;
      while (axes_[d].steps.size() <= at[d]) grow(d);
      combination.distance2 += axes_[d].steps[at[d]].distance2;
    }
    waiting_.push_back(combination);
    std::push_heap(waiting_.begin(), waiting_.end(), farther);
  }

  PeriodicDomain<Scalar> domain_;
  Box<Scalar> box_;
  Point x_{};
  std::array<Axis, D> axes_;
  std::vector<Combination> waiting_;
};

}  // namespace recon::detail
