// A table of numbers that grows with a run, as CSV: complete also where the run ends by an
// exception.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace recon::mpm {

// The first column of all rows is the number of the step. A run that goes on keeps the rows before
// its first step.
class RowsFile {
 public:
  // Throws FileError where the file cannot be written, and for a run that goes on with rows of
  // other columns.
  RowsFile(const std::filesystem::path& path, const std::string& header, bool goes_on,
           std::int64_t first_step);
  // Throw FileError where the file cannot be written.
  void add(const std::string& row);
  void flush();

 private:
  std::filesystem::path path_;
  std::ofstream out_;
};

}  // namespace recon::mpm
