// The one counting sort: numbers 0, 1, ... in the order of small keys, in parallel.
//
// Two passes: first into buckets of consecutive keys that fit the cache, then each bucket by
// itself. So no pass writes to more than about a thousand places at a time, however many numbers
// there are. Blocks depend on the number of keys and numbers alone: the result does not depend on
// the number of threads. Cost O(numbers + keys). The memory is kept from one sort to the next.
#pragma once

#include <cstdint>
#include <span>

#include "recon/core/array.hpp"

namespace recon::detail {

class CountingSort {
 public:
  // The keys of the numbers 0 .. count - 1, to be written before sort(). At most 2^32 - 1 numbers.
  std::span<std::uint32_t> keys(std::size_t count) {
    key_.resize(count);
    return key_;
  }

  // Every key must be smaller than key_count, which must be smaller than 2^32.
  void sort(std::size_t key_count, int threads);

  // Gives back the memory of the sorting itself: 8 bytes for each number, 12 after several sorts.
  void forget_scratch() {
    key_ = Array<std::uint32_t>();  // = {} would keep the memory
    rough_ = Array<Pair>();
    next_ = Array<std::uint32_t>();
  }

  // The numbers by ascending key, those of equal key ascending.
  std::span<const std::uint32_t> order() const { return order_; }
  // The place in order() of the first number whose key is k or larger, for k from 0 to key_count.
  std::span<const std::uint32_t> first() const { return first_; }

 private:
  struct Pair {
    std::uint32_t key, number;
  };

  Array<std::uint32_t> key_, order_, first_;
  Array<std::uint32_t> next_, bucket_begin_;
  Array<Pair> rough_;
};

}  // namespace recon::detail
