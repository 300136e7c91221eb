// Finds the neighbours of one group of targets after another by cells.
//
// What a rule asks of targets: how far to collect, when to collect again with a larger guess, and
// when to leave a target to find_neighbours_with.hpp, which serves it from the grid or from a tree.
#pragma once

#include <functional>
#include <memory>

#include "neighbourhood/any_search.hpp"
#include "neighbourhood/brick.hpp"
#include "neighbourhood/key_order.hpp"

namespace recon::detail {

template <class S, int D, bool periodic>
class CellTargets {
 public:
  using Point = std::array<S, D>;
  using Coding = NeighbourKey<periodic>;
  using Key = typename Coding::Key;
  using Target = GroupTarget<S, D>;
  using Limits = typename Brick<S, D, periodic>::Limits;
  using Found = std::function<void(std::size_t target, S support)>;

  CellTargets(SharedByTargets<S, D>& shared, CellBuffers<S, D, Key>& buffers)
      : shared_(shared),
        brick_(shared, buffers),
        row_(shared.kernels, buffers),
        near2_(shared.start * shared.start) {}

  // The keys of the neighbours of the target that is told of, in order.
  const Key* begin() const { return row_.begin(); }
  const Key* end() const { return row_.end(); }
  std::size_t size() const { return row_.size(); }

  // Calls found(target number, support radius) for each of the targets, which it puts into another
  // order. They should be close to each other, and have radii of one magnitude.
  void find(std::span<Target> targets, const Found& found) {
    if (skip_ > 0) {
      --skip_;
      return find_in_tree(targets, found);
    }
    double radius = 0;
    if (shared_.question.nearest) {
      radius = first_guess();
    } else {
      for (const Target& target : targets)
        radius = std::max(radius, static_cast<double>(shared_.question.radius_of(target.number)));
    }
    find(targets, static_cast<S>(radius), 1, found);
  }

 private:
  void find(std::span<Target> targets, S radius, int tries, const Found& found) {
    using Outcome = typename Brick<S, D, periodic>::Outcome;
    const Question<S>& question = shared_.question;
    const double most_periods = question.nearest ? 1 : 4;
    if ((periodic && static_cast<double>(radius) > most_periods * shared_.least_period) ||
        tries > most_tries)
      return find_in_grid(targets, found);

    const auto count = static_cast<std::int64_t>(targets.size());
    const bool tree = shared_.may_build_tree && shared_.index.tree_is_worthwhile();
    Point lower = targets[0].x, upper = lower;
    for (const Target& target : targets)
      for (int d = 0; d < D; ++d) {
        lower[d] = std::min(lower[d], target.x[d]);
        upper[d] = std::max(upper[d], target.x[d]);
      }
    const Outcome outcome = brick_.collect(
        lower, upper, radius, tree ? shared_.hard_work * count / cost_of_collecting : INT64_MAX);
    if (outcome == Outcome::too_far) return find_in_grid(targets, found);
    const std::int64_t work = brick_.candidates() + brick_.work() * cost_of_collecting / count;
    if (outcome == Outcome::too_much_work || (tree && work > shared_.hard_work)) {
      skip_ = next_skip_;
      next_skip_ = std::min(2 * next_skip_ + 1, 63);
      return find_in_tree(targets, found);
    }
    next_skip_ = 0;
    if (const auto halves = split(targets, lower, upper); !halves.empty()) {
      find(halves, radius, tries, found);
      return find(targets.subspan(halves.size()), radius, tries, found);
    }
    if (work > shared_.hard_work) shared_.index.add_hard_work(work * count);
    if (!question.nearest) {
      for (const Target& target : targets) all_within(target, found);
      return;
    }

    // Targets in whose ball there are not enough stay, and try a larger one.
    const auto limits = brick_.limits(radius);
    std::size_t left = 0;
    std::int64_t fewest = std::numeric_limits<std::int64_t>::max();
    for (const Target target : targets)
      if (!nearest(target, radius, limits, found)) {
        fewest = std::min(fewest, brick_.near().count);
        targets[left++] = target;
      }
    if (left > 0)
      find(targets.first(left), larger_guess(targets[0].x, radius, fewest), tries + 1, found);
  }

