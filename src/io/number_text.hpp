// Numbers as text, in the fewest digits that read back to the same bits; independent of the locale.
#pragma once

#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>

namespace recon::detail {

template <class Number>
void append_number(std::string& text, Number number) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, number);
  text.append(buffer, result.ptr);
}

inline void append_part(std::string& text, double number) {
  append_number(text, number);
}
inline void append_part(std::string& text, std::size_t number) {
  append_number(text, number);
}
inline void append_part(std::string& text, int number) {
  append_number(text, number);
}
inline void append_part(std::string& text, std::string_view part) {
  text += part;
}

// Texts and numbers in a row.
template <class... Parts>
std::string join(const Parts&... parts) {
  std::string text;
  (append_part(text, parts), ...);
  return text;
}

}  // namespace recon::detail
