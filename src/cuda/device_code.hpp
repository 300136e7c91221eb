// What functions need that run on a GPU as well as on the processor.
//
// All algorithms of this room are templates over an executor, Host (host.hpp) or Device
// (device.cuh): memory, a loop over functors, a stable sort and a scan. The functors are the same
// for both, so that whatever is not the launch of a kernel is tested on the processor.
#pragma once

#include <cmath>
#include <cstdint>

#ifdef __CUDACC__
#define RECON_DEVICE __host__ __device__
#else
#define RECON_DEVICE
#endif

namespace recon::cuda {

inline constexpr std::uint32_t none = 0xFFFFFFFFu;

// Sums and products that are never fused, so that squared distances have the bits of
// squared_distance() on the processor.
RECON_DEVICE inline double plain_product(double a, double b) {
#ifdef __CUDA_ARCH__
  return __dmul_rn(a, b);
#else
  return a * b;
#endif
}
RECON_DEVICE inline float plain_product(float a, float b) {
#ifdef __CUDA_ARCH__
  return __fmul_rn(a, b);
#else
  return a * b;
#endif
}
RECON_DEVICE inline double plain_sum(double a, double b) {
#ifdef __CUDA_ARCH__
  return __dadd_rn(a, b);
#else
  return a + b;
#endif
}
RECON_DEVICE inline float plain_sum(float a, float b) {
#ifdef __CUDA_ARCH__
  return __fadd_rn(a, b);
#else
  return a + b;
#endif
}

template <int D, class T>
RECON_DEVICE inline T squared_distance_of(const T* a, const T* b) {
  T sum = 0;
  for (int d = 0; d < D; ++d) sum = plain_sum(sum, plain_product(a[d] - b[d], a[d] - b[d]));
  return sum;
}

// *at = min(*at, value), whichever thread comes first.
RECON_DEVICE inline void keep_least(std::uint32_t* at, std::uint32_t value) {
#ifdef __CUDA_ARCH__
  atomicMin(at, value);
#else
  if (value < *at) *at = value;
#endif
}

template <class T>
RECON_DEVICE inline T least_of(T a, T b) {
  return b < a ? b : a;
}
template <class T>
RECON_DEVICE inline T most_of(T a, T b) {
  return a < b ? b : a;
}

}  // namespace recon::cuda
