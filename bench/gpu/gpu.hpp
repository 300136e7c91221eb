// What the cases of recon-gpu share: numbers in the memory of the GPU, times, what the GPU could do.
#pragma once

#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "recon/cuda/view.hpp"

namespace recon_gpu {

inline void require(cudaError_t error, const char* what) {
  if (error != cudaSuccess)
    throw recon::cuda::Error(std::string(what) + ": " + cudaGetErrorString(error));
}

// Numbers in the memory of the GPU.
template <class U>
class OnGpu {
 public:
  explicit OnGpu(std::size_t count) : count_(count) {
    require(cudaMalloc(reinterpret_cast<void**>(&numbers_), (count + 1) * sizeof(U)), "memory");
  }
  explicit OnGpu(const std::vector<U>& from) : OnGpu(from.size()) {
    require(cudaMemcpy(numbers_, from.data(), count_ * sizeof(U), cudaMemcpyHostToDevice), "copy");
  }
  OnGpu(const OnGpu&) = delete;
  OnGpu& operator=(const OnGpu&) = delete;
  ~OnGpu() { (void)cudaFree(numbers_); }
  U* data() { return numbers_; }

 private:
  U* numbers_ = nullptr;
  std::size_t count_;
};

template <class U>
std::vector<U> fetch(const U* from, std::size_t count) {
  std::vector<U> numbers(count);
  require(cudaMemcpy(numbers.data(), from, count * sizeof(U), cudaMemcpyDeviceToHost), "copy");
  return numbers;
}

// The shortest time of a few runs, in seconds, between two events of the stream.
template <class Run>
double time_of(const Run& run) {
  cudaEvent_t begin, end;
  require(cudaEventCreate(&begin), "event");
  require(cudaEventCreate(&end), "event");
  float best = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 7; ++i) {
    require(cudaEventRecord(begin), "event");
    run();
    require(cudaEventRecord(end), "event");
    require(cudaEventSynchronize(end), "work");
    float took = 0;
    require(cudaEventElapsedTime(&took, begin, end), "event");
    if (i > 0) best = std::min(best, took);
  }
  (void)cudaEventDestroy(begin);
  (void)cudaEventDestroy(end);
  return 1e-3 * static_cast<double>(best);
}

// A GPU, and what it can do at most in a second, as its driver says; 0: not known.
struct Machine {
  std::string name;
  double bytes = 0;
  double flops[2] = {0, 0};  // in float and in double

  template <class T>
  double peak() const {
    return flops[sizeof(T) == 8];
  }
};

inline int attribute(cudaDeviceAttr which) {
  int value = 0;
  require(cudaDeviceGetAttribute(&value, which, 0), "attribute");
  return value;
}

inline Machine this_machine() {
  cudaDeviceProp properties;
  require(cudaGetDeviceProperties(&properties, 0), "properties");
  // Units of a multiprocessor for float and double (CUDA C++ Programming Guide, arithmetic
  // instructions), each of which multiplies and adds once a cycle.
  struct Units {
    int major, minor, of_float, of_double;
  };
  constexpr Units known[] = {{7, 0, 64, 32}, {7, 5, 64, 2},   {8, 0, 64, 32},   {8, 6, 128, 2},
                             {8, 9, 128, 2}, {9, 0, 128, 64}, {10, 0, 128, 64}, {12, 0, 128, 2}};
  Machine machine{properties.name, 2e3 * attribute(cudaDevAttrMemoryClockRate) *
                                       (attribute(cudaDevAttrGlobalMemoryBusWidth) / 8.0)};
  for (const Units& each : known) {
    if (each.major != properties.major || each.minor != properties.minor) continue;
    const double cycles = 1e3 * attribute(cudaDevAttrClockRate) * properties.multiProcessorCount;
    machine.flops[0] = 2 * each.of_float * cycles;
    machine.flops[1] = 2 * each.of_double * cycles;
  }
  return machine;
}

// "12 %" of what is possible.
inline std::string percent(double done, double possible) {
  return possible > 0 ? std::to_string(static_cast<int>(100 * done / possible + 0.5)) + " %" : "-";
}

}  // namespace recon_gpu
