#include "recon/fields/particle_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "recon/core/names.hpp"
#include "recon/fields/utf8.hpp"

namespace recon {

namespace {

using detail::require;

constexpr std::array<std::array<const char*, 5>, max_dimension> coordinate_names{{
    {"x", "X", "xu", "Points:0", "Points_0"},
    {"y", "Y", "yu", "Points:1", "Points_1"},
    {"z", "Z", "zu", "Points:2", "Points_2"},
}};

bool is_constant(const std::vector<double>& values) {
  return values.size() >= 2 && std::all_of(values.begin(), values.end(),
                                           [&](double value) { return value == values.front(); });
}

std::string of(const std::string& source) {
  return source.empty() ? "" : " of " + source;
}

// "b = (1.5, 6, 0)".
std::string edge_text(const SimulationCell& cell, int edge) {
  std::string text = std::string(1, "abc"[edge]) + " = (";
  for (int d = 0; d < max_dimension; ++d) {
    std::ostringstream number;
    number << cell.edges[edge][d];
    text += (d > 0 ? ", " : "") + number.str();
  }
  return text + ")";
}

// Text from a file in a message: in quotes, cut to a bearable length.
std::string quoted(std::string_view text) {
  constexpr std::size_t most = 60;
  std::string plain = to_utf8(text.substr(0, most));
  for (char& c : plain)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return "'" + plain + (text.size() > most ? "...'" : "'");
}

// What is wrong with a cell that is no number.
std::string rule_for(std::string_view text) {
  if (text.empty()) return "is an empty cell, and a number is needed where the column is used";
  if (text.find_first_not_of("0123456789.eE+-") == std::string_view::npos &&
      text.find_first_of("0123456789") != std::string_view::npos)
    return "is no number that double can hold";
  std::string rule = "is not a number, and one is needed where the column is used";
  if (text.find(',') != std::string_view::npos)
    rule += "; numbers are written with a decimal point, 1.5 and not 1,5";
  return rule;
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

bool ParticleTable::Column::is_numbers() const {
  if (repeated) return false;
  for (std::size_t cell = 0; cell < texts.size(); ++cell)
    if (!texts.text(cell).empty()) return false;
  return true;
}

const ParticleTable::Column& ParticleTable::find(std::string_view name) const {
  const auto found = columns_by_name_.find(name);
  if (found == columns_by_name_.end())
    detail::throw_invalid("column", name,
                          names_.empty() ? "the table has no columns of numbers"
                                         : "there is no such column; " + suggest(name, names_));
  const Column& column = columns_[found->second];
  if (!column.repeated) return column;
  std::string places;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].name == name) places += (places.empty() ? "" : ", ") + std::to_string(i + 1);
  detail::throw_invalid("column", name,
                        "is the name of several columns" + of(source) + " (numbers " + places +
                            "): each needs its own to be used");
}

void ParticleTable::add_column(std::string name, std::vector<double> values) {
  require(!has(name), "name of a column", name, "must be used only once");
  add(ReadColumn{std::move(name), std::move(values), {}});
  names_.push_back(columns_.back().name);
}

void ParticleTable::add_read_columns(std::vector<ReadColumn> columns) {
  for (ReadColumn& column : columns) add(std::move(column));
  update_names();
}

void ParticleTable::add(ReadColumn column) {
  require(!column.name.empty(), "name of a column", "''", "must not be empty");
  if (!columns_.empty() && column.values.size() != size())
    detail::throw_invalid("number of values of column " + column.name, column.values.size(),
                          "must be that of the other columns, " + std::to_string(size()));
  require(column.values.size() < std::numeric_limits<std::uint32_t>::max(), "number of rows",
          column.values.size(), "must be below 2^32 - 1");
  const auto [place, is_new] = columns_by_name_.emplace(column.name, columns_.size());
  if (!is_new) columns_[place->second].repeated = true;
  columns_.push_back({std::move(column), {}, !is_new});
}

void ParticleTable::update_names() {
  names_.clear();
  for (const Column& column : columns_)
    if (column.is_numbers()) names_.push_back(column.name);
}

std::vector<std::string> ParticleTable::text_columns() const {
  std::vector<std::string> names;
  for (const Column& column : columns_)
    if (!column.repeated && !column.is_numbers()) names.push_back(column.name);
  return names;
}

std::string ParticleTable::describe_text(std::string_view name) const {
  const Column& column = find(name);
  for (std::size_t cell = 0; cell < column.texts.size(); ++cell) {
    if (column.texts.text(cell).empty()) continue;
    const std::uint32_t row = column.texts.row(cell);
    return quoted(column.texts.text(cell)) +
           (row < lines_.size() ? " on line " + std::to_string(lines_[row]) : "");
  }
  return "";
}

std::vector<std::string> ParticleTable::repeated_names() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].repeated && columns_by_name_.find(columns_[i].name)->second == i)
      names.push_back(columns_[i].name);
  return names;
}

