// Views of coordinates and fields in the memory of a GPU, streams, and errors of the GPU itself.
//
// A view is an address and strides, counted in numbers, not in bytes. Coordinate d of point i is
//     data[i * point_stride + d * axis_stride] ,
// so that arrays of structs (x y z x y z ..., the default) and structs of arrays (point_stride 1,
// axis_stride the distance from the x of a point to its y) are both read where they lie. Component
// c of the value at point i of a field is data[i * point_stride + c * component_stride]. Memory
// that the GPU can read through is enough: that of cudaMalloc, or managed memory.
//
// Nothing here needs the headers of CUDA or nvcc: a particle code that is compiled by any C++20
// compiler can call recon::cuda.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "recon/core/error.hpp"
#include "recon/points/view.hpp"

struct CUstream_st;

namespace recon::cuda {

// A stream of CUDA: the same type as cudaStream_t. Null: the default stream.
using Stream = ::CUstream_st*;

// Thrown where a call of CUDA fails (no memory, no GPU, a kernel that was stopped): "what the call
// was for: what CUDA says of it". Wrong input throws InvalidArgument, as everywhere in recon.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <int D, class T>
struct Points {
  static_assert(D >= 1 && D <= max_dimension);
  const T* data = nullptr;
  std::size_t count = 0;
  std::ptrdiff_t point_stride = D, axis_stride = 1;

  // Throws InvalidArgument for no data, too many points and strides that are 0.
  void validate(const char* name) const {
    detail::require(count == 0 || data != nullptr, name, "null", "must have an address");
    detail::require(count < 0x7FFFFFFFu, name, count, "must be fewer than 2^31 - 1 points");
    detail::require(point_stride != 0 && (D == 1 || axis_stride != 0), name, 0,
                    "must have strides that are not 0");
  }
};

// T is const where the field is read.
template <class T>
struct Field {
  T* data = nullptr;
  std::size_t count = 0;
  int components = 1;
  std::ptrdiff_t point_stride = components, component_stride = 1;

  // Throws InvalidArgument for no data, another number of points, and components below 1.
  void validate(const char* name, std::size_t points) const {
    detail::require(count == points, name, count,
                    ("must have a value for each of " + std::to_string(points)).c_str());
    detail::require(count == 0 || data != nullptr, name, "null", "must have an address");
    detail::require(components >= 1, "components of the field", components, "must be at least 1");
    detail::require(point_stride != 0 && (components == 1 || component_stride != 0), name, 0,
                    "must have strides that are not 0");
  }
};

}  // namespace recon::cuda
