#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "csv_text.hpp"
#include "number_text.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/write.hpp"

namespace recon {

namespace {

std::string header(int dimension, const FieldSet& fields) {
  std::vector<std::string> names;
  for (int d = 0; d < dimension; ++d) names.emplace_back(1, "xyz"[d]);
  for (const NamedField& field : fields)
    for (int c = 0; c < field.components; ++c)
      names.push_back(field.name + component_suffix(field, c, dimension));
  std::unordered_set<std::string> used;
  std::string line;
  for (const std::string& name : names) {
    detail::require(
        used.insert(name).second, "name of a column", name,
        "must be used only once in a CSV file (coordinates are x, y, z); rename the field");
    if (!line.empty()) line += ',';
    line += detail::csv_name(name);
  }
  return line + '\n';
}

void append_value(std::string& line, double value, NumberType type) {
  if (std::isnan(value)) {
    line += "nan";
  } else if (type == NumberType::int32) {
    detail::append_number(line, static_cast<std::int32_t>(value));
  } else if (type == NumberType::float32) {
    detail::append_number(line, static_cast<float>(value));
  } else {
    detail::append_number(line, value);
  }
}

}  // namespace

void write_csv(const std::filesystem::path& path, const PointsView<double>& points,
               const FieldSet& fields) {
  fields.require_size(points.size());
  bounding_box(points);  // throws for a coordinate that is not finite
  AtomicFile file(path);
  file.write(header(points.dimension(), fields));
  std::string line;
  for (std::size_t i = 0; i < points.size(); ++i) {
    line.clear();
    for (int d = 0; d < points.dimension(); ++d) {
      if (d > 0) line += ',';
      detail::append_number(line, points(i, d));
    }
    for (const NamedField& field : fields) {
      const double* values = field.values.data() + i * static_cast<std::size_t>(field.components);
      for (int c = 0; c < field.components; ++c) {
        line += ',';
        append_value(line, values[c], field.type);
      }
    }
    line += '\n';
    file.write(line);
  }
  file.commit();
}

}  // namespace recon
