// Summaries for scripts: values of JSON (RFC 8259), written down as they are made.
#pragma once

#include <concepts>
#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace recon::program {

// A number, a text, true or false, null, an object or an array. Numbers have the fewest digits that
// give them back; those that are not finite are null. Text that is no UTF-8 is read as Windows-1252.
class Json {
 public:
  Json() : text_("null") {}
  template <std::same_as<bool> Bool>
  Json(Bool value) : text_(value ? "true" : "false") {}
  template <std::integral Integer>
  requires(!std::same_as<Integer, bool>) Json(Integer value) : text_(std::to_string(value)) {}
  Json(double value);
  Json(std::string_view value);
  Json(const std::string& value) : Json(std::string_view(value)) {}
  Json(const char* value) : Json(std::string_view(value)) {}

  static Json object() { return Json('{', '}'); }
  static Json array() { return Json('[', ']'); }
  template <class Range>
  static Json array_of(const Range& values) {
    Json all = array();
    for (const auto& value : values) all.push(value);
    return all;
  }

  // A member of an object, an element of an array. What is there already stays.
  Json& set(std::string_view key, const Json& value);
  Json& push(const Json& value);

  std::string text() const { return text_ + close_; }

 private:
  Json(char open, char close) : text_(1, open), close_(1, close) {}
  void separate();

  std::string text_, close_;
};

// The option --json.
void add_json_option(CLI::App& app, bool& json, const std::string& group);
// The one object that a command prints, and a line break.
void print_json(const Json& object);

}  // namespace recon::program
