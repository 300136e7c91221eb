// A million particles in one cell, data near the largest number, weights that are no weights.
#include <gmock/gmock.h>

#include "grid_support.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

template <class C>
class GridExtremes : public ::testing::Test {};
TYPED_TEST_SUITE(GridExtremes, AllCases, CaseNames);

template <class C>
class GridCrowd : public ::testing::Test {};
using CrowdCases = ::testing::Types<Case<float, 2>, Case<float, 3>, Case<double, 2>>;
TYPED_TEST_SUITE(GridCrowd, CrowdCases, CaseNames);

// Moments of a million particles in one cell (and some beside it) are those that long double sums,
// and fits of constants and lines are right, at nodes of full and of reduced degree.
TYPED_TEST(GridCrowd, AMillionParticlesInACell) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  constexpr std::size_t million = 1'000'000;
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) grid.counts[d] = 4;
  auto points = random_points<Scalar, D>(million, 3);
  for (auto& x : points)
    for (Scalar& c : x) c += 1;  // in the middle cell of three
  for (auto x : random_points<Scalar, D>(50, 4)) {
    for (Scalar& c : x) c *= 3;
    points.push_back(x);
  }
  Matrix<Scalar> u(points.size(), 2);
  for (std::size_t p = 0; p < points.size(); ++p) {
    u(p, 0) = Scalar(0.1);
    u(p, 1) = Scalar(0.3) * points[p][0] - Scalar(0.2);
  }
  const Options options{.degree = D == 3 ? 1 : 2, .weight = Weight::quadratic_b_spline};
  const BasicGridMoments<Scalar> moments(points_of(points), {field_of(u)}, grid, options);
  const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
  std::size_t full = 0;
  for (std::size_t i = 0; i < grid.size(); i += D == 3 ? 5 : 3) {
    const auto index = grid.index(i);
    long double count = 0, weights = 0;
    for (const auto& x : points) {
      double w = 1;
      for (int d = 0; d < D; ++d) {
        const double q = std::abs(static_cast<double>(x[d]) -
                                  static_cast<double>(grid.coordinate(index[d], d))) /
                         1.5;
        w *= q < 1 ? BSpline<2>{}(q) : 0;
      }
      count += w > 0;
      weights += w;
    }
    const Scalar* sums = moments.values().data() + i * static_cast<std::size_t>(moments.per_node());
    // Weights of the order of rounding need not count as neighbours.
    EXPECT_NEAR(static_cast<double>(sums[0] / count), 1, 1e-3);
    // Rounding of a coordinate counts most where weights are small.
    EXPECT_NEAR(static_cast<double>(sums[1] / weights), 1, 100 * TypeParam::eps) << "node " << i;
    const FitReport& report = fit.report()[i];
    full += report.status == FitStatus::full;
    ASSERT_NE(report.status, FitStatus::no_support);
    EXPECT_NEAR(fit.values()(i, 0), 0.1, allowed<Scalar>(report) / 10) << "node " << i;
    if (report.degree > 0) {
      EXPECT_NEAR(fit.values()(i, 1), 0.3 * static_cast<double>(grid.coordinate(index[0], 0)) - 0.2,
                  allowed<Scalar>(report) / 10)
          << "node " << i;
    }
  }
  EXPECT_GT(full, 0u);
}

// The fit from particles, which takes over where the moment matrix is not safe.
TEST(GridOnALine, AMillionParticles) {
  StructuredGrid<float> grid;
  grid.dimension = 2;
  grid.counts = {4, 4, 1};
  auto points = random_points<float, 2>(1'000'000, 3);
  for (auto& x : points) x = {x[0] + 1, x[0] + 1};
  Matrix<float> u(points.size(), 1);
  for (std::size_t p = 0; p < points.size(); ++p) u(p, 0) = 0.3f * points[p][0] - 0.2f;
  const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid);
  const std::size_t at = 5;  // (1, 1)
  EXPECT_EQ(fit.report()[at].solver, Solver::gram_schmidt);
  EXPECT_EQ(fit.report()[at].rank, 2);
  EXPECT_NEAR(fit.values()(at, 0), 0.1, 1e-5);
}

