#include "column_parser.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace recon::detail {

namespace {

constexpr std::array<std::string_view, 18> always_numbers{
    "id", "x",  "y",  "z",  "X",   "Y",   "Z",   "xs",       "ys",
    "zs", "xu", "yu", "zu", "xsu", "ysu", "zsu", "Points:0", "Points:1"};

bool holds_numbers(std::string_view name) {
  return std::find(always_numbers.begin(), always_numbers.end(), name) != always_numbers.end();
}

}  // namespace

ColumnParser::ColumnParser(const TextFile& file, std::vector<std::string> names) : file_(&file) {
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (names[i] == names[j])
        file.fail("the name " + quote(names[i]) + " is that of columns " + std::to_string(j + 1) +
                  " and " + std::to_string(i + 1) + ": every column needs its own");
  for (std::string& name : names) {
    Column column;
    if (holds_numbers(name)) column.content = Content::numbers;
    column.name = std::move(name);
    columns_.push_back(std::move(column));
  }
}

void ColumnParser::reserve(std::size_t rows) {
  const std::size_t trusted = std::min<std::size_t>(rows, 1 << 16);
  lines_.reserve(trusted);
  for (Column& column : columns_) column.values.reserve(trusted);
}

void ColumnParser::add_cell(std::size_t index, std::string_view cell) {
  Column& column = columns_[index];
  if (column.content != Content::text) {
    if (const std::optional<double> value = parse_number(cell)) {
      column.content = Content::numbers;
      column.values.push_back(*value);
      return;
    }
  }
  add_other(column, cell);
}

void ColumnParser::add_other(Column& column, std::string_view cell) {
  if (column.content == Content::text) return;
  if (cell.empty()) {
    column.values.push_back(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const bool figures = cell.find_first_not_of("0123456789.eE+-") == std::string_view::npos;
  if (column.content == Content::numbers) {
    std::string rule = " is not a number: column " + quote(column.name) + " needs one";
    if (figures && cell.find_first_of("eE") != std::string_view::npos)
      rule = " is not a number that double can hold (column " + quote(column.name) + ")";
    if (cell.find(',') != std::string_view::npos)
      rule += ", with a decimal point (1.5 and not 1,5)";
    file_->fail(quote(cell) + rule);
  }
  column.content = Content::text;
  column.example = quote(cell).substr(1);
  column.example.pop_back();
  column.line = file_->line_number();
  column.values = {};
}

ParticleTable ColumnParser::finish() && {
  ParticleTable table;
  std::string text;
  for (Column& column : columns_) {
    if (column.content != Content::text) {
      column.values.shrink_to_fit();
      table.add_column(std::move(column.name), std::move(column.values));
      continue;
    }
    text += (text.empty() ? "" : ", ") + column.name;
    table.add_text_column(std::move(column.name), std::move(column.example), column.line);
  }
  if (!text.empty()) table.remarks.push_back("columns of text are left out: " + text);
  if (!table.names().empty()) table.set_lines(std::move(lines_));
  return table;
}

}  // namespace recon::detail
