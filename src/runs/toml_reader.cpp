#include "runs/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "recon/core/names.hpp"
#include "recon/io/error.hpp"

namespace recon::mpm {
namespace {

// "an integer"
std::string kind_of(const toml::node& node) {
  std::ostringstream text;
  text << node.type();
  const std::string kind = text.str();
  const bool vowel = std::string_view("aeio").find(kind[0]) != std::string_view::npos;
  return (vowel ? "an " : "a ") + kind;
}

toml::table parse(const std::string& text, const std::filesystem::path& file);

// The value of "key=value": TOML, or a bare word.
toml::table parse_setting(const std::string& key, const std::string& value) {
  const std::filesystem::path place = "--set " + key;
  for (const char* quote : {"", "'"}) try {
      toml::table found = parse("value = " + (quote + value) + quote, place);
      if (found.size() == 1) return found;
    } catch (const FileError&) {
    }
  throw FileError(place, 0, "'" + value + "' is no value");
}

// Puts the value at a dotted path; of a list of tables, in all of them.
void assign(toml::table& table, std::string_view path, const std::string& key,
            const toml::node& value) {
  const std::size_t dot = path.find('.');
  if (dot == std::string_view::npos) {
    table.insert_or_assign(path, value);
    return;
  }
  const std::string_view name = path.substr(0, dot), rest = path.substr(dot + 1);
  toml::node* next = table.get(name);
  if (!next) next = &table.insert(name, toml::table{}).first->second;
  if (toml::table* inner = next->as_table()) return assign(*inner, rest, key, value);
  bool any = false;
  if (toml::array* list = next->as_array())
    for (toml::node& each : *list)
      if (toml::table* inner = each.as_table()) {
        assign(*inner, rest, key, value);
        any = true;
      }
  if (!any)
    throw FileError("--set " + key, 0, "'" + std::string(name) + "' is no table in the file");
}

void apply(toml::table& root, const std::string& setting, const KnownKeys& known) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    throw FileError("--set " + setting, 0, "needs key=value, for example method.name=cpls");
  std::string key = setting.substr(0, equals);
  std::vector<std::string> same;
  for (const std::string& each : known.settable)
    if (each == key || each.ends_with("." + key)) same.push_back(each);
  for (const std::string& each : known.others)
    if (each == key) same.push_back(each);
  if (same.empty())
    throw FileError("--set " + key, 0, "unknown key; " + suggest(key, known.settable));
  if (same.size() > 1 && std::find(same.begin(), same.end(), key) == same.end())
    throw FileError("--set " + key, 0, "is ambiguous; " + suggest(key, same));
  if (same.size() == 1) key = same.front();

  const toml::table value = parse_setting(key, setting.substr(equals + 1));
  assign(root, key, key, *value.get("value"));
}

std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
}

// Up to the end of a line, counted from 1.
std::string first_lines(const std::string& text, std::size_t lines) {
  std::size_t at = 0;
  for (; lines > 0 && at < text.size(); --lines)
    at = std::min(text.find('\n', at), text.size()) + 1;
  return text.substr(0, at);
}

// TOML has characters beyond ASCII in comments and texts only. toml++ has undefined behaviour for
// some of them elsewhere (U+00A1, for example), so they are refused here.
void require_ascii_outside_texts(const std::string& text, const std::filesystem::path& file) {
  std::size_t line = 1;
  std::string_view quotes;  // that end the present text; empty outside
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest(text.data() + i, text.size() - i);
    if (text[i] == '\n') {
      ++line;
      if (quotes.size() == 1) quotes = {};  // not closed: an error to be named by toml++
    } else if (!quotes.empty()) {
      if (quotes[0] == '"' && text[i] == '\\' && i + 1 < text.size() && text[i + 1] != '\n') {
        ++i;
      } else if (rest.starts_with(quotes)) {
        i += quotes.size() - 1;
        quotes = {};
      }
    } else if (text[i] == '#') {
      i += std::min(rest.find('\n'), rest.size()) - 1;
    } else if (text[i] == '"' || text[i] == '\'') {
      quotes = rest.starts_with("\"\"\"") || rest.starts_with("'''") ? rest.substr(0, 3)
                                                                     : rest.substr(0, 1);
      i += quotes.size() - 1;
    } else if (static_cast<unsigned char>(text[i]) >= 0x80) {
      throw FileError(file, line, "a character beyond ASCII outside of a text and of a comment");
    }
  }
}

