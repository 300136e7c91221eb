// A table of results: written as CSV for programs and as Markdown for people.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace recon_bench {

class Table {
 public:
  Table(std::string name, std::vector<std::string> columns)
      : name_(std::move(name)), columns_(std::move(columns)) {}

  // One cell per column: texts, or numbers with as many digits as are worth reading. Throws
  // std::invalid_argument for another number of cells.
  void add(std::vector<std::string> cells);

  const std::string& name() const { return name_; }
  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<std::vector<std::string>>& rows() const { return rows_; }

  void write_csv(const std::filesystem::path& folder) const;  // <folder>/<name>.csv
  std::string markdown() const;

 private:
  std::string name_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// Four significant digits, or "-" for a NaN (not measured).
std::string number(double value);

}  // namespace recon_bench
