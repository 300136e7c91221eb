// The particles around a few targets that are close to each other, collected once for all of them.
//
// Of particles in double the candidates are floats about the middle of the targets. A distance
// between two of them is off by at most `error_` (twice half a unit of Coarse<S>, and the roundings
// of three floats), its square by a relative 2^-20 more. So limits come in pairs: what measures at
// most `sure` is within a radius, and what measures more than `possible` is not. Between the two
// the coordinates decide, by distance2() and along_axis(). Of particles in float all is exact, and
// the two are one.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "neighbourhood/neighbour_key.hpp"
#include "neighbourhood/shared_by_targets.hpp"

namespace recon::detail {

template <class S, int D, bool periodic>
class Brick {
 public:
  using Point = std::array<S, D>;
  using Coding = NeighbourKey<periodic>;
  using Key = typename Coding::Key;

  struct Limits {
    float sure, possible;
  };
  enum class Outcome { collected, too_much_work, too_far };

  Brick(const SharedByTargets<S, D>& shared, CellBuffers<S, D, Key>& buffers)
      : shared_(shared),
        cells_(shared.grid->sorted_cells()),
        buffers_(buffers),
        images_(buffers.images) {
    give_room(std::max(least_room, buffers.place.size()) - beyond);
  }

  // Everything within the radius of any point of the box becomes a candidate. In a periodic domain
  // the radius must be a few periods at most.
  Outcome collect(const Point& lower, const Point& upper, S radius, std::int64_t work_limit) {
    candidates_.count = candidates_.work = 0;
    candidates_.work_limit = work_limit;
    images_.clear();
    error_ = 0;
    if constexpr (!periodic) {
      return add_image({}, lower, upper, radius);
    } else {
      ImageShift from{}, to{};
      for (int d = 0; d < D; ++d) {
        if (!shared_.domain.periodic[d]) continue;
        while (meets(lower, upper, radius, d, from[d] - 1)) --from[d];
        while (meets(lower, upper, radius, d, to[d] + 1)) ++to[d];
      }
      Outcome outcome = Outcome::collected;
      ImageShift shift = from;
      for (int d = 0; d < D && outcome == Outcome::collected;) {
        bool needed = true;
        Point low = moved(lower, shift), high = moved(upper, shift);
        for (int e = 0; e < D; ++e) needed = needed && meets(lower, upper, radius, e, shift[e]);
        if (needed) outcome = add_image(shift, low, high, radius);
        for (d = 0; d < D && shift[d] == to[d]; ++d) shift[d] = from[d];
        if (d < D) ++shift[d];
      }
      return outcome;
    }
  }

  // Are keys in the order of candidates in ascending order?
  bool in_order() const { return images_.size() <= 1 && cells_.numbered_by_place(); }
  // The measure of a squared distance, up to the roundings.
  float measure_of(double distance2) const {
    const double units = cells_.view().units;
    return static_cast<float>(std::min(distance2 * units * units, 1e38));
  }

  std::int64_t candidates() const { return candidates_.count; }
  std::int64_t work() const { return candidates_.work; }

  // For the squares of distances.
  Limits limits(S radius) const {
    if constexpr (std::is_same_v<S, float>) return {radius * radius, radius * radius};
    const double r = radius * cells_.view().units, off = std::sqrt(double(D)) * error_;
    return around(r > off ? (r - off) * (r - off) : -1, (r + off) * (r + off));
  }
  // For the largest distances along an axis.
  Limits limits_of_cube(S radius) const {
    if constexpr (std::is_same_v<S, float>) return {radius, radius};
    const double r = radius * cells_.view().units;
    return around(r > error_ ? r - error_ : -1, r + error_);
  }
  // Around the measure of one that is within the radius: what measures less than `sure` is nearer
  // than that one, and what measures more than `possible` is farther.
  Limits limits_of_measure(float measure, S radius) const {
    if constexpr (std::is_same_v<S, float>) return {measure, measure};
    const double m = measure, r = radius * cells_.view().units;
    const double slack = slack_within(r * r < 4 * m ? r : std::sqrt(m));
    return around(m - slack, m + slack);
  }

  // Those that measure at most `limit` from a target in the box, in order, into near().
  void look(const Point& x, float limit) {
    x_ = x;
    near_.count = 0;
    std::int64_t begin = 0;
    for (const Image& image : images_) {
      const Point seen = moved(x, image.shift);
      float at[D];
      for (int d = 0; d < D; ++d)
        at[d] = static_cast<float>(cells_.on_coarse_scale(seen[d], d) -
                                   static_cast<double>(image.centre[d]));
      shared_.kernels.near(candidates_, begin, image.end, at, limit, near_);
      begin = image.end;
    }
  }
  const NearArrays& near() const { return near_; }