  // Half of the targets, brought to the front, where it pays to collect once for each half: if
  // there are many targets, and many candidates that are near only some of them.
  std::span<Target> split(std::span<Target> targets, const Point& lower, const Point& upper) const {
    constexpr std::int64_t many = 512;
    const auto count = static_cast<std::int64_t>(targets.size());
    if (brick_.candidates() <= many ||
        brick_.candidates() * count <= 4 * cost_of_collecting * brick_.work())
      return {};
    int axis = 0;
    for (int d = 1; d < D; ++d)
      if (upper[d] - lower[d] > upper[axis] - lower[axis]) axis = d;
    if (!(upper[axis] > lower[axis])) return {};
    const auto middle = targets.begin() + count / 2;
    std::nth_element(targets.begin(), middle, targets.end(),
                     [axis](const auto& a, const auto& b) { return a.x[axis] < b.x[axis]; });
    return targets.first(static_cast<std::size_t>(count / 2));
  }

  // ---- Radius and Radii ----------------------------------------------------------------------

  void all_within(const Target& target, const Found& found) {
    const S rho = shared_.question.radius_of(target.number);
    look(target, shared_.cube ? brick_.limits_of_cube(rho) : brick_.limits(rho), rho);
    if (!brick_.in_order()) row_.by_index();
    found(target.number, rho);
  }

  // Takes what is within rho.
  void look(const Target& target, const Limits& limits, S rho) {
    brick_.look(target.x, limits.possible);
    const NearArrays& near = brick_.near();
    if (sure(limits) == near.count) return take(near);
    brick_.choose_if([&](float measure, std::uint32_t candidate) {
      return measure <= limits.sure || (shared_.cube ? brick_.along_axis(candidate) <= rho
                                                     : brick_.distance2(candidate) <= rho * rho);
    });
    take(brick_.chosen());
  }

  void take(const NearArrays& members) {
    taken_ = &members;
    row_.take(members.count, [&](std::size_t i) { return brick_.key(members.candidate[i]); });
  }

  // ---- Nearest and NearestWithin -------------------------------------------------------------

  // False if there may be others within the limit that are as near as those of the ball.
  bool nearest(const Target& target, S radius, const Limits& limits, const Found& found) {
    const Question<S>& question = shared_.question;
    const auto k = static_cast<std::int64_t>(k_);
    S farthest2 = 0;
    bool in_order = false;  // by index
    brick_.look(target.x, limits.possible);
    Smallest smallest{};
    if (brick_.near().count >= k)
      smallest = brick_.choose(k, brick_.measure_of(likely2_ * near2_), !shared_.by_index, radius);
    if (smallest.count < k || smallest.largest > limits.sure) {
      if (radius < question.radius) return false;
      look(target, limits, radius);  // all that there are within the limit
      farthest2 = of_taken();
    } else {
      const float possible = brick_.limits_of_measure(smallest.largest, radius).possible;
      if (smallest.count == k && smallest.next > possible) {
        brick_.fetch_far(smallest);
        take(brick_.chosen());
        const bool ordered = shared_.by_index ||
                             (brick_.rank() && row_.by_rank(brick_.rank(), brick_.chosen().measure,
                                                            possible - smallest.largest));
        farthest2 = ordered ? brick_.farthest2(smallest) : of_taken();
        in_order = ordered && brick_.in_order();
      } else {  // it is the coordinates that tell which of them are the nearest
        brick_.choose_up_to(possible);
        take(brick_.chosen());
        farthest2 = of_taken();
      }
    }
    if (shared_.by_index && !in_order) row_.by_index();
    if (size() > 0) learn(static_cast<double>(farthest2));
    if (question.factor == 0) {
      found(target.number, question.radius);
      return true;
    }
    const S farthest = shared_.options.shape == SupportShape::cube ? farthest_along_axis(target.x)
                                                                   : std::sqrt(farthest2);
    const S rho = static_cast<S>(question.factor * static_cast<double>(farthest));
    const bool apart = farthest * farthest >= std::numeric_limits<S>::min();
    if (apart && std::isfinite(rho)) {
      found(target.number, rho);
    } else {
      Target alone = target;
      find_in_grid({&alone, 1}, found);
    }
    return true;
  }

  std::int64_t sure(const Limits& limits) const {
    const NearArrays& near = brick_.near();
    if (limits.sure == limits.possible) return near.count;
    return shared_.kernels.count_at_most(near.measure, near.count, limits.sure);
  }

  // The k nearest of what has been taken, by distance, and the largest squared distance.
  S of_taken() {
    return row_.by_distance(
        k_, [this](std::size_t i) { return brick_.distance2(taken_->candidate[i]); });
  }

