// Options::progress: told in order while a reconstruction is made, without a change of its results;
// and a cancelled one leaves what a failed one leaves.
#include "recon/core/progress.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"

namespace recon::testing {
namespace {

void rest() {
  std::this_thread::sleep_for(std::chrono::microseconds(100));
}

// A weight that takes its time.
struct SlowParabola {
  double operator()(double q) const {
    static thread_local int calls = 0;
    if (++calls % 20 == 0) rest();
    return (1 - q) * (1 - q);
  }
  double derivative(double q) const { return 2 * q - 2; }
};

struct SlowFit {
  std::vector<std::array<double, 2>> points = random_points<double, 2>(2000, 1);
  std::vector<std::array<double, 2>> targets = random_points<double, 2>(4000, 2);
  std::vector<double> field = std::vector<double>(2000, 1);
  std::vector<double> told;
  std::function<bool(double)> answer = [](double) { return true; };

  // Both the search, which asks who is visible, and the fit take half a second or so.
  Options options(bool with_progress) {
    Options chosen{.degree = 1, .weight = SlowParabola{}, .neighbours = Nearest{20}};
    chosen.visible = [](std::size_t t, std::size_t) {
      static thread_local std::size_t last = 0;
      if (t != last) rest();
      last = t;
      return true;
    };
    if (with_progress)
      chosen.progress = [this](double fraction) {
        told.push_back(fraction);
        return answer(fraction);
      };
    return chosen;
  }
};

TEST(ProgressOfAReconstruction, IsToldAndChangesNothing) {
  SlowFit slow;
  const auto at = points_of(slow.targets);
  const Reconstruction expected = reconstruct(points_of(slow.points), at, slow.options(false));
  const Reconstruction fit = reconstruct(points_of(slow.points), at, slow.options(true));
  ASSERT_GE(slow.told.size(), 2u);
  EXPECT_LT(slow.told.front(), 0.4);  // of the search
  EXPECT_GT(slow.told.back(), 0.4);   // of the fit
  EXPECT_LE(slow.told.back(), 1);
  EXPECT_TRUE(std::is_sorted(slow.told.begin(), slow.told.end()));
  EXPECT_EQ(fit.apply(field_of(slow.field)), expected.apply(field_of(slow.field)));
  EXPECT_EQ(fit.neighbours().indices, expected.neighbours().indices);
}

TEST(ProgressOfAReconstruction, CancelsItsMaking) {
  for (const double until : {0.0, 0.45}) {  // in the search, and in the fit
    SlowFit slow;
    slow.answer = [until](double fraction) { return fraction < until; };
    EXPECT_THROW(reconstruct(points_of(slow.points), points_of(slow.targets), slow.options(true)),
                 Cancelled);
    EXPECT_GE(slow.told.back(), until);
    EXPECT_LT(slow.told.back(), 1);
  }
}

TEST(ProgressOfAReconstruction, CancelsAnUpdate) {
  SlowFit slow;
  Sources sources(points_of(slow.points));
  Reconstruction fit = reconstruct(sources, points_of(slow.targets), slow.options(true));
  const Reconstruction copy = fit;
  const Eigen::MatrixXd expected = fit.apply(field_of(slow.field));

  slow.answer = [](double) { return false; };
  EXPECT_THROW(fit.update(points_of(slow.targets)), Cancelled);
  EXPECT_EQ(fit.values().rows(), 0u);  // no targets until the next update
  EXPECT_EQ(fit.report().size(), 0u);
  EXPECT_EQ(copy.apply(field_of(slow.field)), expected);

  slow.answer = [](double) { return true; };
  fit.update(points_of(slow.targets));
  EXPECT_EQ(fit.apply(field_of(slow.field)), expected);
}

}  // namespace
}  // namespace recon::testing
