// recon called inside a parallel region of OpenMP, from all its threads, also where nested regions
// are allowed: the same bits, and each call stays on its thread.
#include <gtest/gtest.h>

#include "operators/same_work.hpp"
#include "recon/core/parallel.hpp"

#ifdef _OPENMP
#include <omp.h>

namespace recon::testing {
namespace {

TEST(OpenMpRegion, SameBitsOnEveryThread) {
  const SameWork work;
  const std::vector<double> expected = SameWork().results();
  const int allowed = omp_get_max_active_levels();
  for (const int levels : {1, 2}) {
    omp_set_max_active_levels(levels);
    std::vector<std::vector<double>> found(4);
    std::vector<int> threads(4);
#pragma omp parallel for num_threads(4) schedule(static, 1)
    for (int i = 0; i < 4; ++i) {
      found[static_cast<std::size_t>(i)] = work.results();
      threads[static_cast<std::size_t>(i)] = default_threads();
    }
    for (const auto& mine : found) EXPECT_TRUE(same_bits(mine, expected)) << levels;
    EXPECT_EQ(threads, std::vector<int>(4, 1)) << levels;
  }
  omp_set_max_active_levels(allowed);
}

}  // namespace
}  // namespace recon::testing
#endif
