// Reads tables of a TOML document strictly: every key must be known, every value of the right kind,
// and each complaint names file, line, key and the valid choices.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "runs/toml.hpp"

namespace recon::mpm {

class TomlTable {
 public:
  // Messages call the table `name`: "grid", "body 2", "" for the top of the file.
  TomlTable(const std::filesystem::path& file, std::string name, const toml::table& table)
      : file_(&file), name_(std::move(name)), table_(&table) {}

  bool has(std::string_view key) const { return find(key) != nullptr; }

  double number(std::string_view key) const;
  double number(std::string_view key, double otherwise) const;
  int integer(std::string_view key, int otherwise, int least, int most) const;
  bool boolean(std::string_view key, bool otherwise) const;
  std::string text(std::string_view key) const;
  // One of the choices. Where the key is absent it is the first, unless the key is required.
  std::string choice(std::string_view key, std::span<const std::string> choices,
                     bool required = false) const;
  // A list of some of the choices, none twice.
  std::vector<std::string> choices(std::string_view key, std::span<const std::string> known) const;
  std::vector<double> numbers(std::string_view key, std::size_t count) const;
  // The elements of an array (or the value itself) for the caller to interpret.
  std::vector<const toml::node*> elements(std::string_view key, std::size_t count) const;

  // The table of this name, or an empty one.
  TomlTable table(std::string_view key) const;
  // All tables [[key]].
  std::vector<TomlTable> tables(std::string_view key) const;

  // Throws for keys that were never asked for: the other keys leave them without a meaning.
  void finish() const;
  [[noreturn]] void fail(std::string_view key, const std::string& what) const;
  [[noreturn]] void fail_at(const toml::node& node, std::string_view key,
                            const std::string& what) const;
  const toml::table& raw() const { return *table_; }
  // The key as messages call it: "body 2.shape".
  std::string full(std::string_view key) const;

 private:
  const toml::node* find(std::string_view key) const;
  const toml::node& require(std::string_view key) const;

  const std::filesystem::path* file_;
  std::string name_;
  const toml::table* table_;
  mutable std::set<std::string, std::less<>> asked_;
};

// The keys that a file may hold, by their path ("body.shape" also for [[body]]). Tables that
// end in ".*" may have any keys. --set can name `settable` keys without their table,
// `others` only in full.
struct KnownKeys {
  std::vector<std::string> settable, others;
};

// Parses the text of a file and applies the settings. Throws FileError, for a key or table that is
// not known before anything else is asked about.
toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       std::span<const std::string> settings, const KnownKeys& known);

}  // namespace recon::mpm
