#include "read_array.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/lower_case.hpp"

namespace recon::detail {

namespace {

struct Known {
  std::string_view array, prefix;
};
// The first name of each prefix is the one that is written.
constexpr std::array known_arrays{
    Known{"position", ""},  Known{"positions", ""},   Known{"pos", ""},    Known{"coordinates", ""},
    Known{"velocity", "v"}, Known{"velocities", "v"}, Known{"velo", "v"},  Known{"vel", "v"},
    Known{"force", "f"},    Known{"forces", "f"},     Known{"image", "i"},
};

}  // namespace

std::string column_name(const std::string& array, int component, int components,
                        const std::vector<std::string>& component_names) {
  if (components == 1) return array;
  const auto c = static_cast<std::size_t>(component);
  if (components <= max_dimension) {
    const std::string axis(1, "xyz"[component]);
    for (const Known& known : known_arrays)
      if (known.array == lower_case(array)) return std::string(known.prefix) + axis;
    return array + "_" + axis;
  }
  const bool named = component_names.size() == static_cast<std::size_t>(components) &&
                     std::none_of(component_names.begin(), component_names.end(),
                                  [](const std::string& name) { return name.empty(); });
  if (named) return array + "_" + component_names[c];
  if (components == max_dimension * max_dimension)
    return array + "_" + "xyz"[component / max_dimension] + "xyz"[component % max_dimension];
  return array + "_" + std::to_string(component);
}

void add_columns(const ReadArray& array, std::vector<ReadColumn>& columns) {
  const auto count = static_cast<std::size_t>(array.components);
  const std::size_t rows = array.values.size() / count;
  for (std::size_t c = 0; c < count; ++c) {
    ReadColumn& column = columns.emplace_back();
    column.name =
        column_name(array.name, static_cast<int>(c), array.components, array.component_names);
    column.values.resize(rows);
    for (std::size_t i = 0; i < rows; ++i) column.values[i] = array.values[i * count + c];
  }
}

namespace {

// The columns that make up an array together with this one, which must be its first.
struct Group {
  std::string array;
  std::vector<std::string> columns;
};

Group group_of(const std::string& column) {
  constexpr int axes = max_dimension;
  if (column.ends_with("_xx")) {
    const std::string array = column.substr(0, column.size() - 3);
    Group tensor{array, {}};
    for (int c = 0; c < axes * axes; ++c)
      tensor.columns.push_back(column_name(array, c, axes * axes));
    return tensor;
  }
  if (!column.ends_with('x')) return {};
  const std::string stem = column.substr(0, column.size() - 1);
  std::string array = stem.size() > 1 && stem.ends_with('_') ? stem.substr(0, stem.size() - 1) : "";
  for (const Known& known : known_arrays)
    if (array.empty() && !known.prefix.empty() && known.prefix == stem) array = known.array;
  if (array.empty()) return {};
  Group vector{array, {}};
  for (int c = 0; c < axes; ++c) vector.columns.push_back(column_name(array, c, axes));
  return vector;
}

// Columns that LAMMPS and others keep as whole numbers.
bool is_whole(const std::string& name, const std::vector<double>& values) {
  constexpr std::array names{"id", "type", "mol", "molecule", "ix", "iy", "iz", "proc", "image"};
  if (std::find(names.begin(), names.end(), name) == names.end()) return false;
  constexpr double most = 9007199254740992;  // 2^53
  return std::all_of(values.begin(), values.end(), [](double value) {
    return value == std::floor(value) && std::abs(value) <= most;
  });
}

}  // namespace

std::vector<ReadArray> arrays_of(const ParticleTable& table,
                                 const std::vector<std::string>& names) {
  std::vector<ReadArray> arrays;
  std::vector<std::string> used;
  const auto is_in = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  // An array whose name a column has already stays apart.
  const auto is_whole_group = [&](const Group& group) {
    return !group.columns.empty() && !is_in(names, group.array) &&
           std::all_of(group.columns.begin(), group.columns.end(), [&](const std::string& part) {
             return is_in(names, part) && !is_in(used, part);
           });
  };
  for (const std::string& name : names) {
    if (is_in(used, name)) continue;
    Group group = group_of(name);
    if (!is_whole_group(group)) group = {name, {name}};
    used.insert(used.end(), group.columns.begin(), group.columns.end());
    ReadArray& array = arrays.emplace_back();
    array.name = group.array;
    array.components = static_cast<int>(group.columns.size());
    array.whole = true;
    array.values.resize(table.size() * group.columns.size());
    for (std::size_t c = 0; c < group.columns.size(); ++c) {
      const std::vector<double>& column = table.raw_column(group.columns[c]);
      array.whole = array.whole && is_whole(group.columns[c], column);
      for (std::size_t i = 0; i < table.size(); ++i)
        array.values[i * group.columns.size() + c] = column[i];
    }
  }
  return arrays;
}

}  // namespace recon::detail