std::vector<std::string> ParticleTable::all_names() const {
  std::vector<std::string> names;
  for (const Column& column : columns_)
    if (!column.repeated) names.push_back(column.name);
  return names;
}

const TextCells& ParticleTable::texts(std::string_view name) const {
  return find(name).texts;
}

const std::vector<double>& ParticleTable::raw_column(std::string_view name) const {
  return find(name).values;
}

const std::vector<double>& ParticleTable::column(std::string_view name) const {
  const Column& column = find(name);
  require_finite(column);
  return column.values;
}

void ParticleTable::require_finite(const Column& column) const {
  const std::vector<double>& values = column.values;
  const auto bad = std::find_if(values.begin(), values.end(),
                                [](double value) { return !std::isfinite(value); });
  if (bad == values.end()) return;
  const auto row = static_cast<std::uint32_t>(bad - values.begin());
  const std::string where = "column " + column.name + ", " + describe_row(row) + of(source);
  if (const std::optional<std::string_view> text = column.texts.at(row))
    detail::throw_invalid(where, quoted(*text), rule_for(*text));
  if (std::binary_search(column.missing.begin(), column.missing.end(), row))
    detail::throw_invalid(where, "missing", "a particle without a value must be left out");
  detail::throw_invalid(where, *bad, "must be a finite number where the column is used");
}

std::string ParticleTable::describe_row(std::size_t row) const {
  std::string text = "row " + std::to_string(row < source_rows_.size() ? source_rows_[row] : row);
  std::string known;
  const auto id = columns_by_name_.find("id");
  if (id != columns_by_name_.end() && row < size()) {
    const double number = columns_[id->second].values[row];
    if (std::isfinite(number)) known = "id " + detail::to_text(number);
  }
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
  std::vector<std::uint32_t> new_rows(kept.size());
  for (std::size_t row = 0, next = 0; row < kept.size(); ++row) {
    new_rows[row] = static_cast<std::uint32_t>(next);
    next += kept[row] ? 1 : 0;
  }
  for (Column& column : columns_) {
    keep(column.values);
    column.texts.keep_rows(kept);
    std::erase_if(column.missing, [&](std::uint32_t row) { return !kept[row]; });
    for (std::uint32_t& row : column.missing) row = new_rows[row];
  }
  keep(lines_);
  const bool all = std::find(kept.begin(), kept.end(), false) == kept.end();
  if (source_rows_.empty() && !all) {
    source_rows_.resize(kept.size());
    std::iota(source_rows_.begin(), source_rows_.end(), std::size_t{0});
  }
  keep(source_rows_);
  update_names();
}

void ParticleTable::declare_missing(std::string_view marker) {
  double number = 0;
  const std::string_view figures = marker.substr(marker.starts_with('+') ? 1 : 0);
  const auto parsed = std::from_chars(figures.data(), figures.data() + figures.size(), number);
  const bool is_number =
      !figures.empty() && parsed.ec == std::errc() && parsed.ptr == figures.data() + figures.size();
  const auto is_marked = [&](double value) {
    return value == number || (std::isnan(value) && std::isnan(number));
  };
  for (Column& column : columns_) {
    std::vector<std::uint32_t> found;
    column.texts.erase_if([&](std::uint32_t row, std::string_view text) {
      if (text == marker) found.push_back(row);
      return text == marker;
    });
    for (std::uint32_t row = 0; is_number && row < column.values.size(); ++row)
      if (is_marked(column.values[row]) && !column.texts.at(row)) found.push_back(row);
    for (const std::uint32_t row : found)
      column.values[row] = std::numeric_limits<double>::quiet_NaN();
    column.missing.insert(column.missing.end(), found.begin(), found.end());
    std::sort(column.missing.begin(), column.missing.end());
    column.missing.erase(std::unique(column.missing.begin(), column.missing.end()),
                         column.missing.end());
  }
  update_names();
}

std::size_t ParticleTable::leave_out_missing(const std::vector<std::string>& columns) {
  std::vector<bool> kept(size(), true);
  std::size_t count = 0;
  std::string names;
  for (const std::string& name : columns) {
    const Column& column = find(name);
    if (!column.missing.empty()) names += (names.empty() ? "" : ", ") + name;
    for (const std::uint32_t row : column.missing) {
      count += kept[row] ? 1 : 0;
      kept[row] = false;
    }
  }
  if (count == 0) return 0;
  remarks.push_back("left out, without a value in " + names + ": " + std::to_string(count) +
                    " of " + std::to_string(size()) + " particles");
  keep_rows(kept);
  return count;
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
  // A coordinate that is there, but as text or twice, is not passed over.
  for (int d = 0; d < max_dimension; ++d)
    if (!found[d].empty()) raw_column(found[d]);
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
  cell_.reset();
  periods_ = {box.lower, box.upper, {}};
  for (int d = 0; d < box.dimension; ++d) periods_.periodic[d] = box.extent(d) > 0;
  periodic_ = periodic_edges_ = periodic;
}

