#include "recon/core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>

#ifdef _OPENMP
#include <omp.h>
#if __has_include(<pthread.h>)
#include <pthread.h>
#endif
#endif

namespace recon {

#ifdef _OPENMP
namespace {

// In a child of fork() whose parent has had threads of OpenMP.
std::atomic<bool> threads_are_lost = false;

void watch_forks() {
#if __has_include(<pthread.h>)
  [[maybe_unused]] static const int watched =
      pthread_atfork(nullptr, nullptr, [] { threads_are_lost = true; });
#endif
}

// The threads of one loop. Those beyond the caller's own are counted over all loops that run at
// present, and a loop whose caller has named no number gets what the others have left.
class Team {
 public:
  Team(int asked, std::size_t blocks) {
    const auto within = [&](int threads) {
      return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads), blocks));
    };
    if (blocks <= 1 || threads_are_lost) return;
    if (asked > 0) {
      more_ = within(asked) - 1;
      in_use.fetch_add(more_, std::memory_order_relaxed);
    } else {
      const int most = default_threads() - 1, wanted = within(most + 1) - 1;
      if (wanted == 0) return;
      int now = in_use.load(std::memory_order_relaxed);
      do {
        more_ = std::clamp(most - now, 0, wanted);
      } while (!in_use.compare_exchange_weak(now, now + more_, std::memory_order_relaxed));
    }
    if (more_ > 0) watch_forks();
  }
  ~Team() { in_use.fetch_sub(more_, std::memory_order_relaxed); }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int threads() const { return more_ + 1; }

 private:
  static inline std::atomic<int> in_use = 0;
  int more_ = 0;
};

}  // namespace
#endif

int default_threads() {
#ifdef _OPENMP
  if (threads_are_lost || omp_in_parallel()) return 1;
  return std::max(1, omp_get_max_threads());
#else
  return 1;
#endif
}

namespace detail {

void parallel_blocks(std::size_t count, std::size_t block, int threads, void* context,
                     void (*body)(void*, std::size_t, std::size_t)) {
  block = std::max<std::size_t>(1, block);
  const std::size_t blocks = (count + block - 1) / block;

  std::exception_ptr error;
  std::size_t error_block = blocks;
  const auto run = [&](std::size_t b) {
    try {
      body(context, b * block, std::min(count, (b + 1) * block));
    } catch (...) {
#ifdef _OPENMP
#pragma omp critical(recon_parallel_error)
#endif
      if (b < error_block) {
        error_block = b;
        error = std::current_exception();
      }
    }
  };

#ifdef _OPENMP
  const Team team(threads, blocks);
  if (team.threads() > 1) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(team.threads())
    for (std::ptrdiff_t b = 0; b < static_cast<std::ptrdiff_t>(blocks); ++b)
      run(static_cast<std::size_t>(b));
  } else
#else
  static_cast<void>(threads);
#endif
    for (std::size_t b = 0; b < blocks; ++b) run(b);

  if (error) std::rethrow_exception(error);
}

}  // namespace detail
}  // namespace recon
