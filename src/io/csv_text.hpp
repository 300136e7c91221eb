// Cells of delimited text as recon's own reader takes them back.
#pragma once

#include <string>
#include <string_view>

namespace recon::detail {

inline std::string csv_quoted(std::string_view text, std::string_view not_first) {
  const bool plain = text.find_first_of(",;\t\"") == std::string_view::npos &&
                     !text.starts_with(' ') && !text.ends_with(' ');
  if (plain && (text.empty() || not_first.find(text[0]) == std::string_view::npos))
    return std::string(text);
  std::string out(1, '"');
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + '"';
}

// The name of a column, quoted where it would pass for a number, too.
inline std::string csv_name(std::string_view name) {
  return csv_quoted(name, "#%+-.0123456789");
}
inline std::string csv_text(std::string_view text) {
  return csv_quoted(text, "#%");
}

}  // namespace recon::detail
