// The keys of the neighbours of one target, in the order that is asked for.
//
// A few are put in order by counting for each how many come before it (ranks of cell_kernel.hpp),
// without a branch that depends on the data; many by sorting.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "neighbourhood/neighbour_key.hpp"
#include "neighbourhood/shared_by_targets.hpp"

namespace recon::detail {

template <class S, int D, bool periodic>
class KeyOrder {
 public:
  using Coding = NeighbourKey<periodic>;
  using Key = typename Coding::Key;

  KeyOrder(const SearchKernels<S, D>& kernels, CellBuffers<S, D, Key>& buffers)
      : kernels_(kernels), buffers_(buffers) {}

  const Key* begin() const { return buffers_.keys.data(); }
  const Key* end() const { return begin() + size_; }
  std::size_t size() const { return size_; }

  // The keys key_of(i) for i from 0 to count - 1.
  template <class KeyOf>
  void take(std::int64_t count, const KeyOf& key_of) {
    size_ = static_cast<std::size_t>(count);
    if (buffers_.keys.size() < size_ + 1) buffers_.keys.resize(2 * size_ + 64);
    for (std::size_t i = 0; i < size_; ++i) buffers_.keys[i] = key_of(i);
  }

  // By ascending key. No two are equal.
  void by_index() {
    Key* const keys = buffers_.keys.data();
    if (std::is_sorted(keys, keys + size_)) return;
    if (!few()) return std::sort(keys, keys + size_);
    buffers_.index.resize(std::max(buffers_.index.size(), size_ + 64));
    buffers_.rank_index.resize(std::max(buffers_.rank_index.size(), size_ + 64));
    for (std::size_t i = 0; i < size_; ++i) buffers_.index[i] = Coding::index(keys[i]);
    kernels_.rank_indices(buffers_.index.data(), static_cast<std::int64_t>(size_),
                          buffers_.rank_index.data());
    place(buffers_.rank_index.data());
  }

  // Puts key i at rank[i], where rank[i] of the measures are smaller than measure[i]. False, and no
  // order, where two measures differ by `slack` or less.
  bool by_rank(const float* rank, const float* measure, float slack) {
    auto &keys = buffers_.keys, &ordered = buffers_.ordered;
    auto& sorted = buffers_.sorted;
    ordered.resize(keys.size());
    sorted.resize(std::max(sorted.size(), size_ + 1));
    std::size_t sum = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const auto at = static_cast<std::uint32_t>(rank[i]);
      ordered[at] = keys[i];
      sorted[at] = measure[i];
      sum += at;
    }
    bool apart = sum == size_ * (size_ - 1) / 2;
    for (std::size_t i = 1; i < size_; ++i) apart &= sorted[i] - sorted[i - 1] > slack;
    if (apart) std::swap(keys, ordered);
    return apart;
  }

  // By ascending (distance2(i), key), of which the first `size` are kept, at most as many as there
  // are. Returns the largest of their squared distances.
  template <class Distance2>
  S by_distance(std::size_t size, const Distance2& distance2) {
    const std::size_t all = size_, kept = std::min(size, all);
    S farthest2 = 0;
    if (few()) {
      auto& squares = buffers_.distance2;
      squares.resize(std::max(squares.size(), all + 64));
      buffers_.rank_distance.resize(std::max(buffers_.rank_distance.size(), all + 64));
      const S* const rank = buffers_.rank_distance.data();
      for (std::size_t i = 0; i < all; ++i) squares[i] = distance2(i);
      kernels_.rank_distances(squares.data(), static_cast<std::int64_t>(all),
                              buffers_.rank_distance.data());
      place(rank);
      const S end = static_cast<S>(kept);
      for (std::size_t i = 0; i < all; ++i)
        farthest2 = std::max(farthest2, rank[i] < end ? squares[i] : S(0));
    } else {
      auto& pairs = buffers_.pairs;
      pairs.resize(all);
      for (std::size_t i = 0; i < all; ++i) pairs[i] = {distance2(i), buffers_.keys[i]};
      const auto end = pairs.begin() + static_cast<std::ptrdiff_t>(kept);
      if (kept < all) std::nth_element(pairs.begin(), end, pairs.end());
      std::sort(pairs.begin(), end);
      for (std::size_t i = 0; i < kept; ++i) buffers_.keys[i] = pairs[i].second;
      if (kept > 0) farthest2 = pairs[kept - 1].first;
    }
    size_ = kept;
    return farthest2;
  }

 private:
  bool few() const { return static_cast<std::int64_t>(size_) <= kernels_.most_ranked; }

  // Puts every key at its rank; those of equal rank follow each other.
  template <class T>
  void place(const T* rank) {
    auto &keys = buffers_.keys, &ordered = buffers_.ordered;
    ordered.resize(keys.size());
    std::size_t sum = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const auto at = static_cast<std::uint32_t>(rank[i]);
      ordered[at] = keys[i];
      sum += at;
    }
    if (size_ > 0 && sum != size_ * (size_ - 1) / 2) {  // some are equal
      constexpr Key none = std::numeric_limits<Key>::max();
      std::fill_n(ordered.begin(), size_ + 1, none);
      for (std::size_t i = 0; i < size_; ++i) {
        auto at = static_cast<std::uint32_t>(rank[i]);
        Key moved = keys[i];
        while (ordered[at] < moved) ++at;
        for (; moved != none; ++at) std::swap(moved, ordered[at]);
      }
    }
    std::swap(keys, ordered);
  }

  const SearchKernels<S, D>& kernels_;
  CellBuffers<S, D, Key>& buffers_;
  std::size_t size_ = 0;
};

}  // namespace recon::detail
