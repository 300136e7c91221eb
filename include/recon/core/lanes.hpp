// One number or several side by side: what a kernel needs to be written once for both.
//
// A kernel is a template over its value type T. T may be float, double or long double, or a pack of
// them (core/pack.hpp), with one target in each lane, or a number type of your own
// (docs/concepts.md), whose functions are found by their arguments. Arithmetic, comparisons and
// square roots are the same for both; a comparison of packs gives a mask, so that a kernel must not branch on it but
// select. Where it must know that all lanes agree, it asks any_lane or all_lanes.
#pragma once

namespace recon {

template <class T>
struct LaneTraits {
  using Scalar = T;  // of one lane
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

template <class Mask>
constexpr bool any_lane(const Mask& mask) {
  return MaskTraits<Mask>::any(mask);
}
template <class Mask>
constexpr bool all_lanes(const Mask& mask) {
  return MaskTraits<Mask>::all(mask);
}

// A number, in all lanes.
template <class T>
constexpr T constant(double value) {
  return T(static_cast<ScalarOf<T>>(value));
}

// Neither infinite nor NaN.
template <class T>
constexpr bool is_finite(const T& value) {
  return value - value == T(0);
}

// A number of one lane for a report.
template <class T>
constexpr float to_float(const T& value) {
  return static_cast<float>(static_cast<double>(value));
}

// a where the mask holds, b elsewhere.
template <class T>
constexpr T select(const MaskOf<T>& mask, const T& a, const T& b) {
  return LaneTraits<T>::select(mask, a, b);
}

// The smaller and the larger of two; b where a is NaN.
template <class T>
constexpr T smaller(const T& a, const T& b) {
  return select(a < b, a, b);
}
template <class T>
constexpr T larger(const T& a, const T& b) {
  return select(a > b, a, b);
}

}  // namespace recon
