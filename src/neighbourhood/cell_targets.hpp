// Finds the neighbours of one target after another by cells; has the buffers for that.
//
// What a rule asks of a target: how far to gather, when to gather again with a larger guess, and
// when to leave the target to find_neighbours_with.hpp, which serves it from the grid or from a
// tree.
#pragma once

#include <optional>

#include "neighbourhood/key_order.hpp"

namespace recon::detail {

template <class S, int D, bool periodic>
class CellTargets {
 public:
  using Point = std::array<S, D>;
  using Coding = NeighbourKey<periodic>;
  using Key = typename Coding::Key;

  CellTargets(SharedByTargets<S, D>& shared, CellBuffers<S, D, Key>& buffers)
      : shared_(shared),
        gathered_(shared, buffers),
        order_(shared.kernels, buffers),
        near_(shared.start) {}

  // Keys of the neighbours of the target at x, in order, valid until the next call of find().
  const Key* begin() const { return order_.begin(); }
  const Key* end() const { return order_.end(); }
  std::size_t size() const { return order_.size(); }

  // Returns the support radius.
  S find(std::size_t target, const Point& x) {
    if (skip_ > 0) {
      --skip_;
      return find_in_tree(target);
    }
    const bool tree = shared_.may_build_tree && shared_.index.tree_is_worthwhile();
    gathered_.start(x, tree ? shared_.hard_work : INT64_MAX);
    S rho = 0;
    const Outcome outcome =
        shared_.question.nearest ? nearest(target, rho) : all_within(target, rho);
    if (gathered_.work() > shared_.hard_work) shared_.index.add_hard_work(gathered_.work());
    if (outcome == Outcome::too_much_work) {
      skip_ = next_skip_;
      next_skip_ = std::min(2 * next_skip_ + 1, 63);
      return find_in_tree(target);
    }
    next_skip_ = 0;
    if (outcome == Outcome::not_covered) {
      if (!general_)
        general_.emplace(*shared_.grid, shared_.particles, shared_.targets, shared_.domain,
                         shared_.options, shared_.spacing);
      return find_with(*general_, target);
    }
    return rho;
  }

 private:
  enum class Outcome { found, not_covered, too_much_work };

  // ---- Radius and Radii ----------------------------------------------------------------------

  Outcome all_within(std::size_t target, S& rho) {
    rho = shared_.question.radius_of(target);
    if (!gathered_.within(rho)) return Outcome::too_much_work;
    order_.by_index(gathered_);
    return Outcome::found;
  }

  // ---- Nearest and NearestWithin -------------------------------------------------------------

  Outcome nearest(std::size_t target, S& rho) {
    const Question<S>& question = shared_.question;
    const std::size_t particles = shared_.particles.size();
    const std::size_t k = periodic ? question.k : std::min(question.k, particles);
    const S limit = question.radius_of(target);
    S radius = first_guess(k, limit);
    for (int tries = 1;; ++tries) {
      if (periodic && static_cast<double>(radius) > shared_.least_period)
        return Outcome::not_covered;
      if (!gathered_.within(radius)) return Outcome::too_much_work;
      if (gathered_.count() >= k || radius >= limit) break;
      if (tries == most_tries) return Outcome::not_covered;
      radius = std::min(limit, larger_guess(radius, gathered_.count(), k));
    }
    const S farthest2 = order_.by_distance(gathered_, k);
    if (size() > 0) learn(std::sqrt(static_cast<double>(farthest2)));
    if (question.factor == 0) {
      rho = limit;
      return Outcome::found;
    }
    const S farthest =
        shared_.options.shape == SupportShape::cube ? farthest_along_axis() : std::sqrt(farthest2);
    rho = static_cast<S>(question.factor * static_cast<double>(farthest));
    const bool apart = farthest * farthest >= std::numeric_limits<S>::min();
    return apart && std::isfinite(rho) ? Outcome::found : Outcome::not_covered;
  }

  // A radius that most likely holds k.
  S first_guess(std::size_t k, S limit) const {
    constexpr std::size_t few = 64;
    if (!periodic && (shared_.particles.size() <= few || 2 * k >= shared_.particles.size()))
      return limit;
    const double least = std::sqrt(static_cast<double>(std::numeric_limits<S>::min()));
    return std::min(limit, static_cast<S>(std::max(near_ * shared_.widening, least)));
  }

  S larger_guess(S radius, std::size_t count, std::size_t k) const {
    const auto now = static_cast<double>(radius);
    if (count > 0) {
      const double ratio = 1.5 * static_cast<double>(k) / static_cast<double>(count);
      return static_cast<S>(now * std::clamp(std::pow(ratio, 1.0 / shared_.axes), 1.25, 1.6));
    }
    double outside2 = 0;  // at least to the box of the particles, and somewhat into it
    for (int d = 0; d < D; ++d) {
      const auto& box = shared_.particles.box();
      const S x = gathered_.x()[d];
      const S outside = std::max({S(0), box.lower[d] - x, x - box.upper[d]});
      outside2 += static_cast<double>(outside) * static_cast<double>(outside);
    }
    return static_cast<S>(std::max(1.6 * now, std::sqrt(outside2) + shared_.start));
  }

  // The k-th distance of the next target is likely that of the last ones.
  void learn(double distance) {
    const bool jump = distance > 2 * near_ || distance < near_ / 2;
    near_ += (distance - near_) * (jump ? 1 : 0.125);
  }

  S farthest_along_axis() const {
    S farthest = 0;
    for (const Key key : order_)
      for (int d = 0; d < D; ++d) {
        S x = gathered_.x()[d];
        if constexpr (periodic)
          if (shared_.domain.periodic[d])
            x -= static_cast<S>(Coding::shift(key)[d]) * shared_.domain.period(d);
        farthest = std::max(farthest, std::abs(x - shared_.particles(Coding::index(key), d)));
      }
    return farthest;
  }

  // ---- Targets that are left to others -------------------------------------------------------

  S find_in_tree(std::size_t target) {
    if (!in_tree_) {
      tree_ = shared_.index.kd_tree();
      in_tree_.emplace(*tree_, shared_.particles, shared_.targets, shared_.domain, shared_.options,
                       shared_.spacing);
    }
    return find_with(*in_tree_, target);
  }

  template <class Neighbours>
  S find_with(Neighbours& neighbours, std::size_t target) {
    const S rho =
        std::visit([&](const auto& r) { return neighbours.find(target, r); }, shared_.rule);
    order_.take(neighbours.entries());
    return rho;
  }

  static constexpr int most_tries = 40;

  SharedByTargets<S, D>& shared_;
  CellGather<S, D, periodic> gathered_;
  KeyOrder<S, D, periodic> order_;
  double near_;                   // k-th distance of the latest targets
  int skip_ = 0, next_skip_ = 0;  // targets to be left to the tree without a try
  std::optional<TargetNeighbours<CellGrid<S, D>>> general_;
  std::shared_ptr<const KdTree<S, D>> tree_;
  std::optional<TargetNeighbours<KdTree<S, D>>> in_tree_;
};

}  // namespace recon::detail
