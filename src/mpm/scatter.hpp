// Sums from particles into rows of a grid, on several threads, always in the same order.
//
// The rows of the last axis are cut into slabs that are thicker than any particle reaches. A
// particle belongs to the slab of its first row, and touches that and the next: so all even slabs
// can go at once, and then all odd ones, each in the order of its particles.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "recon/core/parallel.hpp"

namespace recon::mpm {

// Calls add(p, scratch) for every particle p, where rows(p) gives the first and the last row that p
// touches. Scratch is default-constructed once per slab.
template <class Scratch, class Rows, class Add>
void scatter_by_slabs(std::size_t particles, int threads, const Rows& rows, const Add& add) {
  constexpr std::size_t block = 4096;
  constexpr int thinnest = 4;
  std::vector<std::int32_t> first(particles);
  std::atomic<int> span{thinnest}, last_row{0};
  parallel_blocks(particles, block, threads, [&](std::size_t begin, std::size_t end) {
    int most = 0, last = 0;
    for (std::size_t p = begin; p < end; ++p) {
      const auto [from, to] = rows(p);
      first[p] = from;
      most = std::max(most, to - from);
      last = std::max(last, to);
    }
    for (int seen = span; seen < most && !span.compare_exchange_weak(seen, most);) {
    }
    for (int seen = last_row; seen < last && !last_row.compare_exchange_weak(seen, last);) {
    }
  });
  const int thickness = span;
  const std::size_t slabs = static_cast<std::size_t>(last_row / thickness) + 1;

  std::vector<std::uint32_t> begin(slabs + 1), order(particles);
  for (std::size_t p = 0; p < particles; ++p) ++begin[first[p] / thickness + 1];
  for (std::size_t s = 0; s < slabs; ++s) begin[s + 1] += begin[s];
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t p = 0; p < particles; ++p)
    order[next[first[p] / thickness]++] = static_cast<std::uint32_t>(p);

  for (std::size_t colour = 0; colour < 2; ++colour)
    parallel_blocks((slabs + 1 - colour) / 2, 1, threads, [&](std::size_t from, std::size_t to) {
      Scratch scratch;
      for (std::size_t s = 2 * from + colour; s < 2 * to + colour && s < slabs; s += 2)
        for (std::uint32_t i = begin[s]; i < begin[s + 1]; ++i) add(order[i], scratch);
    });
}

}  // namespace recon::mpm
