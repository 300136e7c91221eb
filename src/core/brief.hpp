// Numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace recon::detail {

inline std::string brief(double value, int digits = 4) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

}  // namespace recon::detail
