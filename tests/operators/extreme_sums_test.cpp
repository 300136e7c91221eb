// A million particles in one support, and data near the largest number: what is promised for a few
// particles and ordinary data holds there, too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

constexpr std::size_t million = 1'000'000;

using OneOfEach = ::testing::Types<Case<float, 2>, Case<double, 2>>;
template <class C>
class ManyParticles : public ::testing::Test {};
TYPED_TEST_SUITE(ManyParticles, OneOfEach, CaseNames);

// All in one support: at a few places, or at places of their own.
template <class Scalar>
PointList<Scalar, 2> crowd(bool duplicates) {
  PointList<Scalar, 2> points = random_points<Scalar, 2>(million, 3);
  for (std::size_t p = 0; duplicates && p < million; ++p) points[p] = points[p % 9];
  return points;
}

// Sums of shape functions and of their moments are right to rounding, and so is what is applied.
// (QR works out floats in double; in double Eigen's own sums are plain, and lose digits.)
TYPED_TEST(ManyParticles, ShapeFunctionsReproduce) {
  using Scalar = typename TypeParam::Scalar;
  const PointList<Scalar, 2> targets{{Scalar(0.45), Scalar(0.55)}};
  std::vector<Solver> solvers{Solver::moment_matrix, Solver::gram_schmidt};
  if (sizeof(Scalar) == 4) solvers.push_back(Solver::qr);
  for (const bool duplicates : {true, false}) {
    if (!duplicates) solvers = {Solver::gram_schmidt};
    const auto points = crowd<Scalar>(duplicates);
    std::vector<std::array<Scalar, 2>> u;  // constant and linear
    for (const auto& x : points) u.push_back({Scalar(0.1), Scalar(0.3) * x[0] - x[1]});
    for (const Solver solver : solvers)
      for (const int degree : {0, 2}) {
        const BasicReconstruction<Scalar> fit(
            points_of(points), points_of(targets),
            {.degree = degree, .neighbours = Radius{1.5}, .solver = solver});
        const FitReport& report = fit.report()[0];
        const std::string where = std::string(name_of(solver)) + ", degree " +
                                  std::to_string(degree) + (duplicates ? ", duplicates" : "");
        ASSERT_EQ(report.neighbours, million) << where;
        ASSERT_EQ(report.status, FitStatus::full) << where;
        const double tolerance = rounding<Scalar>(report);
        const auto row = fit.values().row(0);
        long double one = 0, x = 0, xy = 0;
        for (std::size_t e = 0; e < row.size(); ++e) {
          const auto& at = points[row.particle(e)];
          const double dx = (static_cast<double>(at[0]) - static_cast<double>(targets[0][0])) / 1.5;
          const double dy = (static_cast<double>(at[1]) - static_cast<double>(targets[0][1])) / 1.5;
          const double phi = row.value(e);
          one += phi;
          x += phi * dx;
          xy += phi * dx * dy;
        }
        EXPECT_NEAR(static_cast<double>(one), 1, tolerance) << where;
        const auto values = fit.apply(field_of(u));
        EXPECT_NEAR(values(0, 0), u[0][0], tolerance) << where;
        if (degree == 0) continue;
        EXPECT_NEAR(static_cast<double>(x), 0, tolerance) << where;
        EXPECT_NEAR(static_cast<double>(xy), 0, tolerance) << where;
        EXPECT_NEAR(values(0, 1), 0.3 * 0.45 - 0.55, 2 * tolerance) << where;
        const auto slope = fit.gradient().apply(field_of(u));
        EXPECT_NEAR(slope(0, 2), 0.3, 20 * tolerance) << where;
        EXPECT_NEAR(slope(0, 3), -1, 20 * tolerance) << where;
      }
  }
}