TYPED_TEST(GridExtremes, HugeConstantsStayConstants) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto huge = static_cast<Scalar>(sizeof(Scalar) == 4 ? 3e38 : 1e308);
  const auto points = random_points<Scalar, D>(300, 3);
  const auto grid = uneven_grid<Scalar, D>();
  Matrix<Scalar> u(points.size(), 2);
  u.col(0).setConstant(huge);
  u.col(1).setConstant(1);
  for (int degree = 0; degree <= 2; ++degree) {
    const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, {.degree = degree},
                                         {.gradients = Derivative::diffuse});
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (fit.report()[i].status == FitStatus::no_support) continue;
      EXPECT_NEAR(fit.values()(i, 0) / huge, 1, allowed<Scalar>(fit.report()[i]));
      EXPECT_NEAR(fit.values()(i, 1), 1, allowed<Scalar>(fit.report()[i]));
      for (int d = 0; d < D; ++d)
        EXPECT_NEAR(fit.gradients()(i, d) / huge, 0, 100 * allowed<Scalar>(fit.report()[i]));
    }
    // Moments are sums that the caller sees; those that have overflowed are not made into values.
    const BasicGridMoments<Scalar> moments(points_of(points), {field_of(u)}, grid,
                                           {.degree = degree});
    EXPECT_THAT(message_of([&] { moments.solve(); }), HasSubstr("overflows"));
  }
  // A line that reaches the largest number at the border of the cloud, and nodes beyond it.
  for (std::size_t p = 0; p < points.size(); ++p)
    u(p, 0) = (2 * points[p][0] - 1) * std::numeric_limits<Scalar>::max();
  EXPECT_THAT(message_of([&] { reconstruct_on_grid(points_of(points), {field_of(u)}, grid); }),
              HasSubstr("value of component 0 at node"));
}

// Masses in any unit: grams or those of atoms.
TYPED_TEST(GridExtremes, ParticleWeightsHaveAnyUnit) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  const auto grid = uneven_grid<Scalar, D>();
  const Matrix<Scalar> u = wave(points, 2);
  const auto with_unit = [&](double unit) {
    std::vector<double> weights;
    for (std::size_t p = 0; p < points.size(); ++p)
      weights.push_back(unit * static_cast<double>(1 + p % 4));
    return reconstruct_on_grid(points_of(points), {field_of(u)}, grid,
                               {.particle_weights = weights});
  };
  const auto fit = with_unit(1);
  for (const double unit : {1e-300, 1e-37, 1e20, 8e37, 4e307}) {
    const auto other = with_unit(unit);
    for (std::size_t i = 0; i < grid.size(); ++i) {
      ASSERT_EQ(fit.report()[i].kept, other.report()[i].kept);
      if (fit.report()[i].status == FitStatus::no_support) continue;
      for (int c = 0; c < 2; ++c)
        EXPECT_NEAR(fit.values()(i, c), other.values()(i, c), allowed<Scalar>(fit.report()[i]))
            << unit;
    }
  }
}

TEST(GridWeights, BadOnesAreErrors) {
  struct Broken {
    double value;
    double operator()(double q) const { return q > 0.5 ? value : 1 - q; }
    double derivative(double) const { return -1; }
  };
  const auto points = random_points<double, 2>(300, 3);
  const auto grid = uneven_grid<double, 2>();
  const Matrix<double> u = wave(points, 1);
  for (const InstructionSet set : available_instruction_sets())
    for (const WeightForm form : {WeightForm::tensor_product, WeightForm::radial})
      for (const double bad : {-1e-3, std::nan(""), HUGE_VAL}) {
        const Options options{
            .weight = Broken{bad}, .form = form, .neighbours = Radius{0.4}, .instruction_set = set};
        EXPECT_THAT(message_of([&] {
                      reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
                    }),
                    HasSubstr("weight w(q) at q = 0."));
      }
}

}  // namespace
}  // namespace recon::testing
