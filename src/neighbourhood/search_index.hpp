// The searches over one cloud: each is built when it is first asked for, and kept.
//
// Safe to ask from several threads. A grid of cells or a tree stays alive for as long as somebody
// holds it.
#pragma once

#include <atomic>
#include <cstdint>
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
#include "recon/neighbourhood/periodic_images.hpp"
#include "recon/neighbourhood/r_tree.hpp"

namespace recon::detail {

// The memory of a CellGather (cell_gather.hpp) and a KeyOrder (key_order.hpp), with its keys.
template <class S, int D, class Key>
struct CellBuffers {
  PeriodicImages<S, D> images;
  std::vector<S> distance2, rank_distance;
  std::vector<std::uint32_t> index, shift, rank_index;  // shift: as codes
  std::vector<std::pair<S, Key>> pairs;
  std::vector<Key> ordered;
};

// The memory of searches by cells, kept from one to the next.
template <class S, int D, class Key>
struct CellSearchMemory {
  Pool<CellBuffers<S, D, Key>> buffers;        // of a block of targets
  Pool<std::vector<std::vector<Key>>> blocks;  // the keys that all blocks have found
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
    wide_grid_.reset();
    kd_tree_.reset();
    r_tree_.reset();
    brute_force_.reset();
    has_tree_ = false;
    paid_ = 0;
  }

  // Cells of density_cell_size(), or of `size` where that is larger by half or more.
  std::shared_ptr<const Grid> cells(double size, int threads) {
    const std::lock_guard lock(mutex_);
    if (!grid_)
      grid_ =
          std::make_shared<Grid>(cloud_, density_cell_size(cloud_, particles_per_cell), threads);
    if (size <= much_larger * grid_->cell_size()) return grid_;
    if (!wide_grid_ || size > much_larger * wide_size_ || wide_size_ > much_larger * size) {
      wide_grid_ = std::make_shared<Grid>(cloud_, size, threads);
      wide_size_ = size;
    }
    return wide_grid_;
  }

  std::shared_ptr<const KdTree<S, D>> kd_tree() {
    const auto tree = kept(kd_tree_);
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
  static constexpr double much_larger = 1.5;
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
  std::shared_ptr<const Grid> grid_, wide_grid_;
  double wide_size_ = 0;
  std::shared_ptr<const KdTree<S, D>> kd_tree_;
  std::shared_ptr<const RTree<S, D>> r_tree_;
  std::shared_ptr<const BruteForce<S, D>> brute_force_;
  std::atomic<bool> has_tree_ = false;
  std::atomic<std::int64_t> paid_ = 0;
};

}  // namespace recon::detail