  // A radius that most likely holds k.
  double first_guess() const {
    constexpr std::size_t few = 64;
    const auto limit = static_cast<double>(shared_.question.radius);
    if (!periodic && (shared_.particles.size() <= few || 2 * k_ >= shared_.particles.size()))
      return limit;
    const double least = std::sqrt(static_cast<double>(std::numeric_limits<S>::min()));
    return std::min(limit, std::max(std::sqrt(near2_) * shared_.widening, least));
  }

  S larger_guess(const Point& x, S radius, std::int64_t count) const {
    const auto now = static_cast<double>(radius);
    double larger;
    if (count > 0) {
      const double ratio = 1.5 * static_cast<double>(k_) / static_cast<double>(count);
      larger = now * std::clamp(std::pow(ratio, 1.0 / shared_.axes), 1.25, 1.6);
    } else {
      double outside2 = 0;  // at least to the box of the particles, and somewhat into it
      for (int d = 0; d < D; ++d) {
        const auto& box = shared_.particles.box();
        const S outside = std::max({S(0), box.lower[d] - x[d], x[d] - box.upper[d]});
        outside2 += static_cast<double>(outside) * static_cast<double>(outside);
      }
      larger = std::max(1.6 * now, std::sqrt(outside2) + shared_.start);
    }
    return std::min(shared_.question.radius, static_cast<S>(larger));
  }

  // The k-th distance of the next target is likely that of the last ones.
  void learn(double distance2) {
    const bool jump = distance2 > 4 * near2_ || distance2 < near2_ / 4;
    near2_ += (distance2 - near2_) * (jump ? 1 : 0.125);
  }

  S farthest_along_axis(const Point& target) const {
    S farthest = 0;
    for (const Key key : row_)
      for (int d = 0; d < D; ++d) {
        S x = target[d];
        if constexpr (periodic)
          if (shared_.domain.periodic[d])
            x -= static_cast<S>(Coding::shift(key)[d]) * shared_.domain.period(d);
        farthest = std::max(farthest, std::abs(x - shared_.particles(Coding::index(key), d)));
      }
    return farthest;
  }

  // ---- Targets that are left to others -------------------------------------------------------

  void find_in_grid(std::span<Target> targets, const Found& found) {
    if (!general_) general_ = single_targets(*shared_.grid);
    find_with(*general_, targets, found);
  }

  void find_in_tree(std::span<Target> targets, const Found& found) {
    if (!in_tree_) {
      tree_ = shared_.index.kd_tree();
      in_tree_ = single_targets(*tree_);
    }
    find_with(*in_tree_, targets, found);
  }

  template <class Search>
  std::unique_ptr<SingleTargets<S, D>> single_targets(const Search& search) const {
    return std::make_unique<SingleTargets<S, D>>(AnySearch<S, D>(search), shared_.particles,
                                                 shared_.targets, shared_.domain, shared_.options,
                                                 shared_.spacing);
  }

  void find_with(SingleTargets<S, D>& neighbours, std::span<Target> targets, const Found& found) {
    for (const Target& target : targets) {
      const S rho = neighbours.find(target.number, shared_.rule);
      const auto& entries = neighbours.found();
      row_.take(static_cast<std::int64_t>(entries.size()),
                [&](std::size_t i) { return Coding::of(entries[i].index, entries[i].shift); });
      if (shared_.by_index) row_.by_index();
      found(target.number, rho);
    }
  }

  static constexpr int most_tries = 40;
  static constexpr std::int64_t cost_of_collecting = 4;  // a particle, against looking at it

  SharedByTargets<S, D>& shared_;
  Brick<S, D, periodic> brick_;
  KeyOrder<S, D, periodic> row_;
  const NearArrays* taken_ = nullptr;
  const std::size_t k_ =
      periodic ? shared_.question.k : std::min(shared_.question.k, shared_.particles.size());
  double near2_;  // squared k-th distance of the latest targets
  // What part of it fewer than k do not exceed in nine of ten random clouds.
  const double likely2_ =
      std::max(0.0, 1 - 2.6 / (shared_.axes * std::sqrt(std::max(1.0, static_cast<double>(k_)))));
  int skip_ = 0, next_skip_ = 0;  // groups to be left to the tree without a try
  std::unique_ptr<SingleTargets<S, D>> general_, in_tree_;  // made when they are needed
  std::shared_ptr<const KdTree<S, D>> tree_;
};

}  // namespace recon::detail
