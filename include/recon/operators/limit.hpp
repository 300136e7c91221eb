// Limiting: values of a reconstruction kept near the range of the data they are made of.
//
// A fit of degree 1 or more extrapolates where particles lie on one side of the target, and
// overshoots beside steps: its value v may then leave the range [a, b] of the data of the particles
// in the support (those with a positive weight). For each component by itself:
//   range    v must lie in [a, b]. No value exceeds its data, and a step gets no new extremum. But
//            linear fields are not extrapolated, and at smooth extrema degrees 2 to 4 lose their
//            order.
//   relaxed  v must lie in [a - (b - a), b + (b - a)] and in the range of all the data. That keeps
//            linear fields up to about a spacing beyond the particles, and smooth extrema but for
//            the greatest and the least value of all. Overshoots beside a step stay, unless the two
//            values at the step are those.
// docs/mls_vs_imls.md has the numbers behind the choice.
//
// A value outside is replaced by the convex combination (1 - s) v + s m with the weighted mean m
// (Shepard's value, degree 0, same weights) that has the smallest s and lies inside. As m lies in
// [a, b], that is the nearer end of the interval. Values inside are the same bits as without a
// limit. A linear field is unchanged, to rounding, wherever the target lies in the convex hull of
// the particles in its support.
//
// Limiting is not linear in the data. It is a way to apply a fit, never a part of an operator: the
// rows of values(), gradients, Hessians and transposes are those of the fit as it stands, and the
// gradient of a limited value is not limited.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "recon/core/error.hpp"

namespace recon {

enum class Limit : std::uint8_t { none, range, relaxed };

// What limiting changed. A value that left its interval by no more than rounding (1024 eps sum_p
// |phi_p| max_p |u_p|, which the errors of phi may reach) is brought back, but not counted.
struct LimitCount {
  std::vector<std::uint32_t>
      components;           // per target: of how many components the value was limited
  std::size_t targets = 0;  // with any such component
  std::size_t values = 0;   // the sum over all targets

  // Sums up `components`.
  void total() {
    targets = values = 0;
    for (const std::uint32_t count : components) {
      targets += count > 0;
      values += count;
    }
  }
};

// Are data known to be finite? Trusted data are not looked at: NaN and infinity then pass into the
// results, also from particles with the coefficient 0, and so do sums that leave the range of
// numbers on their way. fit.apply(u, out, recon::trusted).
enum class Data : std::uint8_t { checked, trusted };
inline constexpr Data trusted = Data::trusted;

// The least and the greatest value of one component.
struct DataBounds {
  double least, greatest;
};

// How a fit is applied: fit.apply(u, {.limit = Limit::relaxed, .count = &count}).
struct Apply {
  Limit limit = Limit::none;
  LimitCount* count = nullptr;  // overwritten, if given; all zero without limiting
  Data data = Data::checked;    // limited values are always checked
  // For Limit::relaxed where u has a part of all the data alone, as in one of several processes: the
  // bounds of all the data, for each component. Empty: u has all.
  std::span<const DataBounds> bounds{};
};

namespace detail {

inline void require_limit(Limit limit) {
  require(limit == Limit::none || limit == Limit::range || limit == Limit::relaxed, "limit",
          static_cast<int>(limit), "must be an enumerator of recon::Limit");
}

// The range of the data that one value is made of, as far as it is known.
template <class Scalar>
struct DataRange {
  Scalar least = std::numeric_limits<Scalar>::infinity();
  Scalar greatest = -std::numeric_limits<Scalar>::infinity();

  void add(Scalar u) {
    least = std::min(least, u);
    greatest = std::max(greatest, u);
  }
  bool holds(Scalar value) const { return least <= value && value <= greatest; }

  // Brings back a value that the range does not hold; `all` is the range of all data, and
  // `amplification` sum_p |phi_p| or a bound of it. True where it was outside by more than
  // rounding. A NaN stays one.
  bool limit(Scalar& value, Limit kind, const DataRange& all, Scalar amplification) const {
    Scalar lower = least, upper = greatest;
    if (kind == Limit::relaxed) {
      const Scalar more = upper - lower;
      lower = std::max(all.least, lower - more);
      upper = std::min(all.greatest, upper + more);
    }
    const Scalar inside = value > upper ? upper : value < lower ? lower : value;
    const Scalar rounding = 1024 * std::numeric_limits<Scalar>::epsilon() * amplification *
                            std::max(std::abs(least), std::abs(greatest));
    const bool counts = value - inside > rounding || inside - value > rounding;
    value = inside;
    return counts;
  }
};

}  // namespace detail
}  // namespace recon
