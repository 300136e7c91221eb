// Results with names: what the writers write.
//
// A NamedField holds `components` numbers for each of size() points, point after point (the value
// of component c at point i is values[i * components + c]). A FieldSet is a list of them that
// belong to the same points, with the step and the time they belong to, where these are known.
//
// Values are kept as double whatever they mean; `type` says how a file stores them. Counts, ranks,
// degrees and states are int32, so that a viewer shows 3 and not 3.0. NaN is allowed in float64 and
// float32 ("no value here": a masked node) and nowhere else.
//
// `kind` says what the components of a point are, for viewers that draw arrows or tensors. By
// default it follows from their number: as many components as there are dimensions are a vector,
// their square a tensor. In 1-D, where both are one, the field is a scalar.
//
// Wrong input throws InvalidArgument naming the field: an empty name, one that is not UTF-8 or has
// control characters, a name used twice, a number of values that is no multiple of the components,
// a value that the type cannot hold (2.5 or NaN as int32, 1e300 as float32).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "recon/points/view.hpp"

namespace recon {

enum class NumberType { float64, float32, int32 };

// scalars: numbers without a direction in space. vector: one component along each axis. tensor: row
// after row, xx, xy, yx, yy; or the nine of 3-D in any dimension (plane strain has a zz).
// symmetric_tensor: the upper triangle, row after row: xx, xy, yy.
enum class FieldKind { by_components, scalars, vector, tensor, symmetric_tensor };

struct NamedField {
  std::string name;
  int components = 1;
  std::vector<double> values;  // point-major: point after point
  NumberType type = NumberType::float64;
  FieldKind kind = FieldKind::by_components;

  // The number of points.
  std::size_t size() const { return values.size() / static_cast<std::size_t>(components); }

  // The values without a copy, as operators take them; valid while `values` is not changed.
  FieldView<double> view() const {
    constexpr std::ptrdiff_t number = sizeof(double);
    return {size(), components, values.data(), components * number, number};
  }

  // Throws InvalidArgument where a rule at the top of this file is broken.
  void validate() const;
};

// The suffix of a component's name: "_x", "_y", "_z" where there are as many components as
// dimensions, else "_0", "_1", ...; empty for a field of one component.
std::string component_suffix(const NamedField& field, int component, int dimension);

// Where the components of a field stand among those of 3-D: each at one of 3 places (x, y, z) for
// a vector, at one of 9 (xx, xy, ..., zz) for a tensor; xy of a symmetric tensor fills two
// places. Without places for scalars. Throws InvalidArgument for a number of components that the
// kind cannot have.
struct ComponentPlaces {
  int places = 0;                                               // 3 or 9; 0 for scalars
  std::array<int, 9> from{-1, -1, -1, -1, -1, -1, -1, -1, -1};  // component at a place, -1: zero
};
ComponentPlaces component_places(const NamedField& field, int dimension);
// The name of such a place: "x", ..., "zz".
std::string name_of_place(int place, int places);

class FieldSet {
 public:
  std::optional<std::int64_t> step;
  std::optional<double> time;

  // Appends a field after validating it.
  void add(NamedField field);
  void add(std::string name, int components, std::vector<double> values,
           NumberType type = NumberType::float64, FieldKind kind = FieldKind::by_components);

  // Throws InvalidArgument for an unknown name, with the nearest valid ones.
  const NamedField& operator[](std::string_view name) const;

  std::size_t size() const { return fields_.size(); }
  bool empty() const { return fields_.empty(); }
  auto begin() const { return fields_.begin(); }
  auto end() const { return fields_.end(); }

  // Throws InvalidArgument unless every field has one value per point.
  void require_size(std::size_t points) const;

 private:
  std::vector<NamedField> fields_;
  std::unordered_map<std::string, std::size_t> places_;  // in fields_
};

}  // namespace recon
