// Checks of option values, with messages that say what is needed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "recon/core/names.hpp"
#include "text.hpp"

// After the standard headers: CLI11 is one large header.
#include <CLI/CLI.hpp>

namespace recon::program {

// What CLI11 asks for: an empty text if the value is right, else what is wrong with it.
using Check = std::function<std::string(const std::string&)>;

inline Check positive_number() {
  return [](const std::string& text) -> std::string {
    const auto value = to_number(text);
    return value && *value > 0 ? "" : "'" + text + "' is not a number above 0";
  };
}

inline Check whole_number(std::optional<int> least) {
  return [least](const std::string& text) -> std::string {
    const auto value = to_number(text);
    if (value && *value == static_cast<int>(*value) && (!least || *value >= *least)) return "";
    return "'" + text + "' is not a whole number" +
           (least ? ", " + std::to_string(*least) + " or more" : "");
  };
}

inline Check one_of(std::vector<std::string> words) {
  return [words](const std::string& text) -> std::string {
    for (const std::string& word : words)
      if (word == text) return "";
    return "unknown '" + text + "'; " + suggest(text, words);
  };
}

}  // namespace recon::program