  // The k that measure least into chosen(), in order or, with `ranked`, in no order. Of near()
  // there must be k at least, all within the radius. Those that may be the farthest of the chosen count
  // as far. See select_smallest().
  Smallest choose(std::int64_t k, float probably, bool ranked, S radius) {
    double slack = 0;
    if constexpr (!std::is_same_v<S, float>)
      slack = std::min(1.001 * slack_within(radius * cells_.view().units), 1e38);
    const FarArrays far{static_cast<float>(slack), buffers_.far.data()};
    if (near_.count <= shared_.kernels.most_ranked) {
      const auto& kernel = ranked ? shared_.kernels.rank_smallest : shared_.kernels.select_smallest;
      return kernel(near_, k, probably, rest_, buffers_.rank.data(), chosen_, far);
    }
    Smallest result{0, 0, std::numeric_limits<float>::infinity(), 0};
    float* const sorted = buffers_.rank.data();
    std::copy_n(near_.measure, near_.count, sorted);
    std::nth_element(sorted, sorted + (k - 1), sorted + near_.count);
    result.largest = sorted[k - 1];
    choose_up_to(result.largest);
    result.count = chosen_.count;
    const float* const next = std::min_element(sorted + k, sorted + near_.count);
    if (next < sorted + near_.count) result.next = *next;
    const float from = limits_of_measure(result.largest, radius).sure;
    for (std::int64_t i = 0; i < chosen_.count; ++i) {
      far.candidate[result.far] = chosen_.candidate[i];
      result.far += chosen_.measure[i] >= from;
    }
    return result;
  }
  // The largest squared distance of those that have just been chosen, and fetches what that needs.
  void fetch_far(const Smallest& chosen) const {
    if constexpr (!std::is_same_v<S, float>)
      for (std::int64_t i = 0; i < chosen.far; ++i)
        __builtin_prefetch(cells_.points().data() +
                           std::size_t{candidates_.place[buffers_.far[i]]} * D);
  }
  S farthest2(const Smallest& chosen) const {
    if constexpr (std::is_same_v<S, float>) return chosen.largest;
    S farthest2 = 0;
    for (std::int64_t i = 0; i < chosen.far; ++i)
      farthest2 = std::max(farthest2, distance2(buffers_.far[i]));
    return farthest2;
  }
  // Those that measure at most `limit`.
  void choose_up_to(float limit) {
    choose_if([limit](float measure, std::uint32_t) { return measure <= limit; });
  }
  // Those for which choice(measure, candidate) holds.
  template <class Choice>
  void choose_if(const Choice& choice) {
    chosen_.count = 0;
    for (std::int64_t i = 0; i < near_.count; ++i) {
      chosen_.measure[chosen_.count] = near_.measure[i];
      chosen_.candidate[chosen_.count] = near_.candidate[i];
      chosen_.count += choice(near_.measure[i], near_.candidate[i]);
    }
  }
  const NearArrays& chosen() const { return chosen_; }
  // How many measure less than each of the chosen; null where choose() has not counted that.
  const float* rank() const {
    return near_.count <= shared_.kernels.most_ranked ? buffers_.rank.data() : nullptr;
  }

  // Of the target that was looked at last, and a candidate.
  S distance2(std::uint32_t candidate) const {
    return squared_distance(moved(x_, shift_of(candidate)), particle(candidate));
  }
  S along_axis(std::uint32_t candidate) const {
    const Point seen = moved(x_, shift_of(candidate)), p = particle(candidate);
    S farthest = 0;
    for (int d = 0; d < D; ++d) farthest = std::max(farthest, std::abs(seen[d] - p[d]));
    return farthest;
  }
  Key key(std::uint32_t candidate) const {
    return Coding::of(cells_.index(candidates_.place[candidate]), shift_of(candidate));
  }

 private:
  using Image = CollectedImage<S>;
  static constexpr std::size_t beyond = 64;  // what the kernels may touch behind the last
  static constexpr std::size_t least_room = 1024;

  Point particle(std::uint32_t candidate) const {
    return cells_.point(candidates_.place[candidate]);
  }
  ImageShift shift_of(std::uint32_t candidate) const {
    if constexpr (!periodic) return {};
    std::size_t i = 0;
    while (images_[i].end <= candidate) ++i;
    return images_[i].shift;
  }

  // Where a point lies seen from the particles that are shifted.
  Point moved(Point x, const ImageShift& shift) const {
    if constexpr (periodic)
      for (int d = 0; d < D; ++d)
        if (shift[d] != 0) x[d] -= static_cast<S>(shift[d]) * shared_.domain.period(d);
    return x;
  }

  // May particles with this shift along an axis be within the radius of the box?
  bool meets(const Point& lower, const Point& upper, S radius, int d, int shift) const {
    if (!shared_.domain.periodic[d]) return shift == 0;
    const S move = static_cast<S>(shift) * shared_.domain.period(d), far = reach(radius);
    const auto& box = shared_.particles.box();
    return lower[d] - move - far <= box.upper[d] && upper[d] - move + far >= box.lower[d];
  }

