#include "column_parser.hpp"

#include <algorithm>
#include <limits>

namespace recon::detail {

namespace {

// The first few names of a list that may be long.
std::string some(const std::vector<std::string>& names) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i)
    text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

}  // namespace

ColumnParser::ColumnParser(const TextFile& file, const std::vector<std::string>& names)
    : file_(&file) {
  columns_.reserve(names.size());
  for (const std::string& name : names) columns_.push_back({name, {}, {}});
}

void ColumnParser::reserve(std::size_t rows) {
  constexpr std::size_t most_cells = 1 << 20;
  const std::size_t trusted = std::min(rows, most_cells / std::max<std::size_t>(columns(), 1));
  lines_.reserve(trusted);
  for (ReadColumn& column : columns_) column.values.reserve(trusted);
}

void ColumnParser::add_cell(std::size_t index, std::string_view cell) {
  ReadColumn& column = columns_[index];
  if (const std::optional<double> value = parse_number(cell)) {
    column.values.push_back(*value);
    return;
  }
  column.texts.add(static_cast<std::uint32_t>(rows()), cell);
  column.values.push_back(std::numeric_limits<double>::quiet_NaN());
}

void ColumnParser::end_row() {
  if (rows() + 1 >= std::numeric_limits<std::uint32_t>::max())
    file_->fail("more rows than a table of particles can number, 2^32 - 2");
  lines_.push_back(file_->line_number());
}

ParticleTable ColumnParser::finish(const std::vector<std::string>& missing) && {
  for (ReadColumn& column : columns_) column.values.shrink_to_fit();
  ParticleTable table;
  table.add_read_columns(std::move(columns_));
  for (const std::string& marker : missing) table.declare_missing(marker);
  if (table.size() > 0) table.set_lines(std::move(lines_));
  if (std::vector<std::string> texts = table.text_columns(); !texts.empty()) {
    for (std::string& name : texts) name += " (" + table.describe_text(name) + ")";
    table.remarks.push_back("columns that hold text are no fields: " + some(texts));
  }
  if (const auto repeated = table.repeated_names(); !repeated.empty())
    table.remarks.push_back("names of several columns, which can therefore not be used: " +
                            some(repeated));
  return table;
}

}  // namespace recon::detail
