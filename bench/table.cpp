#include "table.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace recon_bench {

std::string number(double value) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void Table::add(std::vector<std::string> cells) {
  if (cells.size() != columns_.size())
    throw std::invalid_argument("table " + name_ + ": a row of " + std::to_string(cells.size()) +
                                " cells for " + std::to_string(columns_.size()) + " columns");
  rows_.push_back(std::move(cells));
}

void Table::write_csv(const std::filesystem::path& folder) const {
  std::ofstream file(folder / (name_ + ".csv"));
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool quoted = cells[i].find_first_of(",\"\n") != std::string::npos;
      std::string text;
      for (const char c : cells[i]) text += c == '"' ? std::string("\"\"") : std::string(1, c);
      file << (i ? "," : "") << (quoted ? '"' + text + '"' : text);
    }
    file << '\n';
  };
  line(columns_);
  for (const auto& row : rows_) line(row);
  file.close();
  if (!file) throw std::runtime_error("cannot write " + (folder / (name_ + ".csv")).string());
}

std::string Table::markdown() const {
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    for (const auto& cell : cells) text += "| " + cell + " ";
    text += "|\n";
  };
  line(columns_);
  line(std::vector<std::string>(columns_.size(), "---"));
  for (const auto& row : rows_) line(row);
  return text;
}

}  // namespace recon_bench
