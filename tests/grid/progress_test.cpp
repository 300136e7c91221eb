// Options::progress of a reconstruction on a grid that goes by lists, part by part: one account of
// the whole.
#include "recon/core/progress.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/points/generate.hpp"

namespace recon::testing {
namespace {

struct SlowGrid {
  std::vector<std::array<double, 2>> points = random_points<double, 2>(2000, 1);
  std::vector<double> field = std::vector<double>(2000, 1);
  std::vector<double> told;
  double until = 2;  // where the answer becomes no

  // 10,000 nodes, in three parts, of 0.1 ms and more for each node.
  GridReconstruction run() {
    StructuredGrid<double> grid;
    grid.dimension = 2;
    grid.counts = {100, 100, 1};
    grid.spacing = {0.01, 0.01, 1};
    Options options{.degree = 1, .neighbours = Radius{0.08}};
    options.visible = [](std::size_t node, std::size_t) {
      static thread_local std::size_t last = 0;
      if (node != last) std::this_thread::sleep_for(std::chrono::microseconds(100));
      last = node;
      return true;
    };
    options.progress = [this](double fraction) {
      told.push_back(fraction);
      return fraction < until;
    };
    return reconstruct_on_grid(points_of(points), {field_of(field)}, grid, options);
  }
};

TEST(ProgressOnAGrid, IsOneAccountOfAllParts) {
  SlowGrid slow;
  const auto result = slow.run();
  ASSERT_GE(slow.told.size(), 4u);
  EXPECT_TRUE(std::is_sorted(slow.told.begin(), slow.told.end()));
  EXPECT_LT(slow.told.front(), 0.4);
  EXPECT_GT(slow.told.back(), 0.6);
  EXPECT_LE(slow.told.back(), 1);
  EXPECT_EQ(result.values().rows(), 10000);
}

TEST(ProgressOnAGrid, CancelsInALaterPart) {
  SlowGrid slow;
  slow.until = 0.5;
  EXPECT_THROW(slow.run(), Cancelled);
  EXPECT_GE(slow.told.back(), 0.5);
  EXPECT_LT(slow.told.back(), 1);
}

}  // namespace
}  // namespace recon::testing
