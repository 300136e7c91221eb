// The batch search by cells over all targets: in which order they are treated, in blocks that run
// in parallel, and how their neighbours get into one list.
#pragma once

#include <utility>
#include <vector>

#include "neighbourhood/cell_sort.hpp"
#include "neighbourhood/cell_targets.hpp"

namespace recon::detail {

// Targets in the order of bricks of cells, in which they are treated.
template <class S, int D>
SortedPoints<S, D> by_bricks(const Cells<S, D>& cells, const PointCloud<S>& targets, int threads) {
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
  return sort_by_key<D>(
      targets, count(),
      [&](const std::array<S, D>& x) {
        const CellIndex at = cells.cell_index(x);
        return ((at[2] >> shift) * bricks[1] + (at[1] >> shift)) * bricks[0] + (at[0] >> shift);
      },
      threads, nullptr);
}

template <class S, int D, bool periodic>
class AllTargets {
 public:
  explicit AllTargets(SharedByTargets<S, D>& shared) : shared_(shared) {
    const Cells<S, D>& cells = shared.grid.sorted_cells();
    const bool same = &shared.targets == &shared.particles;  // sorted already
    if (!same) own_ = by_bricks(cells, shared.targets, shared.options.threads);
    order_ = same ? &cells.sorted() : &own_;
  }

  NeighbourList<S> find() {
    list_.offsets.resize(count() + 1);
    list_.support.resize(count());
    if (shared_.question.factor > 0)
      find_rows_of_known_length();  // Nearest
    else
      find_rows_of_any_length();
    return std::move(list_);
  }

 private:
  using Targets = CellTargets<S, D, periodic>;
  using Key = typename Targets::Key;
  static constexpr std::size_t targets_per_block = 512;

  std::size_t count() const { return shared_.targets.size(); }

  template <class Block>
  void for_blocks(const Block& block) const {
    recon::parallel_blocks(count(), targets_per_block, shared_.options.threads, block);
  }

  void find_rows_of_known_length() {
    const std::size_t particles = shared_.particles.size();
    const std::size_t k = periodic ? shared_.question.k : std::min(shared_.question.k, particles);
    for (std::size_t t = 0; t < count(); ++t)
      list_.offsets[t + 1] = static_cast<std::int64_t>((t + 1) * k);
    resize(count() * k);
    for_blocks([&](std::size_t begin, std::size_t end) {
      Targets found(shared_);
      for (std::size_t s = begin; s < end; ++s) {
        const std::size_t t = order_->index[s];
        list_.support[t] = found.find(t, order_->point(s));
        write(found.begin(), k, t * k);
      }
    });
  }

  void find_rows_of_any_length() {
    std::vector<std::vector<Key>> blocks((count() + targets_per_block - 1) / targets_per_block);
    for_blocks([&](std::size_t begin, std::size_t end) {
      Targets found(shared_);
      std::vector<Key>& block = blocks[begin / targets_per_block];
      for (std::size_t s = begin; s < end; ++s) {
        const std::size_t t = order_->index[s];
        list_.support[t] = found.find(t, order_->point(s));
        list_.offsets[t + 1] = static_cast<std::int64_t>(found.size());
        block.insert(block.end(), found.begin(), found.end());
      }
    });
    for (std::size_t t = 0; t < count(); ++t) list_.offsets[t + 1] += list_.offsets[t];
    resize(static_cast<std::size_t>(list_.offsets.back()));
    for_blocks([&](std::size_t begin, std::size_t end) {
      const std::vector<Key> block = std::move(blocks[begin / targets_per_block]);
      const Key* from = block.data();
      for (std::size_t s = begin; s < end; ++s) {
        const std::size_t t = order_->index[s];
        const auto size = static_cast<std::size_t>(list_.count(t));
        write(from, size, static_cast<std::size_t>(list_.offsets[t]));
        from += size;
      }
    });
  }

  void resize(std::size_t entries) {
    list_.indices.resize(entries);
    if (periodic) list_.shifts.resize(entries);
  }
  void write(const Key* keys, std::size_t size, std::size_t at) {
    using Coding = typename Targets::Coding;
    for (std::size_t i = 0; i < size; ++i) list_.indices[at + i] = Coding::index(keys[i]);
    if constexpr (periodic)
      for (std::size_t i = 0; i < size; ++i) list_.shifts[at + i] = Coding::shift(keys[i]);
  }

  SharedByTargets<S, D>& shared_;
  SortedPoints<S, D> own_;
  const SortedPoints<S, D>* order_;
  NeighbourList<S> list_;
};

}  // namespace recon::detail
