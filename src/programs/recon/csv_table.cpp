#include "csv_table.hpp"

#include <charconv>
#include <cmath>

#include "recon/io/atomic_file.hpp"

namespace recon::program {

namespace {

void append_number(double value, std::string& text) {
  if (std::isnan(value)) {
    text += "nan";
    return;
  }
  char digits[40];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

// Names that would not read back as they are stand in quotes.
std::string quoted(const std::string& name) {
  const bool plain = name.find_first_of(",;\t\"#% ") == std::string::npos &&
                     std::string_view("+-.0123456789").find(name[0]) == std::string_view::npos;
  if (plain) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + "\"";
}

// "_x", "_z" of a vector in the plane of x and z, "_0", "_1", ... of other components.
std::string suffix(const NamedField& field, int component, const std::string& letters) {
  if (field.components > 1 && field.components == static_cast<int>(letters.size()))
    return std::string("_") + letters[static_cast<std::size_t>(component)];
  return component_suffix(field, component, static_cast<int>(letters.size()));
}

std::vector<CsvColumn> field_columns(const PointsView<double>& points, const std::string& letters,
                                     const FieldSet& fields) {
  std::vector<CsvColumn> columns;
  for (int d = 0; d < points.dimension(); ++d)
    columns.push_back({std::string(1, letters[static_cast<std::size_t>(d)]),
                       [&points, d](std::size_t row, std::string& text) {
                         append_number(points(row, d), text);
                       }});
  for (const NamedField& field : fields) {
    if (field.name == "neighbours") break;  // here the reports begin
    for (int c = 0; c < field.components; ++c)
      columns.push_back(
          {field.name + suffix(field, c, letters), [&field, c](std::size_t row, std::string& text) {
             append_number(field.view()(row, c), text);
           }});
  }
  return columns;
}

}  // namespace

CsvColumn number_column(std::string name, const std::vector<double>& values) {
  return {std::move(name),
          [&values](std::size_t row, std::string& text) { append_number(values[row], text); }};
}

void write_csv_table(const std::filesystem::path& path, const std::vector<CsvColumn>& columns,
                     std::size_t rows) {
  AtomicFile file(path);
  std::string text;
  for (const CsvColumn& column : columns) {
    if (!text.empty()) text += ',';
    text += quoted(column.name);
  }
  text += '\n';
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (c > 0) text += ',';
      columns[c].append(row, text);
    }
    text += '\n';
    if (text.size() < (1u << 16)) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.commit();
}

void write_csv_fields(const std::filesystem::path& path, const PointsView<double>& points,
                      const std::string& letters, const FieldSet& fields,
                      const FitReports& reports) {
  std::vector<CsvColumn> columns = field_columns(points, letters, fields);
  const auto add_report = [&](const char* name, auto append) {
    columns.push_back({name, [&reports, append](std::size_t row, std::string& text) {
                         text += append(reports[row]);
                       }});
  };
  add_report("neighbours", [](const FitReport& r) { return std::to_string(r.neighbours); });
  add_report("rank", [](const FitReport& r) { return std::to_string(r.rank); });
  add_report("degree", [](const FitReport& r) { return std::to_string(r.degree); });
  add_report("status", [](const FitReport& r) { return std::string(name_of(r.status)); });
  columns.push_back(
      {"limited", [limited = fields["limited"].view()](std::size_t row, std::string& text) {
         append_number(limited(row, 0), text);
       }});
  write_csv_table(path, columns, points.size());
}

void write_csv_fields(const std::filesystem::path& path, const PointsView<double>& points,
                      const std::string& letters, const FieldSet& fields) {
  write_csv_table(path, field_columns(points, letters, fields), points.size());
}

}  // namespace recon::program
