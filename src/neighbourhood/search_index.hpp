// The searches over one cloud: each is built when it is first asked for, and kept.
//
// Safe to ask from several threads. A grid of cells or a tree stays alive for as long as somebody
// holds it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "core/pool.hpp"
#include "neighbourhood/cells.hpp"
#include "recon/neighbourhood/brute_force.hpp"
#include "recon/neighbourhood/cell_grid.hpp"
#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/neighbourhood/r_tree.hpp"

namespace recon::detail {

// How the targets of a search are given, and what rows are to be like.
struct RowsAsked {
  bool in_order = false;  // targets follow each other in space as they are (sort_by_bricks)
  // Rows by ascending (index, shift), whatever the rule says, where the search by cells finds them.
  bool by_index = false;
  // Where the search by cells finds rows of one known length, of targets that are in order: `start`
  // is called when the list has its size, then `finished` for each block of rows that it has, in
  // parallel. Both or neither.
  std::function<void()> start{};
  std::function<void(std::size_t begin, std::size_t end)> finished{};
};

// The candidates of a Brick (brick.hpp) that belong to one periodic image: those from the end of the
// one before on.
template <class S>
struct CollectedImage {
  ImageShift shift{};
  std::array<Coarse<S>, max_dimension> centre{};  // what their coordinates are relative to
  std::int64_t end = 0;
};

// A target of a group that is treated at once.
template <class S, int D>
struct GroupTarget {
  std::array<S, D> x;
  std::uint32_t number;
};

// The memory of a Brick, a KeyOrder (key_order.hpp) with its keys, and a group of targets.
template <class S, int D, class Key>
struct CellBuffers {
  std::vector<CollectedImage<S>> images;
  std::array<std::vector<float>, D> x;
  std::vector<float> measure, rank, chosen_measure, rest_measure, sorted;
  std::vector<std::uint32_t> place, candidate, chosen, rest;
  std::vector<Key> keys, ordered;
  std::vector<S> distance2, rank_distance;
  std::vector<std::uint32_t> index, rank_index, far;
  std::vector<std::pair<S, Key>> pairs;
  std::vector<GroupTarget<S, D>> group;
};

// The rows that a block of targets has found, one after another.
template <class Key>
struct FoundRows {
  std::vector<Key> keys;
  std::vector<std::uint32_t> targets;  // whose row each is
};

// The memory of searches by cells, kept from one to the next.
template <class S, int D, class Key>
struct CellSearchMemory {
  Pool<CellBuffers<S, D, Key>> buffers;      // of a block of targets
  Pool<std::vector<FoundRows<Key>>> blocks;  // what all blocks have found
};

template <class S, int D>
class SearchIndex {
 public:
  using Grid = CellGrid<S, D>;
  static constexpr double particles_per_cell = 3;

  // The cloud must live as long as the index.
  explicit SearchIndex(const PointCloud<S>& cloud) : cloud_(cloud) {}

  const PointCloud<S>& cloud() const { return cloud_; }

  // Puts in place of all searches the cells that the cloud has been ordered by: particle p is the
  // one at place p of them.
  void start_anew(std::shared_ptr<const Grid> ordered) {
    const std::lock_guard lock(mutex_);
    grid_ = std::move(ordered);
    kd_tree_.reset();
    r_tree_.reset();
    brute_force_.reset();
    has_tree_ = false;
    paid_ = 0;
  }

  // Cells of density_cell_size(), with all that collect() reads.
  std::shared_ptr<const Grid> cells(int threads) {
    const std::lock_guard lock(mutex_);
    if (!grid_)
      grid_ =
          std::make_shared<Grid>(cloud_, density_cell_size(cloud_, particles_per_cell), threads);
    grid_->sorted_cells().bring_coarse(threads);
    return grid_;
  }

  std::shared_ptr<const KdTree<S, D>> kd_tree() {
    auto tree = kept(kd_tree_);
    has_tree_ = true;
    return tree;
  }
  std::shared_ptr<const RTree<S, D>> r_tree() { return kept(r_tree_); }
  std::shared_ptr<const BruteForce<S, D>> brute_force() { return kept(brute_force_); }

  // Keys have 32 bits, and 64 in periodic domains.
  template <class Key>
  CellSearchMemory<S, D, Key>& memory() {
    return std::get<CellSearchMemory<S, D, Key>>(memory_);
  }
  // Gives the memory of searches back.
  void forget_buffers() {
    std::apply([](auto&... memory) { ((memory.buffers.clear(), memory.blocks.clear()), ...); },
               memory_);
  }

  // Targets that cells serve badly are left to the k-d tree, once they have cost as much without it
  // as building it does. Work is counted as in cell_kernel.hpp.
  void add_hard_work(std::int64_t work) { paid_.fetch_add(work, std::memory_order_relaxed); }
  bool tree_is_worthwhile() const {
    return has_tree_ || paid_.load(std::memory_order_relaxed) >=
                            work_per_particle * static_cast<std::int64_t>(cloud_.size());
  }

 private:
  static constexpr std::int64_t work_per_particle = 400;

  template <class Search>
  std::shared_ptr<const Search> kept(std::shared_ptr<const Search>& search) {
    const std::lock_guard lock(mutex_);
    if (!search) search = std::make_shared<Search>(cloud_);
    return search;
  }

  const PointCloud<S>& cloud_;
  std::tuple<CellSearchMemory<S, D, std::uint32_t>, CellSearchMemory<S, D, std::uint64_t>> memory_;
  std::mutex mutex_;
  std::shared_ptr<const Grid> grid_;
  std::shared_ptr<const KdTree<S, D>> kd_tree_;
  std::shared_ptr<const RTree<S, D>> r_tree_;
  std::shared_ptr<const BruteForce<S, D>> brute_force_;
  std::atomic<bool> has_tree_ = false;
  std::atomic<std::int64_t> paid_ = 0;
};

}  // namespace recon::detail
