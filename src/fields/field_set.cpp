#include "recon/fields/field_set.hpp"

#include <cmath>
#include <limits>

#include "recon/core/names.hpp"
#include "recon/fields/utf8.hpp"

namespace recon {

namespace {

using detail::require;

bool has_control_character(const std::string& text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return true;
  return false;
}

bool fits(double value, NumberType type) {
  if (type == NumberType::int32)
    return value == std::floor(value) &&
           std::abs(value) <= std::numeric_limits<std::int32_t>::max();
  if (type == NumberType::float32 && std::isfinite(value))
    return std::isfinite(static_cast<float>(value));
  return true;
}

}  // namespace

void NamedField::validate() const {
  require(!name.empty(), "name of a field", "''", "must not be empty");
  require(!has_control_character(name), "name of a field", name,
          "must not contain line breaks or other control characters");
  require(is_utf8(name), "name of a field", to_utf8(name), "must be UTF-8");
  if (components < 1)
    detail::throw_invalid("components of field " + name, components, "must be at least 1");
  if (values.size() % static_cast<std::size_t>(components) != 0)
    detail::throw_invalid(
        "number of values of field " + name, values.size(),
        "must be a multiple of its " + std::to_string(components) + " components");
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (fits(values[i], type)) continue;
    detail::throw_invalid("value of field " + name + " at point " +
                              std::to_string(i / static_cast<std::size_t>(components)),
                          values[i],
                          type == NumberType::int32 ? "must be a whole number of 32 bits"
                                                    : "must fit a 32-bit float");
  }
}

std::string component_suffix(const NamedField& field, int component, int dimension) {
  if (field.components == 1) return "";
  if (field.components == dimension) return std::string{'_', "xyz"[component]};
  return std::string("_").append(std::to_string(component));
}

ComponentPlaces component_places(const NamedField& field, int dimension) {
  const int components = field.components;
  FieldKind kind = field.kind;
  if (kind == FieldKind::by_components)
    kind = dimension > 1 && components == dimension               ? FieldKind::vector
           : dimension > 1 && components == dimension * dimension ? FieldKind::tensor
                                                                  : FieldKind::scalars;
  const auto require_components = [&](bool right, const char* rule) {
    if (!right) detail::throw_invalid("components of field " + field.name, components, rule);
  };
  ComponentPlaces places;
  if (kind == FieldKind::vector) {
    require_components(components == dimension || components == max_dimension,
                       "must be one for each axis, as the field is a vector");
    places.places = 3;
    for (int c = 0; c < components; ++c) places.from[c] = c;
  } else if (kind == FieldKind::tensor || kind == FieldKind::symmetric_tensor) {
    places.places = 9;
    const bool symmetric = kind == FieldKind::symmetric_tensor;
    const auto count = [&](int n) { return symmetric ? n * (n + 1) / 2 : n * n; };
    const int rows = components == count(max_dimension) ? max_dimension : dimension;
    require_components(components == count(rows),
                       symmetric ? "must be those of the upper triangle of a symmetric tensor"
                                 : "must be those of a tensor, row after row");
    for (int r = 0, c = 0; r < rows; ++r) {
      for (int s = symmetric ? r : 0; s < rows; ++s, ++c) {
        places.from[3 * r + s] = c;
        if (symmetric) places.from[3 * s + r] = c;
      }
    }
  }
  return places;
}

std::string name_of_place(int place, int places) {
  constexpr const char* axes = "xyz";
  if (places == 3) return {axes[place]};
  return {axes[place / 3], axes[place % 3]};
}

void FieldSet::add(NamedField field) {
  field.validate();
  const bool is_new = places_.emplace(field.name, fields_.size()).second;
  require(is_new, "name of a field", field.name, "must be used only once");
  fields_.push_back(std::move(field));
}

void FieldSet::add(std::string name, int components, std::vector<double> values, NumberType type,
                   FieldKind kind) {
  add(NamedField{std::move(name), components, std::move(values), type, kind});
}

const NamedField& FieldSet::operator[](std::string_view name) const {
  const auto place = places_.find(std::string(name));
  if (place != places_.end()) return fields_[place->second];
  std::vector<std::string> names;
  for (const NamedField& field : fields_) names.push_back(field.name);
  detail::throw_invalid("field", name,
                        names.empty() ? "there are no fields" : suggest(name, names));
}

void FieldSet::require_size(std::size_t points) const {
  for (const NamedField& field : fields_)
    if (field.size() != points)
      detail::throw_invalid("number of values of field " + field.name, field.size(),
                            "must be one per point, of which there are " + std::to_string(points));
}

}  // namespace recon
