#include "recon/fields/particle_table.hpp"

#include <algorithm>
#include <cmath>

#include "recon/core/names.hpp"

namespace recon {

namespace {

constexpr std::array<std::array<const char*, 5>, max_dimension> coordinate_names{{
    {"x", "X", "xu", "Points:0", "Points_0"},
    {"y", "Y", "yu", "Points:1", "Points_1"},
    {"z", "Z", "zu", "Points:2", "Points_2"},
}};

bool is_constant(const std::vector<double>& values) {
  return values.size() >= 2 && std::all_of(values.begin(), values.end(),
                                           [&](double value) { return value == values.front(); });
}

void require_dimension(int dimension) {
  require(dimension >= 0 && dimension <= max_dimension, "dimension", dimension,
          "must be 1, 2 or 3, or 0 to detect it");
}

}  // namespace

std::optional<int> axis_of_coordinate(std::string_view name) {
  for (int d = 0; d < max_dimension; ++d)
    for (const char* known : coordinate_names[d])
      if (name == known) return d;
  return {};
}

std::size_t ParticleTable::find(std::string_view name) const {
  return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
}

bool ParticleTable::has(std::string_view name) const {
  return find(name) < names_.size();
}

void ParticleTable::add_column(std::string name, std::vector<double> values) {
  require(!name.empty(), "name of a column", "''", "must not be empty");
  require(!has(name), "name of a column", name, "must be used only once");
  if (!columns_.empty() && values.size() != size())
    detail::throw_invalid("number of values of column " + name, values.size(),
                          "must be that of the other columns, " + std::to_string(size()));
  columns_.push_back(std::move(values));
  names_.push_back(std::move(name));
}

const std::vector<double>& ParticleTable::raw_column(std::string_view name) const {
  const std::size_t column = find(name);
  if (column < names_.size()) return columns_[column];
  for (const TextColumn& text : text_columns_) {
    if (text.name != name) continue;
    std::string rule = "holds text ('" + text.example + "' on line " + std::to_string(text.line) +
                       "), a column of numbers is needed";
    if (text.example.find(',') != std::string::npos)
      rule += "; numbers are written with a decimal point, 1.5 and not 1,5";
    detail::throw_invalid("column", name, rule);
  }
  detail::throw_invalid("column", name,
                        names_.empty() ? "the table has no columns of numbers"
                                       : "there is no such column; " + suggest(name, names_));
}

const std::vector<double>& ParticleTable::column(std::string_view name) const {
  const std::vector<double>& values = raw_column(name);
  require_finite(find(name));
  return values;
}

void ParticleTable::require_finite(std::size_t column) const {
  const std::vector<double>& values = columns_[column];
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isfinite(values[row])) continue;
    const std::string where = source.empty() ? "" : " of " + source;
    detail::throw_invalid(
        "column " + names_[column] + ", " + describe_row(row) + where, values[row],
        "must be a finite number where the column is used (an empty cell is NaN)");
  }
}

std::string ParticleTable::describe_row(std::size_t row) const {
  std::string text = "row " + std::to_string(row), known;
  const std::size_t id = find("id");
  if (id < names_.size() && row < size() && std::isfinite(columns_[id][row]))
    known = "id " + detail::to_text(columns_[id][row]);
  if (row < lines_.size())
    known += (known.empty() ? "line " : ", line ") + std::to_string(lines_[row]);
  return known.empty() ? text : text + " (" + known + ")";
}

void ParticleTable::keep_rows(const std::vector<bool>& kept) {
  require(kept.size() == size(), "number of rows to keep or not", kept.size(),
          "must be that of the rows");
  const auto keep = [&](auto& values) {
    std::size_t next = 0;
    for (std::size_t row = 0; row < values.size(); ++row)
      if (kept[row]) values[next++] = values[row];
    values.resize(next);
  };
  for (std::vector<double>& column : columns_) keep(column);
  keep(lines_);
}

NamedField ParticleTable::field(std::string name, const std::vector<std::string>& columns) const {
  require(!columns.empty(), "columns of a field", "none", "must be at least one");
  std::vector<const std::vector<double>*> sources;
  for (const std::string& each : columns) sources.push_back(&column(each));
  NamedField field{std::move(name), static_cast<int>(columns.size()), {}, NumberType::float64};
  field.values.reserve(size() * columns.size());
  for (std::size_t row = 0; row < size(); ++row)
    for (const auto* values : sources) field.values.push_back((*values)[row]);
  return field;
}

void ParticleTable::set_coordinates(std::vector<std::string> columns) {
  require(columns.size() >= 1 && columns.size() <= max_dimension, "number of coordinate columns",
          columns.size(), "must be 1, 2 or 3");
  for (const std::string& name : columns) raw_column(name);
  for (std::size_t i = 0; i < columns.size(); ++i)
    require(std::find(columns.begin(), columns.begin() + static_cast<std::ptrdiff_t>(i),
                      columns[i]) == columns.begin() + static_cast<std::ptrdiff_t>(i),
            "coordinate column", columns[i], "must be named only once");
  coordinates_ = std::move(columns);
}

