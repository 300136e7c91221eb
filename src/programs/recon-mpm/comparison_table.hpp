// The rows of recon-mpm compare: printed, written, and read again where a run that was cut off goes on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recon/studies/comparison.hpp"

namespace recon::program {

struct TableRow {
  mpm::ComparisonRow numbers;
  std::string remark;  // why it was refused or stopped, nodes of negative mass
  std::string run;     // stands for all that defines the row, but for its method and courant number
};

TableRow table_row(mpm::ComparisonRow row, const std::string& run);

// What is measured: the name in the table file, a short one for the terminal, how to print it.
struct TableColumn {
  const char *name, *brief, *format;
  double mpm::ComparisonRow::*value;
};
// The column of "displacement", "velocity", "angular" or "energy" errors.
const TableColumn& error_column(const std::string& of);

void print_table(const std::vector<TableRow>& rows);
// The file is written whole or not at all. Throws FileError.
void write_table(const std::filesystem::path& path, const std::vector<TableRow>& rows);
// What write_table() wrote; nothing where there is no such file. Throws FileError naming the line.
std::vector<TableRow> read_table(const std::filesystem::path& path);

}  // namespace recon::program
