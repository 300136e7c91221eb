// points_of(...) and field_of(...): how your data become views, without being copied.
//
//   what you have                                   how to say it
//   std::vector<Grain>, member Grain::position      points_of(grains, &Grain::position)
//   std::vector or span of std::array<double, 3>,   points_of(positions)
//     Eigen::Vector3d, struct { x, y, z; },
//     double[3], ...
//   one array per axis                              points_of(x, y), points_of(x, y, z)
//   one array, points in 1-D                        points_of(x)
//   Eigen matrix, a row per point                   points_of(matrix)
//   Eigen matrix, a column per point                points_of(matrix.transpose())
//   flat array x0 y0 z0 x1 y1 z1 ...                points_of_flat(array, 3)
//   types registered with Boost.Geometry            points_of of points/boost_geometry.hpp
//
// Fields have the same forms:
//
// ```cpp
//   recon::FieldView<double> velocity = recon::field_of(grains, &Grain::velocity);
//   recon::FieldView<double> heat = recon::field_of(temperature);          // a number per particle
//   recon::FieldView<double> momentum = recon::field_of_flat(momenta, 3);  // px py pz px py pz ...
//   recon::FieldView<double> v = recon::field_of(vx, vy, vz);              // an array for each
// ```
//
// A matrix-valued member (std::array<std::array<double, 3>, 3>, Eigen::Matrix3d) is a field of 9
// components in the order in which it lies in memory. field_of gives a FieldSpan, which can be
// written, where the data are not const.
//
// Temporaries that own their numbers are refused at compile time: a view of one would dangle.
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <ranges>
#include <span>
#include <type_traits>

#include "recon/points/view.hpp"

