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

// A place as "(1, 2, 3)".
template <class Vector>
std::string brief_place(const Vector& x) {
  std::string text = "(";
  for (int d = 0; d < static_cast<int>(x.size()); ++d) text += (d ? ", " : "") + brief(x[d], 9);
  return text + ")";
}

}  // namespace recon::detail
