#include "recon/core/progress.hpp"

#include <atomic>
#include <chrono>
#include <mutex>

#include "recon/core/parallel.hpp"

namespace recon::detail {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds between_calls{100};

// Tells a Progress about one loop.
class Reporter {
 public:
  Reporter(const Progress& progress, std::size_t count) : progress_(progress), count_(count) {}

  bool ended() const { return ended_.load(std::memory_order_relaxed); }

  // Throws Cancelled where the caller says no.
  void add(std::size_t done) {
    done_.fetch_add(done, std::memory_order_relaxed);
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || ended() || Clock::now() < next_) return;
    try {
      const auto so_far = static_cast<double>(done_.load(std::memory_order_relaxed));
      if (!progress_(so_far / static_cast<double>(count_))) throw Cancelled();
    } catch (...) {
      ended_.store(true, std::memory_order_relaxed);
      throw;
    }
    next_ = Clock::now() + between_calls;
  }

 private:
  const Progress& progress_;
  const std::size_t count_;
  std::atomic<std::size_t> done_ = 0;
  std::atomic<bool> ended_ = false;
  std::mutex mutex_;
  Clock::time_point next_ = Clock::now() + between_calls;
};

}  // namespace

Progress part_of(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [whole, from, to](double fraction) { return whole(from + fraction * (to - from)); };
}

void parallel_blocks(std::size_t count, std::size_t block, int threads, const Progress& progress,
                     void* context, void (*body)(void*, std::size_t, std::size_t)) {
  if (!progress) return parallel_blocks(count, block, threads, context, body);
  Reporter reporter(progress, count);
  recon::parallel_blocks(count, block, threads, [&](std::size_t begin, std::size_t end) {
    if (reporter.ended()) return;
    body(context, begin, end);
    reporter.add(end - begin);
  });
}

}  // namespace recon::detail