  // By how much two measures can differ at most where the one that measures more is nearer than the
  // other, and the measured distances are at most r (on the coarse scale).
  double slack_within(double r) const {
    const double off = 2 * std::sqrt(double(D)) * error_;
    return off * (2 * r + off);
  }

  static Limits around(double sure, double possible) {
    constexpr double most = std::numeric_limits<float>::max(), rounding = 1.0 / (1 << 20);
    return {static_cast<float>(std::min(sure * (1 - rounding), most)),
            static_cast<float>(std::min(possible * (1 + rounding), most))};
  }

  Outcome add_image(const ImageShift& shift, const Point& lower, const Point& upper, S radius) {
    constexpr bool whole = !std::is_same_v<S, float>;  // is Coarse<S> a whole number?
    constexpr double eps = std::numeric_limits<double>::epsilon(), rounding = 1.0 / (1 << 22);
    constexpr double farthest = 1e18;  // on the coarse scale: squares must not overflow
    const CellView<S>& view = cells_.view();
    const auto far = static_cast<double>(reach(radius));
    CellBox<S> box;
    Image image{shift, {}, 0};
    double size = 0;  // how large the floats of targets and of particles become, together
    for (int d = 0; d < D; ++d) {
      const auto low = static_cast<double>(lower[d]), high = static_cast<double>(upper[d]);
      const double most = std::max(std::abs(low), std::abs(high));
      const double half = far * (1 + 4 * eps) +
                          16 * eps * (std::abs(view.lower[d]) + std::abs(view.upper[d]) + most);
      box.from[d] = cell_on_axis(low - half, view.lower[d], view.inverse, view.counts[d]);
      box.to[d] = cell_on_axis(high + half, view.lower[d], view.inverse, view.counts[d]);
      const double first = cells_.on_coarse_scale(lower[d], d),
                   last = cells_.on_coarse_scale(upper[d], d);
      if constexpr (whole) {
        if (!(std::max(std::abs(first), std::abs(last)) < farthest)) return Outcome::too_far;
        image.centre[d] = box.centre[d] =
            static_cast<Coarse<S>>(std::clamp(first / 2 + last / 2, 0.0, units_of_extent));
      }
      const auto centre = static_cast<double>(box.centre[d]);
      const double from = first - centre - far * view.units, to = last - centre + far * view.units;
      box.lower[d] = static_cast<float>(from - 2 * whole - std::abs(from) * rounding);
      box.upper[d] = static_cast<float>(to + 2 * whole + std::abs(to) * rounding);
      size = std::max(size, std::max(std::abs(first - centre), std::abs(last - centre)) +
                                std::min(std::max(std::abs(from), std::abs(to)), units_of_extent));
    }
    if (whole) error_ = std::max(error_, 1 + size * rounding);
    const CandidateArrays before = candidates_;
    for (;;) {
      const CollectResult result = shared_.kernels.collect(view, box, candidates_);
      if (result == CollectResult::too_much_work) return Outcome::too_much_work;
      if (result == CollectResult::complete) break;
      const auto more = 4 * static_cast<std::size_t>(candidates_.capacity);
      candidates_.count = before.count;
      candidates_.work = before.work;
      give_room(more);
    }
    image.end = candidates_.count;
    images_.push_back(image);
    return Outcome::collected;
  }

  // For so many candidates.
  void give_room(std::size_t count) {
    for (int d = 0; d < D; ++d) {
      buffers_.x[d].resize(count + beyond);
      candidates_.x[d] = buffers_.x[d].data();
    }
    for (auto* array :
         {&buffers_.place, &buffers_.candidate, &buffers_.chosen, &buffers_.rest, &buffers_.far})
      array->resize(count + beyond);
    for (auto* array :
         {&buffers_.measure, &buffers_.rank, &buffers_.chosen_measure, &buffers_.rest_measure})
      array->resize(count + beyond);
    candidates_.place = buffers_.place.data();
    candidates_.capacity = static_cast<std::int64_t>(count);
    near_ = {buffers_.measure.data(), buffers_.candidate.data()};
    chosen_ = {buffers_.chosen_measure.data(), buffers_.chosen.data()};
    rest_ = {buffers_.rest_measure.data(), buffers_.rest.data()};
  }

  const SharedByTargets<S, D>& shared_;
  const Cells<S, D>& cells_;
  CellBuffers<S, D, Key>& buffers_;
  CandidateArrays candidates_;
  NearArrays near_{}, chosen_{}, rest_{};
  std::vector<Image>& images_;
  double error_ = 0;
  Point x_{};
};

}  // namespace recon::detail
