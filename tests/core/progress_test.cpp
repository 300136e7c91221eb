// A Progress is told at most ten times per second, by one thread at a time, and can end the loop.
#include "recon/core/progress.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace recon {
namespace {

using Clock = std::chrono::steady_clock;

void work(std::chrono::milliseconds time = std::chrono::milliseconds(10)) {
  std::this_thread::sleep_for(time);
}

TEST(ProgressOfALoop, IsToldInOrderAndNotTooOften) {
  std::vector<double> fractions;
  std::vector<Clock::time_point> times{Clock::now()};
  std::atomic<int> inside = 0;
  const Progress progress = [&](double fraction) {
    EXPECT_EQ(++inside, 1);
    fractions.push_back(fraction);
    times.push_back(Clock::now());
    work();
    --inside;
    return true;
  };
  std::vector<int> seen(60);
  parallel_blocks(seen.size(), 1, 2, progress, [&](std::size_t i, std::size_t) {
    work();
    ++seen[i];
  });
  EXPECT_EQ(seen, std::vector<int>(60, 1));
  const std::size_t calls = fractions.size();
  ASSERT_GE(calls, 2u);
  for (std::size_t i = 0; i < calls; ++i) {
    EXPECT_GT(fractions[i], i == 0 ? 0 : fractions[i - 1]);
    EXPECT_LE(fractions[i], 1);
    EXPECT_GE(times[i + 1] - times[i], std::chrono::milliseconds(100));
  }
  work(std::chrono::milliseconds(150));
  EXPECT_EQ(fractions.size(), calls);  // nobody calls it afterwards
}

TEST(ProgressOfALoop, EndsIt) {
  for (const int threads : {1, 2}) {
    std::atomic<int> blocks = 0, calls = 0;
    const auto loop = [&](const Progress& progress) {
      parallel_blocks(1000, 1, threads, progress, [&](std::size_t, std::size_t) {
        ++blocks;
        work();
      });
    };
    EXPECT_THROW(loop([&](double) { return ++calls < 1; }), Cancelled);
    EXPECT_EQ(calls, 1);
    EXPECT_LT(blocks, 500);
    blocks = 0;
    EXPECT_THROW(loop([](double) -> bool { throw std::domain_error("its own"); }),
                 std::domain_error);
    EXPECT_LT(blocks, 500);
  }
}

// The error of a block is what the caller hears of.
TEST(ProgressOfALoop, DoesNotHideErrors) {
  const auto loop = [&] {
    parallel_blocks(
        100, 1, 1, [](double) { return false; },
        [&](std::size_t i, std::size_t) {
          work();
          if (i == 2) throw std::domain_error("of the third block");
        });
  };
  EXPECT_THROW(loop(), std::domain_error);
}

TEST(ProgressOfALoop, OfAPart) {
  double told = -1;
  const Progress whole = [&](double fraction) {
    told = fraction;
    return fraction < 0.6;
  };
  const Progress part = detail::part_of(whole, 0.5, 0.75);
  EXPECT_TRUE(part(0));
  EXPECT_EQ(told, 0.5);
  EXPECT_FALSE(part(1));
  EXPECT_EQ(told, 0.75);
  EXPECT_FALSE(detail::part_of({}, 0, 1));
}

}  // namespace
}  // namespace recon
