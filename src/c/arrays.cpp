#include "c/handles.hpp"

namespace recon::c {
namespace {

using detail::throw_invalid;

void check(const recon_array& array, recon_number number, const char* name) {
  if (array.number != number)
    throw_invalid(std::string(name) + ".number", array.number == RECON_FLOAT ? "float" : "double",
                  "must be that of the object: all arrays of one object are double, or all float");
  if (array.components < 1)
    throw_invalid(std::string(name) + ".components", array.components, "must be at least 1");
  if (array.size == 0 || array.data) return;
  if (array.components > 9)
    throw_invalid(std::string(name) + ".components", array.components,
                  "must be at most 9 where each has its array");
  for (int c = 0; c < array.components; ++c)
    if (!array.arrays[c])
      throw_invalid(std::string(name) + ".arrays[" + std::to_string(c) + "]", "NULL",
                    "must be an array where data is NULL");
}

template <class Scalar>
BasicFieldView<Scalar> view_of(const recon_array& array) {
  if (array.data || array.size == 0)
    return {array.size, array.components, array.data, array.stride, array.component_stride};
  return {array.size, array.components, array.arrays, array.stride};
}

recon_array packed(const void* data, std::size_t size, int components, recon_number number,
                   std::size_t bytes) {
  recon_array array{};
  array.size = size;
  array.components = components;
  array.number = number;
  array.data = const_cast<void*>(data);
  array.component_stride = static_cast<std::ptrdiff_t>(bytes);
  array.stride = components * array.component_stride;
  return array;
}

recon_array separate(const void* x, const void* y, const void* z, std::size_t size,
                     recon_number number, std::size_t bytes) {
  recon_array array{};
  array.size = size;
  array.components = z ? 3 : y ? 2 : 1;
  array.number = number;
  array.stride = static_cast<std::ptrdiff_t>(bytes);
  array.arrays[0] = const_cast<void*>(x);
  array.arrays[1] = const_cast<void*>(y);
  array.arrays[2] = const_cast<void*>(z);
  return array;
}

}  // namespace

template <class Scalar>
PointsView<Scalar> points_of(const recon_array& array, const char* name) {
  check(array, number_of<Scalar>, name);
  if (array.components > max_dimension)
    throw_invalid(std::string(name) + ".components", array.components,
                  "must be 1, 2 or 3, the dimension of the points");
  std::array<const void*, max_dimension> base{};
  for (int d = 0; d < array.components && array.size > 0; ++d)
    base[d] = array.data ? static_cast<const std::byte*>(array.data) + d * array.component_stride
                         : array.arrays[d];
  return {array.size, array.components, base, {array.stride, array.stride, array.stride}};
}

template <class Scalar>
FieldView<Scalar> field_of(const recon_array& array, const char* name) {
  check(array, number_of<Scalar>, name);
  return view_of<const Scalar>(array);
}

template <class Scalar>
FieldSpan<Scalar> span_of(const recon_array& array, std::size_t size, int components,
                          const char* name) {
  check(array, number_of<Scalar>, name);
  if (array.size != size)
    throw_invalid(std::string(name) + ".size", array.size, "must be " + std::to_string(size));
  if (array.components != components)
    throw_invalid(std::string(name) + ".components", array.components,
                  "must be " + std::to_string(components));
  return view_of<Scalar>(array);
}

template PointsView<float> points_of(const recon_array&, const char*);
template PointsView<double> points_of(const recon_array&, const char*);
template FieldView<float> field_of(const recon_array&, const char*);
template FieldView<double> field_of(const recon_array&, const char*);
template FieldSpan<float> span_of(const recon_array&, std::size_t, int, const char*);
template FieldSpan<double> span_of(const recon_array&, std::size_t, int, const char*);

}  // namespace recon::c

recon_array recon_doubles(const double* data, size_t size, int components) {
  return recon::c::packed(data, size, components, RECON_DOUBLE, sizeof(double));
}
recon_array recon_floats(const float* data, size_t size, int components) {
  return recon::c::packed(data, size, components, RECON_FLOAT, sizeof(float));
}
recon_array recon_double_arrays(const double* x, const double* y, const double* z, size_t size) {
  return recon::c::separate(x, y, z, size, RECON_DOUBLE, sizeof(double));
}
recon_array recon_float_arrays(const float* x, const float* y, const float* z, size_t size) {
  return recon::c::separate(x, y, z, size, RECON_FLOAT, sizeof(float));
}
