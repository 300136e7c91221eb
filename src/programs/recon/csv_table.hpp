// CSV files whose columns are numbers or words: results with the state of each fit spelt out.
//
// Numbers have the fewest digits that read back to the same bits; NaN is written as nan. The file
// appears whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "recon/fields/field_set.hpp"
#include "recon/operators/fit_summary.hpp"
#include "recon/points/view.hpp"

namespace recon::program {

struct CsvColumn {
  std::string name;
  std::function<void(std::size_t row, std::string& text)> append;
};

// A column of numbers; `values` must outlive it.
CsvColumn number_column(std::string name, const std::vector<double>& values);

void write_csv_table(const std::filesystem::path& path, const std::vector<CsvColumn>& columns,
                     std::size_t rows);

// The axes by their letters ("xz": x and z), the fields up to the reports, then neighbours, rank,
// degree, status in words, and limited.
void write_csv_fields(const std::filesystem::path& path, const PointsView<double>& points,
                      const std::string& letters, const FieldSet& fields,
                      const FitReports& reports);
// The same with all fields and no reports.
void write_csv_fields(const std::filesystem::path& path, const PointsView<double>& points,
                      const std::string& letters, const FieldSet& fields);

}  // namespace recon::program