namespace recon {

namespace detail {

template <class T>
inline constexpr bool is_scalar =
    std::is_same_v<std::remove_const_t<T>, float> || std::is_same_v<std::remove_const_t<T>, double>;

// A range whose elements lie side by side in memory that outlives the call.
template <class R>
concept StableArray = std::ranges::contiguous_range<R> && std::ranges::sized_range<R> &&
    std::ranges::borrowed_range<R>;

template <class T>
concept EigenDense = requires {
  typename std::remove_cvref_t<T>::PlainObject;
}
&&std::is_base_of_v<Eigen::MatrixBase<std::remove_cvref_t<T>>, std::remove_cvref_t<T>>;

template <class T>
concept XYZ = requires(T& t) {
  t.x, t.y, t.z;
};
template <class T>
concept XY = requires(T& t) {
  t.x, t.y;
}
&&!XYZ<T>;

// The layout of one value: how many numbers it has, and where the first lies. They must
// lie side by side.
template <class T>
struct Layout;  // undefined for other types: see the table at the top of this file

template <class T>
requires is_scalar<T>
struct Layout<T> {
  using Scalar = T;
  static constexpr int count = 1;
  static auto* first(auto& value) { return &value; }
};
template <class T, std::size_t N>
struct Layout<std::array<T, N>> {
  using Scalar = typename Layout<T>::Scalar;
  static constexpr int count = static_cast<int>(N) * Layout<T>::count;
  static auto* first(auto& value) { return Layout<T>::first(value[0]); }
};
template <class T, std::size_t N>
struct Layout<T[N]> {
  using Scalar = typename Layout<T>::Scalar;
  static constexpr int count = static_cast<int>(N) * Layout<T>::count;
  static auto* first(auto& value) { return Layout<T>::first(value[0]); }
};
template <class T>
requires(EigenDense<T>&& T::SizeAtCompileTime > 0) struct Layout<T> {
  using Scalar = typename T::Scalar;
  static constexpr int count = T::SizeAtCompileTime;
  static auto* first(auto& value) { return value.data(); }
};
template <class T>
requires(XYZ<T> && !EigenDense<T>) struct Layout<T> {
  using Scalar = std::remove_cvref_t<decltype(std::declval<T&>().x)>;
  static_assert(sizeof(T) >= 3 * sizeof(Scalar));
  static constexpr int count = 3;
  static auto* first(auto& value) { return &value.x; }
};
template <class T>
requires(XY<T> && !EigenDense<T>) struct Layout<T> {
  using Scalar = std::remove_cvref_t<decltype(std::declval<T&>().x)>;
  static constexpr int count = 2;
  static auto* first(auto& value) { return &value.x; }
};

template <class T>
concept HasLayout = requires {
  Layout<std::remove_cv_t<T>>::count;
};

template <class T>
using LayoutScalar = typename Layout<std::remove_cv_t<T>>::Scalar;

// The distance in bytes between the numbers of one value. For { x, y, z } it is taken from the
// members, so that padding is respected; a struct whose members are not evenly spaced has no view.
template <class T>
std::ptrdiff_t component_stride(T& value) {
  using Plain = std::remove_cv_t<T>;
  const auto at = [](const auto& member) { return reinterpret_cast<const std::byte*>(&member); };
  if constexpr ((XYZ<Plain> || XY<Plain>)&&!EigenDense<Plain>) {
    const std::ptrdiff_t step = at(value.y) - at(value.x);
    if constexpr (XYZ<Plain>)
      require(at(value.z) - at(value.y) == step, "members x, y, z", "unevenly spread",
              "must lie at equal distances in memory");
    return step;
  } else {
    return sizeof(LayoutScalar<T>);
  }
}

// The base address of number `c` of the values, or null for an empty range.
template <class Scalar>
PointsView<Scalar> strided_points(std::size_t size, int dimension, const Scalar* first,
                                  std::ptrdiff_t axis_stride, std::ptrdiff_t point_stride) {
  std::array<const void*, max_dimension> base{};
  for (int d = 0; d < dimension && first; ++d)
    base[d] = reinterpret_cast<const std::byte*>(first) + d * axis_stride;
  return {size, dimension, base, {point_stride, point_stride, point_stride}};
}

}  // namespace detail

// ---- points --------------------------------------------------------------------------------

// A member of your own struct: points_of(grains, &Grain::position).
template <detail::StableArray Range, class Struct, class Member>
requires detail::HasLayout<Member>
auto points_of(Range&& elements, Member Struct::*member) {
  using Layout = detail::Layout<Member>;
  static_assert(Layout::count <= max_dimension, "points have 1, 2 or 3 coordinates");
  using Scalar = typename Layout::Scalar;
  if (std::ranges::empty(elements))
    return detail::strided_points<Scalar>(0, Layout::count, nullptr, 0, 0);
  auto& first = (*std::ranges::data(elements)).*member;
  return detail::strided_points<Scalar>(std::ranges::size(elements), Layout::count,
                                        Layout::first(first), detail::component_stride(first),
                                        sizeof(std::ranges::range_value_t<Range>));
}

// An array whose elements are the coordinates themselves (one number each: points in 1-D).
template <detail::StableArray Range>
requires(detail::HasLayout<std::ranges::range_value_t<Range>> &&
         !detail::EigenDense<Range>) auto points_of(Range&& elements) {
  using Value = std::ranges::range_value_t<Range>;
  using Layout = detail::Layout<Value>;
  static_assert(Layout::count <= max_dimension, "points have 1, 2 or 3 coordinates");
  using Scalar = typename Layout::Scalar;
  if (std::ranges::empty(elements))
    return detail::strided_points<Scalar>(0, Layout::count, nullptr, 0, 0);
  auto& first = *std::ranges::data(elements);
  return detail::strided_points<Scalar>(std::ranges::size(elements), Layout::count,
                                        Layout::first(first), detail::component_stride(first),
                                        sizeof(Value));
}

// One array per axis. Throws InvalidArgument where their lengths differ.
template <detail::StableArray X, detail::StableArray... Rest>
requires(detail::is_scalar<std::ranges::range_value_t<X>> && sizeof...(Rest) >= 1 &&
         sizeof...(Rest) <= 2 &&
         (std::same_as<std::ranges::range_value_t<X>, std::ranges::range_value_t<Rest>> &&
          ...)) auto points_of(X&& x, Rest&&... rest) {
  using Scalar = std::ranges::range_value_t<X>;
  const std::size_t size = std::ranges::size(x);
  (detail::require(std::ranges::size(rest) == size, "length of a coordinate array",
                   std::ranges::size(rest), "must equal the length of the first coordinate array"),
   ...);
  return PointsView<Scalar>(size, 1 + static_cast<int>(sizeof...(Rest)),
                            {std::ranges::data(x), std::ranges::data(rest)...},
                            {sizeof(Scalar), sizeof(Scalar), sizeof(Scalar)});
}

// An Eigen matrix (or map, block, transpose) with a row per point and a column per axis.
template <class Derived>
requires((Derived::Flags & Eigen::DirectAccessBit) !=
         0) auto points_of(const Eigen::MatrixBase<Derived>& matrix) {
  using Scalar = typename Derived::Scalar;
  const Derived& m = matrix.derived();
  detail::require(
      m.cols() >= 1 && m.cols() <= max_dimension, "columns of the coordinate matrix", m.cols(),
      "must be 1, 2 or 3 with a row per point (pass matrix.transpose() if points are columns)");
  return detail::strided_points<Scalar>(
      static_cast<std::size_t>(m.rows()), static_cast<int>(m.cols()), m.data(),
      m.colStride() * static_cast<std::ptrdiff_t>(sizeof(Scalar)),
      m.rowStride() * static_cast<std::ptrdiff_t>(sizeof(Scalar)));
}

template <class Derived>
void points_of(Eigen::PlainObjectBase<Derived>&& temporary) = delete;

// A flat array x0 y0 z0 x1 y1 z1 ... of points of the given dimension.
template <detail::StableArray Range>
requires detail::is_scalar<std::ranges::range_value_t<Range>>
auto points_of_flat(Range&& numbers, int dimension) {
  using Scalar = std::ranges::range_value_t<Range>;
  detail::require(dimension >= 1 && dimension <= max_dimension, "dimension", dimension,
                  "must be 1, 2 or 3");
  const std::size_t count = std::ranges::size(numbers);
  detail::require(count % static_cast<std::size_t>(dimension) == 0,
                  "length of the flat coordinate array", count,
                  "must be a multiple of the dimension");
  return detail::strided_points<Scalar>(count / static_cast<std::size_t>(dimension), dimension,
                                        std::ranges::data(numbers), sizeof(Scalar),
                                        dimension * static_cast<std::ptrdiff_t>(sizeof(Scalar)));
}

// ---- fields --------------------------------------------------------------------------------

namespace detail {

// A field that begins at `first`: const numbers give a FieldView, others a FieldSpan.
template <class Number>
BasicFieldView<Number> strided_field(std::size_t size, int components, Number* first,
                                     std::ptrdiff_t point_stride, std::ptrdiff_t component_stride) {
  return {size, components, first, point_stride, component_stride};
}

}  // namespace detail

// A member of your own struct: field_of(grains, &Grain::velocity).
template <detail::StableArray Range, class Struct, class Member>
requires detail::HasLayout<Member>
auto field_of(Range&& elements, Member Struct::*member) {
  using Layout = detail::Layout<Member>;
  using Number =
      std::remove_pointer_t<decltype(Layout::first((*std::ranges::data(elements)).*member))>;
  if (std::ranges::empty(elements))
    return detail::strided_field<Number>(0, Layout::count, nullptr, 0, 0);
  auto& first = (*std::ranges::data(elements)).*member;
  return detail::strided_field<Number>(
      std::ranges::size(elements), Layout::count, Layout::first(first),
      sizeof(std::ranges::range_value_t<Range>), detail::component_stride(first));
}

// An array whose elements are the values themselves.
template <detail::StableArray Range>
requires(detail::HasLayout<std::ranges::range_value_t<Range>> &&
         !detail::EigenDense<Range>) auto field_of(Range&& elements) {
  using Value = std::ranges::range_value_t<Range>;
  using Layout = detail::Layout<Value>;
  using Number = std::remove_pointer_t<decltype(Layout::first(*std::ranges::data(elements)))>;
  if (std::ranges::empty(elements))
    return detail::strided_field<Number>(0, Layout::count, nullptr, 0, 0);
  auto& first = *std::ranges::data(elements);
  return detail::strided_field<Number>(std::ranges::size(elements), Layout::count,
                                       Layout::first(first), sizeof(Value),
                                       detail::component_stride(first));
}

// A struct of arrays: one array of numbers for each component, as in field_of(vx, vy, vz). At most
// 9. Throws InvalidArgument where their lengths differ.
template <detail::StableArray First, detail::StableArray... Others>
requires(sizeof...(Others) >= 1 && detail::is_scalar<std::ranges::range_value_t<First>> &&
         (std::is_same_v<std::remove_reference_t<std::ranges::range_reference_t<First>>,
                         std::remove_reference_t<std::ranges::range_reference_t<Others>>> &&
          ...)) auto field_of(First&& first, Others&&... others) {
  using Number = std::remove_reference_t<std::ranges::range_reference_t<First>>;
  constexpr int components = 1 + sizeof...(Others);
  static_assert(components <= BasicFieldView<Number>::most_arrays,
                "a field of arrays has at most 9 components");
  const std::size_t count = std::ranges::size(first);
  int component = 0;
  const auto require_length = [&](std::size_t length) {
    if (length != count)
      detail::throw_invalid("length of array " + std::to_string(component), length,
                            "must be that of array 0, " + std::to_string(count));
    ++component;
  };
  require_length(count);
  (require_length(std::ranges::size(others)), ...);
  const std::array<Number*, components> arrays{std::ranges::data(first),
                                               std::ranges::data(others)...};
  return BasicFieldView<Number>(count, components, arrays, sizeof(Number));
}

// An Eigen matrix with a row per point and a column per component, read only.
template <class Derived>
requires((Derived::Flags & Eigen::DirectAccessBit) !=
         0) auto field_of(const Eigen::MatrixBase<Derived>& matrix) {
  using Scalar = typename Derived::Scalar;
  const Derived& m = matrix.derived();
  constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Scalar));
  return detail::strided_field<const Scalar>(static_cast<std::size_t>(m.rows()),
                                             static_cast<int>(m.cols()), m.data(),
                                             m.rowStride() * bytes, m.colStride() * bytes);
}

