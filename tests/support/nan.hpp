// The number that must never pass.
#pragma once

#include <limits>

namespace recon {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace recon
