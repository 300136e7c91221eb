// Parallel loops in programs that have threads of their own, or fork.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

#include "recon/core/parallel.hpp"

namespace recon {
namespace {

// Blocks that run at one time, at most.
class Crowd {
 public:
  void enter() {
    const int now = ++inside_;
    int most = most_;
    while (now > most && !most_.compare_exchange_weak(most, now)) {
    }
  }
  void leave() { --inside_; }
  int most() const { return most_; }

 private:
  std::atomic<int> inside_ = 0, most_ = 0;
};

// Loops that ask for no number share the threads there are; one that asks for a number has it.
TEST(HostThreads, ShareTheThreadsThereAre) {
  constexpr int hosts = 6;
  for (const int asked : {0, 2}) {
    Crowd crowd;
    std::vector<std::vector<int>> seen(hosts, std::vector<int>(200));
    std::vector<std::thread> threads;
    for (auto& mine : seen)
      threads.emplace_back([&crowd, &mine, asked] {
        parallel_blocks(mine.size(), 1, asked, [&](std::size_t begin, std::size_t) {
          crowd.enter();
          std::this_thread::sleep_for(std::chrono::microseconds(200));
          ++mine[begin];
          crowd.leave();
        });
      });
    for (std::thread& thread : threads) thread.join();
    EXPECT_LE(crowd.most(), asked > 0 ? asked * hosts : default_threads() - 1 + hosts);
    for (const auto& mine : seen) EXPECT_EQ(mine, std::vector<int>(mine.size(), 1));
  }
  // When they are through, all threads are there again.
  Crowd crowd;
  parallel_blocks(100, 1, 0, [&](std::size_t, std::size_t) {
    crowd.enter();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    crowd.leave();
  });
  EXPECT_EQ(crowd.most(), std::min(default_threads(), 100));
}

// A loop within a loop, of one thread or several.
TEST(HostThreads, LoopsWithinLoopsFinish) {
  std::vector<std::atomic<int>> seen(400);
  parallel_blocks(20, 1, 0, [&](std::size_t i, std::size_t) {
    parallel_blocks(20, 1, 0, [&](std::size_t j, std::size_t) { ++seen[20 * i + j]; });
  });
  for (const auto& count : seen) EXPECT_EQ(count, 1);
}

TEST(HostThreads, AChildOfForkWorksOnOneThread) {
  const auto sum = [](int threads) {
    std::vector<int> value(1000);
    parallel_blocks(value.size(), 1, threads,
                    [&](std::size_t i, std::size_t) { value[i] = static_cast<int>(i); });
    return std::accumulate(value.begin(), value.end(), 0);
  };
  const int expected = sum(2);  // there are threads from now on, where there is OpenMP
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(30);  // ends a child that waits for threads that it has not
    const bool right = sum(2) == expected && sum(0) == expected && default_threads() == 1;
    _exit(right ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(sum(2), expected);
}

}  // namespace
}  // namespace recon
