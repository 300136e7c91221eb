#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/core/names.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

TEST(Error, NamesArgumentValueAndRule) {
  detail::require(true, "a", 1, "unused");
  try {
    detail::require(false, "radius", -0.1, "must be positive");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_STREQ(error.what(), "radius = -0.10000000000000001: must be positive");
    EXPECT_EQ(error.argument(), "radius");
    EXPECT_EQ(error.rule(), "must be positive");
  }
}

TEST(Names, DistanceCountsSlips) {
  EXPECT_EQ(edit_distance("cubic", "cubic"), 0u);
  EXPECT_EQ(edit_distance("Cubic", "cubic"), 0u);
  EXPECT_EQ(edit_distance("cubik", "cubic"), 1u);
  EXPECT_EQ(edit_distance("cbuic", "cubic"), 1u);  // swapped
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST(Names, SuggestsTheNearestOrListsAll) {
  const std::vector<std::string> fields{"vx", "vy", "vz", "density", "radius"};
  EXPECT_EQ(suggest("desnity", fields), "did you mean 'density'?");
  EXPECT_EQ(suggest("v", fields), "did you mean 'vx', 'vy' or 'vz'?");
  EXPECT_EQ(suggest("temperature", fields), "valid: vx, vy, vz, density, radius");
  EXPECT_EQ(suggest("x", {}), "");
}

TEST(Parallel, CoversEveryItemOnce) {
  for (const int threads : {0, 1, 2, 5})
    for (const std::size_t count : {0u, 1u, 9u, 10u, 1000u}) {
      std::vector<std::atomic<int>> seen(count);
      parallel_blocks(count, 10, threads, [&](std::size_t begin, std::size_t end) {
        EXPECT_EQ(begin % 10, 0u);
        EXPECT_LE(end - begin, 10u);
        for (std::size_t i = begin; i < end; ++i) ++seen[i];
      });
      for (const auto& s : seen) EXPECT_EQ(s, 1);
    }
  EXPECT_GE(default_threads(), 1);
}

TEST(Parallel, RethrowsTheFirstError) {
  for (const int threads : {1, 2, 4}) {
    try {
      parallel_blocks(100, 1, threads, [](std::size_t begin, std::size_t) {
        if (begin >= 40) throw std::runtime_error(std::to_string(begin));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "40");
    }
  }
}

}  // namespace
}  // namespace recon
