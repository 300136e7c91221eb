// Checks of option values, with messages that say what is needed.
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "programs/common/text.hpp"
#include "recon/core/names.hpp"

// After the standard headers: CLI11 is one large header.
#include <CLI/CLI.hpp>

namespace recon::program {

// What CLI11 asks for: an empty text if the value is right, else what is wrong with it.
using Check = std::function<std::string(const std::string&)>;

inline Check positive_number() {
  return [](const std::string& text) -> std::string {
    const auto value = to_number(text);
    return value && *value > 0 ? "" : "a number above 0 is needed, not '" + text + "'";
  };
}

inline Check finite_number() {
  return [](const std::string& text) -> std::string {
    return to_number(text) ? "" : "a number is needed, not '" + text + "'";
  };
}

inline Check whole_number(std::optional<int> least, double most = 1e9) {
  return [least, most](const std::string& text) -> std::string {
    const auto value = to_number(text);
    if (value && std::abs(*value) < most && *value == std::floor(*value) &&
        (!least || *value >= *least))
      return "";
    return std::string("a whole number") +
           (least ? " of " + std::to_string(*least) + " or more" : "") + " is needed, not '" +
           text + "'";
  };
}

// One of a few numbers, in words: "from 0 to 4".
inline Check digit(char least, char greatest) {
  return [least, greatest](const std::string& text) -> std::string {
    if (text.size() == 1 && text[0] >= least && text[0] <= greatest) return "";
    return "a whole number from " + std::string(1, least) + " to " + greatest +
           " is needed, not '" + text + "'";
  };
}

// A check that accepts some words only has these in its name, where completion finds them.
inline constexpr std::string_view one_of_mark = "one of ";

inline std::string check_name(const std::vector<std::string>& words) {
  std::string name(one_of_mark);
  for (const std::string& word : words) name += word + " ";
  return name;
}

inline CLI::Validator one_of(const std::vector<std::string>& words) {
  const auto check = [words](const std::string& text) -> std::string {
    for (const std::string& word : words)
      if (word == text) return "";
    return "unknown '" + text + "'; " + suggest(text, words);
  };
  return {check, "", check_name(words)};
}

// Words to complete, of an option whose value is checked elsewhere.
inline CLI::Validator such_as(const std::vector<std::string>& words) {
  return {[](const std::string&) { return std::string(); }, "", check_name(words)};
}

// What one_of() or such_as() were given; no words where an option has no such check.
inline std::vector<std::string> words_of(CLI::Option& option) {
  for (int i = 0;; ++i) try {
      const std::string& name = option.get_validator(i)->get_name();
      if (name.starts_with(one_of_mark)) {
        std::vector<std::string> words = split(name.substr(one_of_mark.size()), ' ');
        words.pop_back();  // behind the last blank
        return words;
      }
    } catch (const CLI::OptionNotFound&) {
      return {};
    }
}

}  // namespace recon::program
