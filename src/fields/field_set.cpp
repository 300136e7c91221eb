#include "recon/fields/field_set.hpp"

#include <cmath>
#include <limits>

#include "recon/core/names.hpp"

namespace recon {

namespace {

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

void FieldSet::add(NamedField field) {
  field.validate();
  for (const NamedField& other : fields_)
    require(other.name != field.name, "name of a field", field.name, "must be used only once");
  fields_.push_back(std::move(field));
}

void FieldSet::add(std::string name, int components, std::vector<double> values, NumberType type) {
  add(NamedField{std::move(name), components, std::move(values), type});
}

const NamedField& FieldSet::operator[](std::string_view name) const {
  std::vector<std::string> names;
  for (const NamedField& field : fields_) {
    if (field.name == name) return field;
    names.push_back(field.name);
  }
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