toml::table parse(const std::string& text, const std::filesystem::path& file) {
  require_ascii_outside_texts(text, file);
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw FileError(file, error.source().begin.line, std::string(error.description()));
  } catch (const BrokenAssumption&) {
  }
  // It does not say where: at the end of the shortest part that breaks it, too.
  std::size_t fine = 0, broken = line_count(text);
  while (broken - fine > 1) {
    const std::size_t middle = (fine + broken) / 2;
    bool breaks = false;
    try {
      static_cast<void>(toml::parse(first_lines(text, middle)));
    } catch (const toml::parse_error&) {  // of the cut
    } catch (const BrokenAssumption&) {
      breaks = true;
    }
    (breaks ? broken : fine) = middle;
  }
  throw FileError(file, broken, "is no TOML: tables are written [name], lists of them [[name]]");
}

// Throws for a key of the table, or of one within it, that is not among `known`, or is a table
// where none is known.
void require_known(const toml::table& table, const std::string& path,
                   const std::vector<std::string>& known, const std::filesystem::path& file) {
  const std::string prefix = path.empty() ? "" : path + ".";
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    if (std::find(known.begin(), known.end(), prefix + "*") != known.end()) continue;
    const auto within = [&](const std::string& each) { return each.starts_with(name + "."); };
    if (std::find(known.begin(), known.end(), name) == known.end() &&
        std::none_of(known.begin(), known.end(), within)) {
      std::vector<std::string> beside;
      for (const std::string& each : known)
        if (each.starts_with(prefix)) {
          std::string word = each.substr(prefix.size());
          word = word.substr(0, word.find('.'));
          if (std::find(beside.begin(), beside.end(), word) == beside.end())
            beside.push_back(std::move(word));
        }
      throw FileError(file, node.source().begin.line,
                      name + ": unknown key; " + suggest(key.str(), beside));
    }
    if (const toml::table* inner = node.as_table()) require_known(*inner, name, known, file);
    if (const toml::array* list = node.as_array())
      for (const toml::node& each : *list)
        if (const toml::table* inner = each.as_table()) require_known(*inner, name, known, file);
  }
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       std::span<const std::string> settings, const KnownKeys& known) {
  toml::table root = parse(text, file);
  KnownKeys all = known;
  if (const toml::table* constants = root["constants"].as_table())
    for (const auto& [key, node] : *constants)
      all.settable.push_back("constants." + std::string(key.str()));
  for (const std::string& setting : settings) apply(root, setting, all);
  all.settable.insert(all.settable.end(), all.others.begin(), all.others.end());
  require_known(root, "", all.settable, file);
  return root;
}

const toml::node* TomlTable::find(std::string_view key) const {
  asked_.emplace(key);
  return table_->get(key);
}

