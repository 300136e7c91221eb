#include "comparison_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "problem_options.hpp"
#include "programs/common/text.hpp"
#include "recon/io/atomic_file.hpp"

namespace recon::program {
namespace {

using Row = mpm::ComparisonRow;

constexpr TableColumn columns[] = {
    {"courant", "courant", "%.3g", &Row::courant},
    {"displacement error", "u error", "%.2e", &Row::displacement_error},
    {"order", "order", "%.2f", &Row::displacement_order},
    {"velocity error", "v error", "%.2e", &Row::velocity_error},
    {"order of velocity", "order", "%.2f", &Row::velocity_order},
    {"largest displacement", "max u", "%.4g", &Row::displacement},
    {"largest displacement before", "before", "%.4g", &Row::displacement_before},
    {"momentum defect", "momentum", "%.1e", &Row::momentum_defect},
    {"angular defect", "angular", "%.1e", &Row::angular_defect},
    {"angular error", "ang error", "%.1e", &Row::angular_error},
    {"energy error", "energy", "%+.1e", &Row::energy_error},
    {"ns per particle and step", "ns", "%.0f", &Row::nanoseconds},
    {"largest stable step", "stable", "%.2f", &Row::stable},
};

std::string header() {
  std::string text = "method";
  for (const TableColumn& column : columns) text += std::string(",") + column.name;
  return text + ",remark,run";
}

}  // namespace

TableRow table_row(Row row, const std::string& run) {
  std::string remark;
  if (!row.refusal.empty())
    remark = "refused: " + row.refusal;
  else if (!row.failure.empty())
    remark = "stopped: " + row.failure;
  if (row.negative_nodes > 0)
    remark += (remark.empty() ? "" : "; ") + counted(row.negative_nodes, "node") +
              " of negative mass" + (row.sign_change ? ", some change sign" : "");
  return {std::move(row), remark, run};
}

const TableColumn& error_column(const std::string& of) {
  return *std::find_if(std::begin(columns), std::end(columns), [&](const TableColumn& column) {
    return std::string(column.name) == of + " error";
  });
}

void print_table(const std::vector<TableRow>& rows) {
  std::vector<std::string> names;
  for (const TableRow& row : rows) names.push_back(row.numbers.method);
  const int width = name_width(20, names);
  std::printf("%-*s", width, "method");
  for (const TableColumn& column : columns) std::printf(" %9s", column.brief);
  std::printf("\n");
  for (const TableRow& row : rows) {
    std::printf("%-*s", width, row.numbers.method.c_str());
    for (const TableColumn& column : columns)
      std::printf(" %9s", or_dash(row.numbers.*column.value, column.format).c_str());
    std::printf("%s%s\n", row.remark.empty() ? "" : "  ", row.remark.c_str());
  }
  std::printf(
      "\nu, v: l2 errors at the end on the finest grid; max u: largest displacement, there and on "
      "the grid before;\n"
      "momentum, angular: what the velocity map misses, at worst; ang error, energy: of angular "
      "momentum and of the\n"
      "energy balance at the end, over their largest size; ns: per particle and step; stable: "
      "largest c_p dt / h\n");
}

void write_table(const std::filesystem::path& path, const std::vector<TableRow>& rows) {
  AtomicFile file(path);
  file.write(header() + "\n");
  for (const TableRow& row : rows) {
    std::string text = row.numbers.method;
    for (const TableColumn& column : columns) {
      const double value = row.numbers.*column.value;
      text += "," + (std::isnan(value) ? "" : number(value, 6));
    }
    std::string remark = row.remark;
    for (char& c : remark)
      if (c == '"')
        c = '\'';
      else if (c == '\n')
        c = ' ';
    file.write(text + "," + (remark.empty() ? "" : "\"" + remark + "\"") + "," + row.run + "\n");
  }
  file.commit();
}

std::vector<TableRow> read_table(const std::filesystem::path& path) {
  std::vector<TableRow> rows;
  if (!std::filesystem::exists(path)) return rows;
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != header())
    throw FileError(path, 1, "is no table of compare: its first line must be " + header());
  for (std::size_t n = 2; std::getline(file, line); ++n) {
    const std::vector<std::string> words = split(line);
    if (words.size() != std::size(columns) + 3 || words.front().empty())
      throw FileError(path, n, "is no row of the table");
    TableRow row;
    row.numbers.method = words.front();
    for (std::size_t c = 0; c < std::size(columns); ++c) {
      const std::string& word = words[c + 1];
      if (word.empty()) continue;  // there is none: NaN
      const auto value = to_number(word);
      if (!value) throw FileError(path, n, "'" + word + "' is no number");
      row.numbers.*columns[c].value = *value;
    }
    row.remark = words[words.size() - 2];
    row.run = words.back();
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace recon::program
