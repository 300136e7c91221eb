// recon called from many threads of the program at once, with objects of each thread's own and with
// shared ones, gives the same bits as alone.
#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "operators/same_work.hpp"

namespace recon::testing {
namespace {

TEST(HostThreads, SameBitsFromManyAtOnce) {
  const auto work = std::make_unique<SameWork>();
  const std::vector<double> expected = SameWork().results();
  ASSERT_FALSE(expected.empty());
  std::vector<std::vector<double>> found(6);
  std::vector<std::thread> threads;
  for (auto& mine : found) threads.emplace_back([&mine, &work] { mine = work->results(); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& mine : found) EXPECT_TRUE(same_bits(mine, expected));
}

}  // namespace
}  // namespace recon::testing
