// Cells of a text file, row after row, into the columns of a ParticleTable.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recon/fields/particle_table.hpp"
#include "text_file.hpp"

namespace recon::detail {

class ColumnParser {
 public:
  ColumnParser(const TextFile& file, const std::vector<std::string>& names);

  std::size_t columns() const { return columns_.size(); }
  std::size_t rows() const { return lines_.size(); }

  // Reserves memory for so many rows, up to a bound, since what a file promises is not trusted.
  void reserve(std::size_t rows);

  // Adds a cell to the row that is being read: a number, or text that is kept until
  // it is asked for.
  void add_cell(std::size_t column, std::string_view cell);
  // Throws FileError for more rows than a table can number.
  void end_row();

  // Returns all columns. Cells that are one of the markers hold no value; a remark names what
  // cannot be used as numbers.
  ParticleTable finish(const std::vector<std::string>& missing) &&;

 private:
  const TextFile* file_;
  std::vector<ReadColumn> columns_;
  std::vector<std::size_t> lines_;
};

}  // namespace recon::detail
