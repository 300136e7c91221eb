#include "programs/common/json.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "programs/common/checks.hpp"
#include "recon/fields/utf8.hpp"

namespace recon::program {

Json::Json(double value) {
  if (!std::isfinite(value)) {
    text_ = "null";
    return;
  }
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text_.assign(digits, end);
}

Json::Json(std::string_view value) : text_("\"") {
  for (const char c : to_utf8(value)) {
    if (c == '"' || c == '\\') {
      text_ += '\\';
      text_ += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
      text_ += code;
    } else {
      text_ += c;
    }
  }
  text_ += '"';
}

void Json::separate() {
  if (text_.size() > 1) text_ += ", ";
}

Json& Json::set(std::string_view key, const Json& value) {
  separate();
  text_ += Json(key).text() + ": " + value.text();
  return *this;
}

Json& Json::push(const Json& value) {
  separate();
  text_ += value.text();
  return *this;
}

void add_json_option(CLI::App& app, bool& json, const std::string& group) {
  app.add_flag("--json", json,
               "the summary as one JSON object on the standard output, for\n"
               "scripts; null where there is no number")
      ->group(group);
}

void print_json(const Json& object) {
  std::printf("%s\n", object.text().c_str());
}

}  // namespace recon::program
