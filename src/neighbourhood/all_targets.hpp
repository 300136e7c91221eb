// The batch search by cells over all targets: in which order they are treated, in blocks that run
// in parallel, and how their neighbours get into one list.
#pragma once

#include <utility>
#include <vector>

#include "core/counting_sort.hpp"
#include "neighbourhood/cell_targets.hpp"

namespace recon::detail {

// The order of bricks of cells, in which targets are treated: those that follow each other look at
// the same few kilobytes of particles. Into `sort`.
template <class S, int D>
void sort_by_bricks(const Cells<S, D>& cells, const PointCloud<S>& targets, int threads,
                    CountingSort& sort) {
  int edge = D == 1 ? 64 : D == 2 ? 8 : 4;
  CellIndex bricks{};
  const auto count = [&] {
    std::size_t all = 1;
    for (int d = 0; d < max_dimension; ++d) {
      bricks[d] = (cells.count(d) + edge - 1) / edge;
      all *= static_cast<std::size_t>(bricks[d]);
    }
    return all;
  };
  while (count() > 4 * targets.size() + 1024) edge *= 2;
  int shift = 0;
  while (1 << shift < edge) ++shift;
  const std::span<std::uint32_t> key = sort.keys(targets.size());
  recon::parallel_blocks(key.size(), 16384, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const CellIndex at = cells.cell_index(targets.template point<D>(t));
      key[t] = static_cast<std::uint32_t>(
          ((at[2] >> shift) * bricks[1] + (at[1] >> shift)) * bricks[0] + (at[0] >> shift));
    }
  });
  sort.sort(count(), threads);
}

template <class S, int D, bool periodic>
class AllTargets {
 public:
  // With `in_order` targets follow each other in space as they are.
  AllTargets(SharedByTargets<S, D>& shared, bool in_order, NeighbourList<S>& list)
      : shared_(shared), memory_(shared.index.template memory<Key>()), list_(list) {
    const Cells<S, D>& cells = shared.grid->sorted_cells();
    if (in_order) return;
    if (&shared.targets == &shared.particles) {  // sorted already
      order_ = {cells.view().index, cells.particles()};
    } else {
      sort_by_bricks(cells, shared.targets, shared.options.threads, sort_);
      order_ = sort_.order();
    }
  }

  void find() {
    list_.offsets.resize(count() + 1);
    list_.offsets[0] = 0;
    list_.support.resize(count());
    if (shared_.question.factor > 0)
      find_rows_of_known_length();  // Nearest
    else
      find_rows_of_any_length();
  }

 private:
  using Targets = CellTargets<S, D, periodic>;
  using Key = typename Targets::Key;
  static constexpr std::size_t targets_per_block = 512;

  std::size_t count() const { return shared_.targets.size(); }
  std::size_t target(std::size_t place) const { return order_.empty() ? place : order_[place]; }

  template <class Block>
  void for_blocks(const Progress& progress, const Block& block) const {
    recon::parallel_blocks(count(), targets_per_block, shared_.options.threads, progress, block);
  }

  void find_rows_of_known_length() {
    const std::size_t particles = shared_.particles.size();
    const std::size_t k = periodic ? shared_.question.k : std::min(shared_.question.k, particles);
    for (std::size_t t = 0; t < count(); ++t)
      list_.offsets[t + 1] = static_cast<std::int64_t>((t + 1) * k);
    resize(count() * k);
    for_blocks(shared_.options.progress, [&](std::size_t begin, std::size_t end) {
      const auto buffers = memory_.buffers.lend();
      Targets found(shared_, *buffers);
      for (std::size_t s = begin; s < end; ++s) {
        const std::size_t t = target(s);
        list_.support[t] = found.find(t, shared_.targets.template point<D>(t));
        write(found.begin(), k, t * k);
      }
    });
  }

  void find_rows_of_any_length() {
    const auto blocks = memory_.blocks.lend();
    blocks->resize(std::max(blocks->size(), (count() + targets_per_block - 1) / targets_per_block));
    for_blocks(shared_.options.progress, [&](std::size_t begin, std::size_t end) {
      const auto buffers = memory_.buffers.lend();
      Targets found(shared_, *buffers);
      std::vector<Key>& block = (*blocks)[begin / targets_per_block];
      block.clear();
      for (std::size_t s = begin; s < end; ++s) {
        const std::size_t t = target(s);
        list_.support[t] = found.find(t, shared_.targets.template point<D>(t));
        list_.offsets[t + 1] = static_cast<std::int64_t>(found.size());
        block.insert(block.end(), found.begin(), found.end());
      }
    });
    for (std::size_t t = 0; t < count(); ++t) list_.offsets[t + 1] += list_.offsets[t];
    resize(static_cast<std::size_t>(list_.offsets.back()));
    for_blocks({}, [&](std::size_t begin, std::size_t end) {
      const Key* from = (*blocks)[begin / targets_per_block].data();
      for (std::size_t s = begin; s < end; ++s) {
        const std::size_t t = target(s);
        const auto size = static_cast<std::size_t>(list_.count(t));
        write(from, size, static_cast<std::size_t>(list_.offsets[t]));
        from += size;
      }
    });
  }

  void resize(std::size_t entries) {
    list_.indices.resize(entries);
    list_.shifts.resize(periodic ? entries : 0);
  }
  void write(const Key* keys, std::size_t size, std::size_t at) {
    using Coding = typename Targets::Coding;
    for (std::size_t i = 0; i < size; ++i) list_.indices[at + i] = Coding::index(keys[i]);
    if constexpr (periodic)
      for (std::size_t i = 0; i < size; ++i) list_.shifts[at + i] = Coding::shift(keys[i]);
  }

  SharedByTargets<S, D>& shared_;
  CellSearchMemory<S, D, Key>& memory_;
  CountingSort sort_;
  std::span<const std::uint32_t> order_;  // empty: as they are
  NeighbourList<S>& list_;
};

}  // namespace recon::detail
