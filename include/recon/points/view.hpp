// Views of coordinates and fields where they lie: no copy, no adoption of a container.
//
// A PointsView reads coordinate `axis` of point `i`; a FieldView reads component `c` of the value
// at point `i`. Both are a base address per axis (or component) and one stride in bytes, which
// covers arrays of structs, structs of arrays, Eigen matrices, flat arrays and members of your own
// struct; where a type hides its coordinates behind accessors, a function reads them. make_view.hpp
// has the functions that build views (points_of, field_of); you rarely name these classes yourself.
//
// A view refers to your data: it must not outlive them. Scalar is float or double.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "recon/core/error.hpp"

namespace recon {

inline constexpr int max_dimension = 3;

template <class Scalar>
class PointsView {
  static_assert(std::is_same_v<Scalar, float> || std::is_same_v<Scalar, double>,
                "coordinates are float or double");

 public:
  using scalar_type = Scalar;
  // Reads one coordinate of the element at this address.
  using Reader = Scalar (*)(const void* element);

  PointsView() = default;

  // Coordinate `axis` of point i lies at base[axis] + i * stride[axis] (stride in bytes).
  PointsView(std::size_t size, int dimension, std::array<const void*, max_dimension> base,
             std::array<std::ptrdiff_t, max_dimension> stride)
      : size_(size), dimension_(dimension), stride_(stride) {
    detail::require(dimension >= 1 && dimension <= max_dimension, "dimension of the points",
                    dimension, "must be 1, 2 or 3");
    for (int d = 0; d < max_dimension; ++d) base_[d] = static_cast<const std::byte*>(base[d]);
  }

  // Elements of any type, read through one function per axis.
  PointsView(std::size_t size, int dimension, const void* first, std::ptrdiff_t stride,
             std::array<Reader, max_dimension> readers)
      : PointsView(size, dimension, {first, first, first}, {stride, stride, stride}) {
    readers_ = readers;
  }

  std::size_t size() const { return size_; }
  int dimension() const { return dimension_; }

  Scalar operator()(std::size_t point, int axis) const {
    const std::byte* at = base_[axis] + static_cast<std::ptrdiff_t>(point) * stride_[axis];
    return readers_[axis] ? readers_[axis](at) : *reinterpret_cast<const Scalar*>(at);
  }

 private:
  std::size_t size_ = 0;
  int dimension_ = 1;
  std::array<const std::byte*, max_dimension> base_{};
  std::array<std::ptrdiff_t, max_dimension> stride_{};
  std::array<Reader, max_dimension> readers_{};
};

// Points whose coordinates lie in one array per axis; arrays beyond the dimension are not read.
template <class Scalar>
PointsView<Scalar> points_of_axes(const std::array<std::vector<Scalar>, max_dimension>& axes,
                                  int dimension) {
  constexpr auto step = static_cast<std::ptrdiff_t>(sizeof(Scalar));
  return {axes[0].size(),
          dimension,
          {axes[0].data(), axes[1].data(), axes[2].data()},
          {step, step, step}};
}

// Values of `components` numbers at each of size() points; Scalar may be const (read) or not
// (write). Components lie side by side, or each in an array of its own.
template <class Scalar>
class BasicFieldView {
  using Byte = std::conditional_t<std::is_const_v<Scalar>, const std::byte, std::byte>;
  using Address = std::conditional_t<std::is_const_v<Scalar>, const void*, void*>;

 public:
  using scalar_type = std::remove_const_t<Scalar>;
  static constexpr int most_arrays = 9;  // of one component each: a tensor in three dimensions

  BasicFieldView() = default;

  // Component c of the value at point i lies at base + i * point_stride + c *
  // component_stride bytes.
  BasicFieldView(std::size_t size, int components, Address base, std::ptrdiff_t point_stride,
                 std::ptrdiff_t component_stride)
      : size_(size),
        components_(components),
        base_(static_cast<Byte*>(base)),
        point_stride_(point_stride),
        component_stride_(component_stride) {
    detail::require(components >= 1, "components of the field", components, "must be at least 1");
  }

  // Component c of the value at point i lies at arrays[c] + i * point_stride (bytes).
  template <class Array>
  BasicFieldView(std::size_t size, int components, const Array& arrays, std::ptrdiff_t point_stride)
      : BasicFieldView(size, components, arrays[0], point_stride, 0) {
    detail::require(components <= most_arrays, "components of the field", components,
                    "must be at most 9 where each has its array");
    separate_ = true;
    for (int c = 0; c < components; ++c)
      arrays_[c] = static_cast<Byte*>(static_cast<Address>(arrays[c]));
  }

  // A field that is written can be read.
  BasicFieldView(const BasicFieldView<scalar_type>& other) requires std::is_const_v<Scalar>
      : BasicFieldView(other.size(), other.components(), other.first(0), other.point_stride(),
                       other.component_stride()) {
    separate_ = other.separate();
    for (int c = 0; c < components_ && separate_; ++c)
      arrays_[c] = static_cast<Byte*>(other.first(c));
  }

  std::size_t size() const { return size_; }
  int components() const { return components_; }
  // Where component c of point 0 lies, and how many bytes further that of the next point.
  Address first(int c) const { return first_byte(c); }
  std::ptrdiff_t point_stride() const { return point_stride_; }
  // The values at `count` points from this one on.
  BasicFieldView part(std::size_t point, std::size_t count) const {
    BasicFieldView values = *this;
    const std::ptrdiff_t before = static_cast<std::ptrdiff_t>(point) * point_stride_;
    values.size_ = count;
    values.base_ += before;
    for (int c = 0; c < components_ && separate_; ++c) values.arrays_[c] += before;
    return values;
  }
  // Has each component an array of its own? If not, they lie component_stride() bytes apart.
  bool separate() const { return separate_; }
  std::ptrdiff_t component_stride() const { return component_stride_; }

  Scalar& operator()(std::size_t point, int component) const {
    return *reinterpret_cast<Scalar*>(first_byte(component) +
                                      static_cast<std::ptrdiff_t>(point) * point_stride_);
  }

 private:
  Byte* first_byte(int c) const { return separate_ ? arrays_[c] : base_ + c * component_stride_; }

  std::size_t size_ = 0;
  int components_ = 1;
  Byte* base_ = nullptr;
  std::ptrdiff_t point_stride_ = 0;
  std::ptrdiff_t component_stride_ = 0;
  bool separate_ = false;
  std::array<Byte*, most_arrays> arrays_{};
};

template <class Scalar>
using FieldView = BasicFieldView<const Scalar>;  // to be read
template <class Scalar>
using FieldSpan = BasicFieldView<Scalar>;  // to be written

}  // namespace recon