std::string TomlTable::full(std::string_view key) const {
  if (key.empty()) return name_;
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

void TomlTable::fail_at(const toml::node& node, std::string_view key,
                        const std::string& what) const {
  const std::string name = full(key);
  // The first line is that of the whole file, which is no place.
  throw FileError(*file_, &node == table_ && name_.empty() ? 0 : node.source().begin.line,
                  (name.empty() ? "" : name + ": ") + what);
}

void TomlTable::fail(std::string_view key, const std::string& what) const {
  const toml::node* node = key.empty() ? nullptr : table_->get(key);
  fail_at(node ? *node : *table_, key, what);
}

const toml::node& TomlTable::require(std::string_view key) const {
  const toml::node* node = find(key);
  if (!node) fail(key, "is missing");
  return *node;
}

double TomlTable::number(std::string_view key) const {
  const toml::node& node = require(key);
  const auto value = node.value<double>();
  if (!value || node.is_boolean()) fail(key, "a number is needed, not " + kind_of(node));
  if (!std::isfinite(*value)) fail(key, "must be finite");
  return *value;
}

double TomlTable::number(std::string_view key, double otherwise) const {
  return find(key) ? number(key) : otherwise;
}

int TomlTable::integer(std::string_view key, int otherwise, int least, int most) const {
  const toml::node* node = find(key);
  if (!node) return otherwise;
  const auto value = node->value_exact<std::int64_t>();
  if (!value || *value < least || *value > most)
    fail(key, "a whole number from " + std::to_string(least) + " to " + std::to_string(most) +
                  " is needed");
  return static_cast<int>(*value);
}

bool TomlTable::boolean(std::string_view key, bool otherwise) const {
  const toml::node* node = find(key);
  if (!node) return otherwise;
  const auto value = node->value_exact<bool>();
  if (!value) fail(key, "true or false is needed, not " + kind_of(*node));
  return *value;
}

std::string TomlTable::text(std::string_view key) const {
  const auto value = require(key).value_exact<std::string>();
  if (!value) fail(key, "a text is needed, not " + kind_of(require(key)));
  return *value;
}

std::string TomlTable::choice(std::string_view key, std::span<const std::string> choices,
                              bool required) const {
  if (!required && !find(key)) return choices.front();
  const std::string word = text(key);
  for (const std::string& each : choices)
    if (each == word) return word;
  fail(key, "unknown '" + word + "'; " + suggest(word, choices));
}

std::vector<std::string> TomlTable::choices(std::string_view key,
                                            std::span<const std::string> known) const {
  const toml::array* list = require(key).as_array();
  if (!list) fail(key, "a list is needed, [\"" + known.front() + "\", ...]");
  std::vector<std::string> chosen;
  for (const toml::node& node : *list) {
    const auto word = node.value_exact<std::string>();
    if (!word) fail_at(node, key, "a text is needed, not " + kind_of(node));
    if (std::find(known.begin(), known.end(), *word) == known.end())
      fail_at(node, key, "unknown '" + *word + "'; " + suggest(*word, known));
    if (std::find(chosen.begin(), chosen.end(), *word) != chosen.end())
      fail_at(node, key, "'" + *word + "' is given twice");
    chosen.push_back(*word);
  }
  return chosen;
}

std::vector<const toml::node*> TomlTable::elements(std::string_view key, std::size_t count) const {
  const toml::node& node = require(key);
  std::vector<const toml::node*> found;
  if (const toml::array* array = node.as_array())
    for (const toml::node& each : *array) found.push_back(&each);
  else
    found.push_back(&node);
  if (found.size() != count)
    fail(key, std::to_string(count) + (count == 1 ? " value is" : " values are") +
                  " needed (one for each axis), not " + std::to_string(found.size()));
  return found;
}

std::vector<double> TomlTable::numbers(std::string_view key, std::size_t count) const {
  std::vector<double> values;
  for (const toml::node* node : elements(key, count)) {
    const auto value = node->value<double>();
    if (!value || node->is_boolean() || !std::isfinite(*value))
      fail_at(*node, key, "finite numbers are needed");
    values.push_back(*value);
  }
  return values;
}

TomlTable TomlTable::table(std::string_view key) const {
  static const toml::table empty;
  const toml::node* node = find(key);
  if (node && !node->is_table()) fail(key, "is a table: write [" + full(key) + "]");
  return {*file_, full(key), node ? *node->as_table() : empty};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  std::vector<TomlTable> found;
  const toml::node* node = find(key);
  if (!node) return found;
  const toml::array* array = node->as_array();
  if (!array) fail(key, "is a list of tables: write [[" + full(key) + "]]");
  int number = 0;
  for (const toml::node& each : *array) {
    if (!each.is_table()) fail_at(each, key, "is a list of tables: write [[" + full(key) + "]]");
    found.emplace_back(*file_, full(key) + " " + std::to_string(++number), *each.as_table());
  }
  return found;
}

void TomlTable::finish() const {
  std::string used;
  for (const std::string& key : asked_) used += (used.empty() ? "" : ", ") + key;
  for (const auto& [key, node] : *table_)
    if (!asked_.contains(key.str()))
      fail_at(node, key.str(), "has no meaning with the other keys here; those that have: " + used);
}

}  // namespace recon::mpm
