#include "programs/common/text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace recon::program {

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> words;
  const auto skip_blanks = [&] {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  };
  bool another = !text.empty();  // "a," ends in an empty word
  while (another) {
    skip_blanks();
    std::string word;
    if (text.starts_with('"')) {
      text.remove_prefix(1);
      while (!text.empty() && (text.front() != '"' || text.starts_with("\"\""))) {
        word += text.front();
        text.remove_prefix(text.front() == '"' ? 2 : 1);
      }
      if (!text.empty()) text.remove_prefix(1);
      skip_blanks();
    }
    const std::size_t end = text.find(separator);
    word += text.substr(0, end);
    while (word.ends_with(' ')) word.pop_back();
    words.push_back(word);
    another = end != std::string_view::npos;
    text.remove_prefix(another ? end + 1 : text.size());
  }
  return words;
}

std::optional<double> to_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::string number(double value, int digits) {
  if (std::isnan(value)) return "nan";
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value == 0 ? 0.0 : value);
  return text;
}

std::string or_dash(double value, const char* format) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string count(std::size_t value) {
  const std::string digits = std::to_string(value);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string counted(std::size_t value, const std::string& noun) {
  return count(value) + " " + noun + (value == 1 ? "" : "s");
}

std::string enumeration(std::span<const std::string> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

std::string number_within(double value, double lower, double upper) {
  constexpr int least = 5, most = 14, of_extent = 4;  // what differs beyond that is rounding
  const double size = std::max(std::abs(lower), std::abs(upper)), extent = upper - lower;
  if (!std::isfinite(extent)) return number(value);
  constexpr int of_one_number = 10;
  if (!(extent > 0)) return number(value, of_one_number);
  const double figures = std::ceil(std::log10(size) - std::log10(extent)) + of_extent;
  if (figures > most) return number(value, of_one_number);
  return number(value, std::max(least, static_cast<int>(figures)));
}

std::string range(double lower, double upper) {
  return number_within(lower, lower, upper) + " .. " + number_within(upper, lower, upper);
}

std::string hash(std::string_view text) {
  std::uint64_t value = 14695981039346656037u;
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 1099511628211u;
  std::string digits;
  for (int k = 0; k < 16; ++k, value >>= 4) digits += "0123456789abcdef"[value & 15];
  return digits;
}

std::string shell_word(const std::string& text) {
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_-+=.,/:@%").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string quoted(1, '\'');
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

}  // namespace recon::program
