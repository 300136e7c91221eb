// The executor on a GPU (host.hpp says what an executor has): kernels on one stream, sorting and
// scans by CUB. Memory is taken and given back in the order of the stream, so that nobody waits.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <string>
#include <utility>

#include "recon/cuda/view.hpp"

namespace recon::cuda {

inline void require_success(cudaError_t error, const char* what) {
  if (error != cudaSuccess)
    throw Error(std::string(what) + ": " + cudaGetErrorString(error));
}

template <class F>
__global__ void __launch_bounds__(128) run_for_each(std::size_t n, F f) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) f(i);
}

class Device {
 public:
  static constexpr int small_room = 32, large_room = 96;
  static constexpr std::size_t fewest_workers = 512, bytes_of_workers = std::size_t{1} << 27;

  explicit Device(Stream stream) : stream_(stream) {}
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  template <class U>
  class Array {
   public:
    Array() = default;
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;
    Array(Array&& other) noexcept { swap(other); }
    Array& operator=(Array&& other) noexcept {
      swap(other);
      return *this;
    }
    ~Array() { give_back(); }

    U* data() { return numbers_; }
    const U* data() const { return numbers_; }
    std::size_t capacity() const { return capacity_; }

    void swap(Array& other) noexcept {
      std::swap(numbers_, other.numbers_);
      std::swap(capacity_, other.capacity_);
      std::swap(stream_, other.stream_);
    }

   private:
    friend Device;
    void give_back() {
      if (numbers_ != nullptr) (void)cudaFreeAsync(numbers_, stream_);
      numbers_ = nullptr;
      capacity_ = 0;
    }

    U* numbers_ = nullptr;
    std::size_t capacity_ = 0;
    cudaStream_t stream_ = nullptr;
  };

  template <class U>
  void provide(Array<U>& array, std::size_t n) {
    if (array.capacity_ >= n) return;
    array.give_back();
    void* memory = nullptr;
    require_success(cudaMallocAsync(&memory, n * sizeof(U), stream_), "memory on the GPU");
    array.numbers_ = static_cast<U*>(memory);
    array.capacity_ = n;
    array.stream_ = stream_;
  }

  template <class F>
  void for_each(std::size_t n, const F& f) {
    if (n == 0) return;
    constexpr std::size_t block = 128;
    run_for_each<<<static_cast<unsigned>((n + block - 1) / block), block, 0, stream_>>>(n, f);
    require_success(cudaGetLastError(), "start of a kernel");
  }

  void sort(Array<std::uint32_t>& keys, Array<std::uint32_t>& values, std::size_t n, int bits) {
    if (n == 0) return;
    provide(other_keys_, n);
    provide(other_values_, n);
    cub::DoubleBuffer<std::uint32_t> key(keys.data(), other_keys_.data()),
        value(values.data(), other_values_.data());
    std::size_t bytes = 0;
    require_success(cub::DeviceRadixSort::SortPairs(nullptr, bytes, key, value, n, 0, bits, stream_),
                    "sort");
    provide(workspace_, bytes);
    require_success(cub::DeviceRadixSort::SortPairs(workspace_.data(), bytes, key, value, n, 0, bits,
                                                    stream_),
                    "sort");
    copy_back(key.Current(), keys.data(), n);
    copy_back(value.Current(), values.data(), n);
  }

  template <class U>
  void scan(const U* in, U* out, std::size_t n) {
    if (n == 0) return;
    std::size_t bytes = 0;
    require_success(cub::DeviceScan::ExclusiveSum(nullptr, bytes, in, out, n, stream_), "scan");
    provide(workspace_, bytes);
    require_success(cub::DeviceScan::ExclusiveSum(workspace_.data(), bytes, in, out, n, stream_),
                    "scan");
  }

  template <class U>
  void to_device(const U* from, U* to, std::size_t n) {
    require_success(cudaMemcpyAsync(to, from, n * sizeof(U), cudaMemcpyHostToDevice, stream_),
                    "copy to the GPU");
  }
  template <class U>
  void to_host(const U* from, U* to, std::size_t n) {
    require_success(cudaMemcpyAsync(to, from, n * sizeof(U), cudaMemcpyDeviceToHost, stream_),
                    "copy from the GPU");
    wait();
  }
  void wait() { require_success(cudaStreamSynchronize(stream_), "work on the GPU"); }

 private:
  // Of two buffers the sort chooses where its result stands: an address that is promised must not
  // change with the number of passes.
  void copy_back(const std::uint32_t* from, std::uint32_t* to, std::size_t n) {
    if (from != to)
      require_success(cudaMemcpyAsync(to, from, n * sizeof(std::uint32_t), cudaMemcpyDeviceToDevice,
                                      stream_),
                      "copy on the GPU");
  }

  cudaStream_t stream_;
  Array<std::uint32_t> other_keys_, other_values_;
  Array<unsigned char> workspace_;
};

}  // namespace recon::cuda
