// Whether an entry of an array of the particles is finite, and its text.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <concepts>

#include "recon/core/error.hpp"

namespace recon::mpm {

inline bool is_finite(double value) {
  return std::isfinite(value);
}
inline bool is_finite(std::integral auto) {
  return true;
}
template <int R, int C>
bool is_finite(const Eigen::Matrix<double, R, C>& value) {
  return value.allFinite();
}
template <class T, std::size_t N>
bool is_finite(const std::array<T, N>& values) {
  for (const T& value : values)
    if (!is_finite(value)) return false;
  return true;
}

template <class T>
std::string text_of(const T& value) {
  if constexpr (requires { value.reshaped(); }) {
    return recon::detail::to_text(value.reshaped().transpose());
  } else if constexpr (requires { value.begin(); }) {
    for (const auto& each : value)
      if (!is_finite(each)) return text_of(each);
    return "";
  } else {
    return recon::detail::to_text(value);
  }
}

}  // namespace recon::mpm
