// A k-d tree for targets that cells serve badly. It is built when they have cost as much without it
// as building it does; work is counted as in cell_kernel.hpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

#include "recon/neighbourhood/kd_tree.hpp"

namespace recon::detail {

template <class S, int D>
class TreeForHardTargets {
 public:
  TreeForHardTargets(const PointCloud<S>& particles, bool allowed, std::size_t k)
      : particles_(particles),
        allowed_(allowed),
        hard_work_(8000 + 100 * static_cast<std::int64_t>(k)),
        price_(work_per_particle * static_cast<std::int64_t>(particles.size())) {}

  // The work for one target that costs about as much as a query of the tree.
  std::int64_t hard_work() const { return hard_work_; }
  bool worthwhile() const { return allowed_ && paid_.load(std::memory_order_relaxed) >= price_; }
  void add(std::int64_t work) {
    if (work > hard_work_) paid_.fetch_add(work, std::memory_order_relaxed);
  }
  const KdTree<S, D>& get() {
    std::call_once(once_, [this] { tree_ = std::make_unique<KdTree<S, D>>(particles_); });
    return *tree_;
  }

 private:
  static constexpr std::int64_t work_per_particle = 400;

  const PointCloud<S>& particles_;
  const bool allowed_;
  const std::int64_t hard_work_, price_;
  std::atomic<std::int64_t> paid_ = 0;
  std::once_flag once_;
  std::unique_ptr<KdTree<S, D>> tree_;
};

}  // namespace recon::detail
