// Letters of ASCII made small; all others stay.
#pragma once

#include <string>
#include <string_view>

namespace recon::detail {

inline std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

}  // namespace recon::detail
