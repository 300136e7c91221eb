#include "recon/core/sums.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace recon {
namespace {

TEST(Sums, ShortOnesArePlain) {
  std::vector<float> terms;
  float plain = 0;
  for (int i = 0; i < detail::sum_block; ++i) {
    terms.push_back(1.0f / static_cast<float>(3 + i));
    plain += terms.back();
  }
  EXPECT_EQ(detail::sum_of<float>(detail::sum_block, [&](int i) { return terms[i]; }), plain);
  EXPECT_EQ(detail::sum_of<float>(0, [&](int i) { return terms[i]; }), 0.0f);
}

// A plain sum of these floats is off by more than one part in a hundred. Equal terms are the
// worst that can be: all blocks err to the same side, but by no more than half a rounding of each
// of their terms.
TEST(Sums, LongOnesLoseNoMore) {
  const int count = 10'000'000;
  for (const float term : {0.1f, 0.7f, 1.0f / 3}) {
    const double exact = static_cast<double>(count) * static_cast<double>(term);
    const double bound = 0.5 * detail::sum_block * std::numeric_limits<float>::epsilon();
    EXPECT_NEAR(detail::sum_of<float>(count, [&](int) { return term; }), exact, bound * exact);
  }
  // Several sums at once, continued from what they are.
  double sums[2] = {1e16, 0.5};
  detail::add_in_blocks<2>(count, sums, [](int begin, int end, double* part) {
    for (int i = begin; i < end; ++i) {
      part[0] += 0.0;
      part[1] += i % 2 ? 1.0 : -1.0;
    }
  });
  EXPECT_EQ(sums[0], 1e16);
  EXPECT_EQ(sums[1], 0.5);
}

TEST(Sums, ScaledOnesDoNotOverflow) {
  const std::vector<double> a{30, -29.5, 0.5}, b{1.7e308, 1.7e308, 1.7e308};
  const auto sum = [&](double factor) {
    return detail::scaled_sum_of_products<double>(
        3, [&](int i) { return a[i]; }, [&](int i) { return factor * b[i]; });
  };
  EXPECT_NEAR(sum(1) / 1.7e308, 1, 1e-13);
  EXPECT_NEAR(sum(1e-300) / 1.7e8, 1, 1e-13);
  EXPECT_EQ(sum(0), 0);
  EXPECT_TRUE(std::isinf(detail::scaled_sum_of_products<double>(
      2, [](int) { return 1.5; }, [](int) { return 1e308; })));
  EXPECT_TRUE(std::isnan(detail::scaled_sum_of_products<double>(
      2, [](int) { return HUGE_VAL; }, [](int) { return 1e-308; })));
}

}  // namespace
}  // namespace recon
