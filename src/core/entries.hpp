// Whether a number, a matrix, or an array of such is finite, and its text in messages.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <concepts>

#include "recon/core/error.hpp"

namespace recon::detail {

inline bool entries_finite(double value) {
  return std::isfinite(value);
}
inline bool entries_finite(std::integral auto) {
  return true;
}
template <int R, int C>
bool entries_finite(const Eigen::Matrix<double, R, C>& value) {
  return value.allFinite();
}
template <class T, std::size_t N>
bool entries_finite(const std::array<T, N>& values) {
  for (const T& value : values)
    if (!entries_finite(value)) return false;
  return true;
}

template <class T>
std::string entries_text(const T& value) {
  if constexpr (requires { value.reshaped(); }) {
    return to_text(value.reshaped().transpose());
  } else if constexpr (requires { value.begin(); }) {
    for (const auto& each : value)
      if (!entries_finite(each)) return entries_text(each);
    return "";
  } else {
    return to_text(value);
  }
}

}  // namespace recon::detail
