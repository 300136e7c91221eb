// The batch search by cells over all targets: in which order they are treated, in blocks that run
// in parallel, and how their neighbours get into one list.
#pragma once

#include <vector>

#include "core/counting_sort.hpp"
#include "neighbourhood/cell_targets.hpp"

namespace recon::detail {

// How many cells along each axis the targets of a group may extend over.
template <int D>
inline constexpr int cells_of_a_brick = D == 1   ? 16
                                        : D == 2 ? 4
                                                 : 2;

// The order of bricks of cells, in which targets are treated: those that follow each other see the
// same particles, and make groups. Into `sort`.
template <class S, int D>
void sort_by_bricks(const Cells<S, D>& cells, const PointCloud<S>& targets, int threads,
                    CountingSort& sort) {
  int edge = cells_of_a_brick<D>;
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
          row_of_cells(bricks.data(), at[1] >> shift, at[2] >> shift) + (at[0] >> shift));
    }
  });
  sort.sort(count(), threads);
}

template <class S, int D, bool periodic>
class AllTargets {
 public:
  AllTargets(SharedByTargets<S, D>& shared, const RowsAsked& rows, NeighbourList<S>& list)
      : shared_(shared), rows_(rows), memory_(shared.index.template memory<Key>()), list_(list) {
    if (rows.in_order) return;
    sort_by_bricks(shared.grid->sorted_cells(), shared.targets, shared.options.threads, sort_);
    order_ = sort_.order();
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
  using Target = typename Targets::Target;
  static constexpr std::size_t targets_per_block = 512;

  std::size_t count() const { return shared_.targets.size(); }
  std::size_t target(std::size_t place) const { return order_.empty() ? place : order_[place]; }

  // The neighbours of all targets, into rows of known length, or else into the blocks.
  void find_all(std::vector<FoundRows<Key>>* blocks) {
    recon::parallel_blocks(
        count(), targets_per_block, shared_.options.threads, shared_.options.progress,
        [&](std::size_t begin, std::size_t end) {
          const auto buffers = memory_.buffers.lend();
          FoundRows<Key>* const block = blocks ? &(*blocks)[begin / targets_per_block] : nullptr;
          Targets targets(shared_, *buffers);
          const auto take = [&](std::size_t t, S rho) {
            list_.support[t] = rho;
            if (!block) return write(targets.begin(), row_length_, t * row_length_);
            list_.offsets[t + 1] = static_cast<std::int64_t>(targets.size());
            block->keys.insert(block->keys.end(), targets.begin(), targets.end());
            block->targets.push_back(static_cast<std::uint32_t>(t));
          };
          const typename Targets::Found found = std::ref(take);  // without memory of its own
          for (std::size_t s = begin; s < end;) {
            s = next_group(s, end, buffers->group);
            targets.find(std::span(buffers->group), found);
          }
          if (!block && rows_.finished && order_.empty()) rows_.finished(begin, end);
        });
  }

  // Targets from place `begin` on that are close to each other and have radii of one magnitude.
  // Returns the place behind them.
  std::size_t next_group(std::size_t begin, std::size_t end, std::vector<Target>& group) const {
    const double extent = cells_of_a_brick<D> * shared_.grid->sorted_cells().size();
    std::array<S, D> lower{}, upper{};
    S smallest = 0, largest = 0;
    group.clear();
    for (std::size_t s = begin; s < end; ++s) {
      const auto number = static_cast<std::uint32_t>(target(s));
      const Target next{shared_.targets.template point<D>(number), number};
      const S radius = shared_.question.radius_of(number);
      if (s == begin) {
        lower = upper = next.x;
        smallest = largest = radius;
      }
      bool near = true;
      for (int d = 0; d < D; ++d) {
        lower[d] = std::min(lower[d], next.x[d]);
        upper[d] = std::max(upper[d], next.x[d]);
        near = near && static_cast<double>(upper[d]) - static_cast<double>(lower[d]) <= extent;
      }
      smallest = std::min(smallest, radius);
      largest = std::max(largest, radius);
      if (!near || largest > 2 * smallest) return s;
      group.push_back(next);
      fetch(s);
    }
    return end;
  }

  // What will be read of targets to come, and written for the target at a place: in the caller's
  // order both may be anywhere.
  void fetch(std::size_t s) const {
    constexpr std::size_t ahead = 16;
    if (order_.empty()) return;
    if (s + ahead < count())
      __builtin_prefetch(shared_.targets.data() + std::size_t{order_[s + ahead]} * D);
    const std::size_t t = order_[s];
    __builtin_prefetch(&list_.support[t], 1);
    __builtin_prefetch(&list_.offsets[t + 1], 1);
    constexpr std::size_t line = 64 / sizeof(ParticleIndex), most = 8 * line;
    for (std::size_t i = 0; i < std::min(row_length_, most); i += line)
      __builtin_prefetch(list_.indices.data() + t * row_length_ + i, 1);
  }

  void find_rows_of_known_length() {
    const std::size_t particles = shared_.particles.size();
    const std::size_t k = periodic ? shared_.question.k : std::min(shared_.question.k, particles);
    for (std::size_t t = 0; t < count(); ++t)
      list_.offsets[t + 1] = static_cast<std::int64_t>((t + 1) * k);
    resize(count() * k);
    row_length_ = k;
    list_.support_factor = static_cast<S>(shared_.question.factor);
    if (rows_.start && order_.empty()) rows_.start();
    find_all(nullptr);
  }

  void find_rows_of_any_length() {
    const auto blocks = memory_.blocks.lend();
    blocks->resize(std::max(blocks->size(), (count() + targets_per_block - 1) / targets_per_block));
    for (FoundRows<Key>& block : *blocks) {
      block.keys.clear();
      block.targets.clear();
    }
    find_all(&*blocks);
    for (std::size_t t = 0; t < count(); ++t) list_.offsets[t + 1] += list_.offsets[t];
    resize(static_cast<std::size_t>(list_.offsets.back()));
    recon::parallel_blocks(blocks->size(), 1, shared_.options.threads,
                           [&](std::size_t block, std::size_t) {
                             const Key* from = (*blocks)[block].keys.data();
                             for (const std::uint32_t t : (*blocks)[block].targets) {
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
  const RowsAsked& rows_;
  CellSearchMemory<S, D, Key>& memory_;
  CountingSort sort_;
  std::span<const std::uint32_t> order_;  // empty: as they are
  std::size_t row_length_ = 0;            // 0: not known
  NeighbourList<S>& list_;
};

}  // namespace recon::detail