// As many axes as have a column, whether constant or not.
std::vector<std::string> ParticleTable::detected_coordinates() const {
  std::array<std::string, max_dimension> found;
  for (int d = 0; d < max_dimension; ++d)
    for (const char* name : coordinate_names[d])
      if (found[d].empty() && has(name)) found[d] = name;
  for (int d = 0; d < max_dimension; ++d)
    for (const TextColumn& text : text_columns_)
      if (found[d].empty() && text.name == coordinate_names[d][0])
        raw_column(text.name);  // throws: says that it holds text
  if (found[0].empty() && found[1].empty() && found[2].empty()) {
    std::string names;
    for (const std::string& name : names_) names += (names.empty() ? "" : ", ") + name;
    detail::throw_invalid("coordinate column x", "not found",
                          "columns x, y, z (or xu, yu, zu) are taken as coordinates unless others "
                          "are named; the columns are: " +
                              (names.empty() ? "none" : names));
  }
  std::vector<std::string> columns;
  for (const std::string& name : found)
    if (!name.empty()) columns.push_back(name);
  return columns;
}

std::vector<std::string> ParticleTable::varying_coordinates() const {
  if (!coordinates_.empty()) return coordinates_;
  const std::vector<std::string> all = detected_coordinates();
  std::vector<std::string> varying;
  for (const std::string& name : all)
    if (!is_constant(raw_column(name))) varying.push_back(name);
  return varying.empty() ? all : varying;
}

int ParticleTable::dimension() const {
  return static_cast<int>(varying_coordinates().size());
}

std::vector<std::string> ParticleTable::all_coordinates() const {
  return coordinates_.empty() ? detected_coordinates() : coordinates_;
}

std::vector<std::string> ParticleTable::coordinates(int dimension) const {
  require_dimension(dimension);
  std::vector<std::string> columns = varying_coordinates();
  const std::size_t wanted = dimension == 0 ? columns.size() : static_cast<std::size_t>(dimension);
  if (columns.size() != wanted) columns = all_coordinates();
  require(wanted <= columns.size(), "dimension", wanted,
          "must not exceed the number of coordinate columns");
  columns.resize(wanted);
  return columns;
}

std::vector<int> ParticleTable::axes(int dimension) const {
  std::vector<int> axes, places;
  bool distinct = true;
  for (const std::string& name : coordinates(dimension)) {
    places.push_back(static_cast<int>(places.size()));
    const int axis = axis_of_coordinate(name).value_or(places.back());
    distinct = distinct && std::find(axes.begin(), axes.end(), axis) == axes.end();
    axes.push_back(axis);
  }
  return distinct ? axes : places;
}

PointsView<double> ParticleTable::positions(int dimension) const {
  const std::vector<std::string> columns = coordinates(dimension);
  std::array<const void*, max_dimension> base{};
  for (std::size_t d = 0; d < columns.size(); ++d) base[d] = column(columns[d]).data();
  constexpr std::ptrdiff_t number = sizeof(double);
  return {size(), static_cast<int>(columns.size()), base, {number, number, number}};
}

void ParticleTable::set_box(const Box<double>& box, std::array<bool, max_dimension> periodic) {
  require(box.dimension >= 1 && box.dimension <= max_dimension, "dimension of the simulation box",
          box.dimension, "must be 1, 2 or 3");
  for (int d = 0; d < box.dimension; ++d)
    require(
        std::isfinite(box.lower[d]) && std::isfinite(box.upper[d]) && box.lower[d] <= box.upper[d],
        "extent of the simulation box", box.extent(d), "must be finite and not negative");
  PeriodicDomain<double>{box.lower, box.upper, periodic}.validate(box.dimension);
  box_ = box;
  periodic_ = periodic;
}

// Axes of the source's box that the coordinates lie along.
std::vector<int> ParticleTable::box_axes(int dimension) const {
  const std::vector<int> axes = this->axes(dimension);
  for (const int axis : axes)
    require(axis < box_->dimension, "axis of the simulation box", axis,
            "must be one that the box has");
  return axes;
}

Box<double> ParticleTable::box(int dimension) const {
  if (!box_) return bounding_box(positions(dimension), "particles");
  const std::vector<int> axes = box_axes(dimension);
  Box<double> box = Box<double>::empty(static_cast<int>(axes.size()));
  for (std::size_t d = 0; d < axes.size(); ++d) {
    box.lower[d] = box_->lower[axes[d]];
    box.upper[d] = box_->upper[axes[d]];
  }
  return box;
}

PeriodicDomain<double> ParticleTable::domain(int dimension) const {
  PeriodicDomain<double> domain;
  if (!box_) return domain;
  const std::vector<int> axes = box_axes(dimension);
  for (std::size_t d = 0; d < axes.size(); ++d) {
    domain.lower[d] = box_->lower[axes[d]];
    domain.upper[d] = box_->upper[axes[d]];
    domain.periodic[d] = periodic_[axes[d]];
  }
  return domain;
}

void ParticleTable::set_lines(std::vector<std::size_t> lines) {
  require(lines.empty() || lines.size() == size(), "number of line numbers", lines.size(),
          "must be one per row");
  lines_ = std::move(lines);
}

void ParticleTable::add_text_column(std::string name, std::string example, std::size_t line) {
  text_columns_.push_back({std::move(name), std::move(example), line});
}

std::vector<std::string> ParticleTable::text_columns() const {
  std::vector<std::string> names;
  for (const TextColumn& text : text_columns_) names.push_back(text.name);
  return names;
}

}  // namespace recon
