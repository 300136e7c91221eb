// The measured limit of the step is the one that follows from the maps.
#include "recon/studies/stability.hpp"

#include "mpm/support.hpp"

namespace recon::mpm::test {
namespace {

TEST(Stability, LimitFollowsFromTheMaps) {
  // W of the mass-weighted map: the mean of (1 - 2 xi)^2 over the particles of a cell.
  for (const int n : {1, 2, 4, 8}) {
    double W = 0;
    for (int j = 0; j < n; ++j) W += std::pow(1 - (2 * j + 1.0) / n, 2) / n;
    const auto limit = stability_limit(method_named("mpm"), n);
    EXPECT_NEAR(limit.W, W, 1e-12);
    EXPECT_NEAR(limit.measured, 1 / std::sqrt(2 - W), 0.005);
    EXPECT_NEAR(limit.analytic, 1 / std::sqrt(2 - W), 1e-12);
  }
  for (const char* method : {"cpdi2", "improved_cpdi"}) {
    const auto limit = stability_limit(method_named(method), 4);
    EXPECT_NEAR(limit.measured, limit.analytic, 0.005) << method;
  }
  // The corners' velocities follow L, which the formula does not know.
  const auto cpls = stability_limit(method_named("cpls"), 4);
  EXPECT_NEAR(cpls.measured, cpls.analytic, 0.01);
  const auto impm = stability_limit(method_named("impm"), 4);
  EXPECT_LE(impm.measured, impm.analytic + 0.002);
  EXPECT_GE(impm.measured, 0.95 * impm.analytic);
}

TEST(Stability, LongWavesHaveTheSpeedOfSound) {
  for (const char* method : {"mpm", "cpdi2", "impm", "cpls"}) {
    const auto curve = dispersion(method_named(method), 4, 0.4);
    EXPECT_NEAR(curve.front().measured, 1, 0.003) << method;
    EXPECT_NEAR(curve.front().analytic, 1, 0.001) << method;
    EXPECT_LT(curve[8].measured, curve[4].measured) << method;  // short waves are slower
  }
}

}  // namespace
}  // namespace recon::mpm::test
