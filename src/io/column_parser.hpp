// Cells of a text file, row after row, into the columns of a ParticleTable.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recon/fields/particle_table.hpp"
#include "text_file.hpp"

namespace recon::detail {

// Throws FileError, at the line read last, for a name used twice.
class ColumnParser {
 public:
  ColumnParser(const TextFile& file, std::vector<std::string> names);

  std::size_t columns() const { return columns_.size(); }
  std::size_t rows() const { return lines_.size(); }

  // Memory for rows to come: a promise of the file that is not trusted beyond a bound.
  void reserve(std::size_t rows);

  // One cell of the row that is being read. What the column holds is decided by its first cell that
  // is not empty: a number or, unless the name is that of a coordinate, text.
  void add_cell(std::size_t column, std::string_view cell);
  void end_row() { lines_.push_back(file_->line_number()); }

  // All columns of numbers; those of text by name, with a remark.
  ParticleTable finish() &&;

 private:
  enum class Content { unknown, numbers, text };
  struct Column {
    std::string name;
    Content content = Content::unknown;
    std::vector<double> values;
    std::string example;  // of text, and its line
    std::size_t line = 0;
  };
  void add_other(Column& column, std::string_view cell);

  const TextFile* file_;
  std::vector<Column> columns_;
  std::vector<std::size_t> lines_;
};

}  // namespace recon::detail
