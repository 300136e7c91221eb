// The executor on the processor: one thread and plain loops. It is for tests, and the model of what
// an executor has.
//
//   Array<U>                      memory, uninitialised, that only grows
//   provide(array, n)             makes sure that it holds n; what it held is lost where it grows
//   for_each(n, f)                f(i) for 0 <= i < n, in any order, each once
//   sort(keys, values, n, bits)   both by ascending key, of which only the lowest `bits` are set;
//                                 values of equal keys keep their order
//   scan(in, out, n)              out[i] = in[0] + ... + in[i - 1]
//   to_device(from, to, n)        from the processor's memory
//   to_host(from, to, n)          into the processor's memory; waits for all that was asked before
// All but to_host() may return before the work is done; work is done in the order it was asked for.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace recon::cuda {

class Host {
 public:
  // Neighbours for which the threads have memory of their own, in one of two kinds of kernels (here
  // in one); how many workers there are at least for the others, and how much memory for all.
  static constexpr int small_room = 24, large_room = 24;
  static constexpr std::size_t fewest_workers = 3, bytes_of_workers = 1 << 16;

  template <class U>
  class Array {
   public:
    U* data() { return numbers_.get(); }
    const U* data() const { return numbers_.get(); }
    std::size_t capacity() const { return capacity_; }

   private:
    friend Host;
    std::unique_ptr<U[]> numbers_;
    std::size_t capacity_ = 0;
  };

  template <class U>
  void provide(Array<U>& array, std::size_t n) {
    if (array.capacity_ >= n) return;
    bytes_ += (n - array.capacity_) * sizeof(U);
    array.numbers_.reset(new U[n]);
    array.capacity_ = n;
    ++allocations_;
  }

  template <class F>
  void for_each(std::size_t n, const F& f) {
    for (std::size_t i = 0; i < n; ++i) f(i);
  }

  void sort(Array<std::uint32_t>& keys, Array<std::uint32_t>& values, std::size_t n, int) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs(n);
    for (std::size_t i = 0; i < n; ++i) pairs[i] = {keys.data()[i], values.data()[i]};
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < n; ++i) {
      keys.data()[i] = pairs[i].first;
      values.data()[i] = pairs[i].second;
    }
  }

  template <class U>
  void scan(const U* in, U* out, std::size_t n) {
    U sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const U next = in[i];
      out[i] = sum;
      sum += next;
    }
  }

  template <class U>
  void to_device(const U* from, U* to, std::size_t n) {
    std::copy_n(from, n, to);
  }
  template <class U>
  void to_host(const U* from, U* to, std::size_t n) {
    std::copy_n(from, n, to);
  }

  // How often memory was asked for, and how much there was at most if none was given back: for tests.
  int allocations() const { return allocations_; }
  std::size_t bytes() const { return bytes_; }

 private:
  int allocations_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace recon::cuda