// The same for a matrix that may be written.
template <class Derived>
requires((Derived::Flags & Eigen::DirectAccessBit) != 0 &&
         (Derived::Flags & Eigen::LvalueBit) !=
             0) auto field_of(Eigen::MatrixBase<Derived>& matrix) {
  using Scalar = typename Derived::Scalar;
  Derived& m = matrix.derived();
  constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Scalar));
  return detail::strided_field<Scalar>(static_cast<std::size_t>(m.rows()),
                                       static_cast<int>(m.cols()), m.data(), m.rowStride() * bytes,
                                       m.colStride() * bytes);
}

template <class Derived>
void field_of(Eigen::PlainObjectBase<Derived>&& temporary) = delete;

// A flat array a0 b0 c0 a1 b1 c1 ... of values with the given number of components.
template <detail::StableArray Range>
requires detail::is_scalar<std::ranges::range_value_t<Range>>
auto field_of_flat(Range&& numbers, int components) {
  using Number = std::remove_reference_t<std::ranges::range_reference_t<Range>>;
  detail::require(components >= 1, "components", components, "must be at least 1");
  const std::size_t count = std::ranges::size(numbers);
  detail::require(count % static_cast<std::size_t>(components) == 0,
                  "length of the flat field array", count,
                  "must be a multiple of the number of components");
  constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Number));
  return detail::strided_field<Number>(count / static_cast<std::size_t>(components), components,
                                       std::ranges::data(numbers), components * bytes, bytes);
}

}  // namespace recon