// A column with a million entries, and a row with as many.
TYPED_TEST(ManyParticles, TransposesSumToRounding) {
  using Scalar = typename TypeParam::Scalar;
  const auto crowded = crowd<Scalar>(false);
  const PointList<Scalar, 2> few{{Scalar(0.2), Scalar(0.3)}, {Scalar(0.6), Scalar(0.7)}};
  std::vector<Scalar> f;
  for (const auto& x : crowded) f.push_back(Scalar(1.1) + x[0]);
  const std::vector<Scalar> u{Scalar(0.7), Scalar(1.3)};
  for (const bool few_particles : {true, false}) {
    const auto& points = few_particles ? few : crowded;
    const auto& targets = few_particles ? crowded : few;
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                          {.degree = 0, .neighbours = Radius{1.5}});
    const auto& at_points = few_particles ? u : f;
    const auto& at_targets = few_particles ? f : u;
    const auto forward = fit.apply(field_of(at_points));
    const auto back = fit.apply_transpose(field_of(at_targets));
    long double there = 0, here = 0, total = 0;
    for (std::size_t t = 0; t < targets.size(); ++t) {
      there += static_cast<long double>(forward(t, 0)) * at_targets[t];
      total += at_targets[t];
    }
    long double sum = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      here += static_cast<long double>(back(p, 0)) * at_points[p];
      sum += back(p, 0);
    }
    EXPECT_NEAR(static_cast<double>(there / here), 1, 16 * TypeParam::eps);
    // Shape functions sum to one, so that transposes conserve: what goes out comes in.
    EXPECT_NEAR(static_cast<double>(sum / total), 1, 16 * TypeParam::eps);
  }
}

template <class C>
class HugeData : public ::testing::Test {};
TYPED_TEST_SUITE(HugeData, AllCases, CaseNames);

template <class Scalar>
constexpr Scalar huge = static_cast<Scalar>(sizeof(Scalar) == 4 ? 3e38 : 1e308);

// Constants near the largest number are constants: values, gradients, second derivatives.
TYPED_TEST(HugeData, ConstantsStayConstants) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  const auto targets = random_points<Scalar, D>(50, 4);
  const double top = static_cast<double>(huge<Scalar>);
  const std::vector<Scalar> u(points.size(), huge<Scalar>);
  const std::vector<std::array<Scalar, 2>> pair(points.size(), {huge<Scalar>, Scalar(1)});
  for (int degree = 0; degree <= 2; ++degree) {
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                          {.degree = degree});
    const auto values = fit.apply(field_of(u));
    const auto gradient = fit.gradient().apply(field_of(u));
    const auto hessian = fit.hessian().apply(field_of(u));
    const auto both = fit.apply(field_of(pair));
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const double tolerance = rounding<Scalar>(fit.report()[t]), rho = fit.support(t);
      EXPECT_NEAR(values(t, 0) / top, 1, tolerance);
      EXPECT_NEAR(both(t, 0) / top, 1, tolerance);
      EXPECT_NEAR(both(t, 1), 1, tolerance);
      for (int d = 0; d < D; ++d) EXPECT_NEAR(gradient(t, d) / top * rho, 0, 100 * tolerance);
      for (Eigen::Index h = 0; h < hessian.cols(); ++h)
        EXPECT_NEAR(hessian(t, h) / top * rho * rho, 0, 1000 * tolerance);
    }
  }
}

TYPED_TEST(HugeData, TransposesAreFiniteOrSayWhere) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  const auto targets = random_points<Scalar, D>(50, 4);
  const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), {.degree = 1});
  std::vector<Scalar> f(targets.size(), Scalar(0));
  f[7] = huge<Scalar>;
  const auto back = fit.apply_transpose(field_of(f));
  for (Eigen::Index p = 0; p < back.size(); ++p) EXPECT_TRUE(std::isfinite(back(p, 0)));
  // One particle, and more targets than it can bear.
  const PointList<Scalar, D> one(1, points[0]);
  const BasicReconstruction<Scalar> sum(points_of(one), points_of(targets), {.degree = 0});
  f.assign(targets.size(), huge<Scalar>);
  EXPECT_THAT(message_of([&] { sum.apply_transpose(field_of(f)); }),
              ::testing::HasSubstr("component 0 of the result at particle 0 = inf: overflows"));
  for (std::size_t t = 0; t < f.size(); t += 2) f[t] = -huge<Scalar>;
  EXPECT_EQ(sum.apply_transpose(field_of(f))(0, 0), Scalar(0));
}

// A line through the largest number that goes on rising has no value beyond it.
TYPED_TEST(HugeData, ResultsThatDoNotExistAreErrors) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  PointList<Scalar, D> targets(3);
  for (auto& x : targets) x.fill(Scalar(0.5));
  targets[1].fill(Scalar(1.3));
  std::vector<Scalar> u;
  const Scalar top = std::numeric_limits<Scalar>::max() / Scalar(1.1);
  for (const auto& x : points) u.push_back((x[0] - Scalar(0.1)) * top);
  const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                        {.degree = 1, .neighbours = Radius{1.5}});
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u)); }),
              ::testing::HasSubstr("component 0 of the result at target 1"));
}

}  // namespace
}  // namespace recon::testing
