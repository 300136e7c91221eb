// The keys of what was gathered around a target, in the order that its rule asks for.
//
// A few are put in order by counting for each how many come before it (ranks of cell_kernel.hpp),
// without a branch that depends on the data; many by sorting.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "neighbourhood/cell_gather.hpp"

namespace recon::detail {

template <class S, int D, bool periodic>
class KeyOrder {
 public:
  using Gather = CellGather<S, D, periodic>;
  using Key = typename Gather::Key;

  KeyOrder(const SearchKernels<S, D>& kernels, CellBuffers<S, D, Key>& buffers)
      : kernels_(kernels),
        rank_distance_(buffers.rank_distance),
        rank_index_(buffers.rank_index),
        pairs_(buffers.pairs),
        ordered_(buffers.ordered) {}

  const Key* begin() const { return ordered_.data(); }
  const Key* end() const { return begin() + size_; }
  std::size_t size() const { return size_; }

  // All of them by ascending key.
  void by_index(Gather& gathered) {
    const std::size_t count = gathered.count();
    start(count, count);
    if (count <= kernels_.most_ranked) {
      rank_index_.resize(std::max(rank_index_.size(), count + 64));
      kernels_.rank_indices(gathered.index(), static_cast<std::int64_t>(count), rank_index_.data());
      place(gathered, rank_index_.data());
    } else {
      for (std::size_t i = 0; i < count; ++i) ordered_[i] = gathered.key(i);
      std::sort(ordered_.begin(), ordered_.begin() + static_cast<std::ptrdiff_t>(count));
    }
  }

  // The `size` nearest, at most as many as there are; returns the largest of their squared
  // distances.
  S by_distance(Gather& gathered, std::size_t size) {
    const std::size_t count = gathered.count();
    start(count, std::min(size, count));
    S* const distance2 = gathered.distance2();
    if (count <= kernels_.most_ranked) {
      rank_distance_.resize(std::max(rank_distance_.size(), count + 64));
      const S* const rank = rank_distance_.data();
      kernels_.rank_distances(distance2, static_cast<std::int64_t>(count), rank_distance_.data());
      place(gathered, rank);
      S farthest2 = 0;
      const S end = static_cast<S>(size_);
      for (std::size_t i = 0; i < count; ++i)
        farthest2 = std::max(farthest2, rank[i] < end ? distance2[i] : S(0));
      return farthest2;
    }
    pairs_.resize(count);
    for (std::size_t i = 0; i < count; ++i) pairs_[i] = {distance2[i], gathered.key(i)};
    const auto end = pairs_.begin() + static_cast<std::ptrdiff_t>(size_);
    if (size_ < count) std::nth_element(pairs_.begin(), end, pairs_.end());
    std::sort(pairs_.begin(), end);
    for (std::size_t i = 0; i < size_; ++i) ordered_[i] = pairs_[i].second;
    return size_ > 0 ? pairs_[size_ - 1].first : S(0);
  }

  // Entries with `index` and `shift` that are in order.
  template <class Entries>
  void take(const Entries& entries) {
    start(entries.size(), entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
      ordered_[i] = Gather::Coding::of(entries[i].index, entries[i].shift);
  }

 private:
  void start(std::size_t count, std::size_t size) {
    size_ = size;
    if (ordered_.size() < count + 1) ordered_.resize(2 * count + 64);
  }

  // Puts the key of everything gathered at its rank; those of equal rank follow each other.
  template <class T>
  void place(const Gather& gathered, const T* rank) {
    const std::size_t count = gathered.count();
    std::size_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto at = static_cast<std::uint32_t>(rank[i]);
      ordered_[at] = gathered.key(i);
      sum += at;
    }
    if (sum == count * (count - 1) / 2 || count == 0) return;  // no two are equal
    constexpr Key none = std::numeric_limits<Key>::max();
    std::fill_n(ordered_.begin(), count + 1, none);
    for (std::size_t i = 0; i < count; ++i) {
      auto at = static_cast<std::uint32_t>(rank[i]);
      Key moved = gathered.key(i);
      while (ordered_[at] < moved) ++at;
      for (; moved != none; ++at) std::swap(moved, ordered_[at]);
    }
  }

  const SearchKernels<S, D>& kernels_;
  std::vector<S>& rank_distance_;
  std::vector<std::uint32_t>& rank_index_;
  std::vector<std::pair<S, Key>>& pairs_;
  std::vector<Key>& ordered_;
  std::size_t size_ = 0;
};

}  // namespace recon::detail