void ParticleTable::set_cell(const SimulationCell& cell, std::array<bool, max_dimension> periodic) {
  Box<double> around = Box<double>::empty(max_dimension);
  PeriodicDomain<double> periods;
  std::array<bool, max_dimension> along{};  // the axis is periodic
  bool all_along = true;
  std::string left_out;
  for (int d = 0; d < max_dimension; ++d) around.lower[d] = around.upper[d] = cell.origin[d];
  for (int e = 0; e < max_dimension; ++e) {
    const std::array<double, max_dimension>& edge = cell.edges[e];
    const double length = std::hypot(edge[0], edge[1], edge[2]);
    require(std::isfinite(length) && (length > 0 || !periodic[e]), "edge of the simulation cell",
            length, "must be finite, and not 0 where the cell is periodic");
    bool parallel = false;
    for (int d = 0; d < max_dimension; ++d) {
      (edge[d] < 0 ? around.lower : around.upper)[d] += edge[d];
      if (length == 0 || std::abs(edge[d]) < length * (1 - 1e-13)) continue;
      if (std::hypot(edge[(d + 1) % 3], edge[(d + 2) % 3]) > 1e-12 * length) continue;
      parallel = true;
      periods.periodic[d] = true;
      periods.lower[d] = cell.origin[d] + std::min(edge[d], 0.0);
      periods.upper[d] = cell.origin[d] + std::max(edge[d], 0.0);
      along[d] = periodic[e];
    }
    all_along = all_along && parallel;
    if (!parallel && periodic[e]) left_out += (left_out.empty() ? "" : ", ") + edge_text(cell, e);
  }
  set_box(around, {});
  periods_ = periods;
  periodic_ = along;
  periodic_edges_ = periodic;
  if (!all_along) cell_ = cell;
  if (!left_out.empty())
    remarks.push_back("the box is triclinic; its periods along " + left_out +
                      " are left out, as only periods along the axes are searched");
}

std::optional<SimulationCell> ParticleTable::source_cell() const {
  if (cell_ || !box_) return cell_;
  SimulationCell cell;
  for (int d = 0; d < box_->dimension; ++d) {
    cell.origin[d] = box_->lower[d];
    cell.edges[d][d] = box_->extent(d);
  }
  return cell;
}

std::string ParticleTable::why_not_periodic(int axis, int dimension) const {
  const PeriodicDomain<double> possible = possible_domain(dimension);
  require(axis >= 0 && axis < max_dimension, "axis", axis, "must be 0, 1 or 2");
  if (possible.periodic[axis]) return "";
  if (!box_) return "the source tells no box";
  if (!cell_) return "the box has no extent there";
  const int of_source = box_axes(dimension)[static_cast<std::size_t>(axis)];
  return "the box is triclinic, its edge " + edge_text(*cell_, of_source) +
         " is not along the axis, and only periods along the axes are searched";
}

// Axes of the source's box that the coordinates lie along.
std::vector<int> ParticleTable::box_axes(int dimension) const {
  std::vector<int> axes = this->axes(dimension);
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
  PeriodicDomain<double> domain = possible_domain(dimension);
  if (!box_) return domain;
  const std::vector<int> axes = box_axes(dimension);
  for (std::size_t d = 0; d < axes.size(); ++d) domain.periodic[d] = periodic_[axes[d]];
  return domain;
}

PeriodicDomain<double> ParticleTable::possible_domain(int dimension) const {
  PeriodicDomain<double> domain;
  if (!box_) return domain;
  const std::vector<int> axes = box_axes(dimension);
  for (std::size_t d = 0; d < axes.size(); ++d) {
    domain.lower[d] = periods_.lower[axes[d]];
    domain.upper[d] = periods_.upper[axes[d]];
    domain.periodic[d] = periods_.periodic[axes[d]];
  }
  return domain;
}

void ParticleTable::set_lines(std::vector<std::size_t> lines) {
  require(lines.empty() || lines.size() == size(), "number of line numbers", lines.size(),
          "must be one per row");
  lines_ = std::move(lines);
}

void ParticleTable::set_source_rows(std::vector<std::size_t> rows) {
  require(rows.size() == size(), "number of rows of the source", rows.size(),
          "must be one per row");
  source_rows_ = std::move(rows);
}

}  // namespace recon
