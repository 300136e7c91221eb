// Kernels written once for single numbers and for packs of several numbers side by side.
//
// A kernel is a template over its value type T: float, double, long double, a pack of them
// (core/pack.hpp) with one target in each lane, or a number type of your own (docs/concepts.md).
// Arithmetic, comparisons and square roots are written the same way for all; functions such as sqrt
// are found by argument-dependent lookup. A comparison of packs gives a mask with one truth value
// per lane, so a kernel must not branch on it but use select(). Where it must know whether any or
// all lanes agree, it asks any_lane() or all_lanes().
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

#include "recon/core/unroll.hpp"

namespace recon {

template <class T>
struct LaneTraits {
  using Scalar = T;  // the type of one lane
  using Mask = bool;
  static constexpr int lanes = 1;
  static constexpr const T& select(bool mask, const T& a, const T& b) { return mask ? a : b; }
};
template <class T>
using ScalarOf = typename LaneTraits<T>::Scalar;
template <class T>
using MaskOf = typename LaneTraits<T>::Mask;

template <class Mask>
struct MaskTraits;
template <>
struct MaskTraits<bool> {
  static constexpr bool any(bool mask) { return mask; }
  static constexpr bool all(bool mask) { return mask; }
};

namespace detail {

template <class Mask>
constexpr bool any_lane(const Mask& mask) {
  return MaskTraits<Mask>::any(mask);
}
template <class Mask>
constexpr bool all_lanes(const Mask& mask) {
  return MaskTraits<Mask>::all(mask);
}

// The same number in all lanes.
template <class T>
constexpr T constant(double value) {
  return T(static_cast<ScalarOf<T>>(value));
}

// Whether a value is neither infinite nor NaN (in a pack: for each lane).
template <class T>
constexpr bool is_finite(const T& value) {
  return value - value == T(0);
}

// sqrt() of the built-in numbers where constants are evaluated, to a rounding (Newton's iteration).
template <class T>
constexpr T constant_square_root(const T& x) {
  if (!(x > T(0)) || x > std::numeric_limits<T>::max())
    return x < T(0) ? std::numeric_limits<T>::quiet_NaN() : x;
  T root = T(1);
  while (root * root < x) root *= T(2);
  while (root * T(0.25) * root > x) root *= T(0.5);
  for (T next = T(0.5) * (root + x / root);; next = T(0.5) * (root + x / root)) {
    if (!(next < root)) return root;
    root = next;
  }
}

// The square root, found by the argument's type; for built-in numbers in constant expressions too.
template <class T>
RECON_INLINE constexpr T square_root(const T& x) {
  if constexpr (std::is_floating_point_v<T>)
    if (__builtin_is_constant_evaluated()) return constant_square_root(x);
  using std::sqrt;
  return T(sqrt(x));
}

// The number of one lane as a report holds it.
template <class T>
constexpr float to_float(const T& value) {
  return static_cast<float>(static_cast<double>(value));
}

// select() is a where the mask holds and b elsewhere, lane by lane.
template <class T>
constexpr T select(const MaskOf<T>& mask, const T& a, const T& b) {
  return LaneTraits<T>::select(mask, a, b);
}

// smaller() and larger() are min and max, lane by lane; the result is b where a is NaN.
template <class T>
constexpr T smaller(const T& a, const T& b) {
  return select(a < b, a, b);
}
template <class T>
constexpr T larger(const T& a, const T& b) {
  return select(a > b, a, b);
}

}  // namespace detail
}  // namespace recon
