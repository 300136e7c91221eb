// Cases on which other reconstruction codes return wrong numbers, NaN, or crash; each in 1-D, 2-D
// and 3-D where it exists there, in float and double, for every solver.
#include <gtest/gtest.h>

#include "recon/basis/monomials.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"
#include "support/solvers.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

template <class C>
class PeerFailures : public ::testing::Test {};
TYPED_TEST_SUITE(PeerFailures, AllCases, CaseNames);

template <class Scalar, int D>
double smooth(const std::array<Scalar, D>& x) {
  double v = 1;
  for (int d = 0; d < D; ++d) v *= std::sin(2.0 * x[d] + 0.5 * d);
  return v;
}

template <class Scalar, int D, class Function>
std::vector<Scalar> sample(const PointList<Scalar, D>& points, Function&& function) {
  std::vector<Scalar> values;
  for (const auto& x : points) values.push_back(static_cast<Scalar>(function(x)));
  return values;
}

// Sources on the line y = 0 (all axes but the first), targets at y = 0.3 and 0.6: a minimum-norm
// solution turns the constant 10 into 9.17 and 7.35.
TYPED_TEST(PeerFailures, ConstantSurvivesBesideALine) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  PointList<Scalar, D> points, targets;
  for (int i = -5; i <= 5; ++i) {
    std::array<Scalar, D> x{};
    x[0] = Scalar(0.1) * Scalar(i);
    points.push_back(x);
  }
  for (const double away : {0.0, 0.3, 0.6}) {
    std::array<Scalar, D> x{};
    x[0] = Scalar(0.05);
    if constexpr (D >= 2) x[D - 1] = static_cast<Scalar>(away);
    targets.push_back(x);
  }
  const auto ten = sample<Scalar, D>(points, [](const auto&) { return 10; });
  const auto linear = sample<Scalar, D>(points, [](const auto& x) { return 1 + 2 * x[0]; });
  for (const Solver solver : all_solvers)
    for (int degree = 0; degree <= 4; ++degree)
      for (const NeighbourRule& rule : {NeighbourRule(Radius{1}), NeighbourRule(Nearest{9})}) {
        const BasicReconstruction<Scalar> fit(
            points_of(points), points_of(targets),
            {.degree = degree, .neighbours = rule, .solver = solver});
        const auto v = fit.apply(field_of(ten)), s = fit.apply(field_of(linear));
        for (std::size_t t = 0; t < targets.size(); ++t) {
          EXPECT_NEAR(v(t, 0), 10, 2000 * TypeParam::eps)
              << name_of(solver) << " degree " << degree << " target " << t;
          if (degree >= 1) {  // linear along the line, whatever the distance from it
            EXPECT_NEAR(s(t, 0), 1.1, 2000 * TypeParam::eps)
                << name_of(solver) << " degree " << degree;
          }
          EXPECT_EQ(fit.report()[t].status,
                    degree == 0 || D == 1 ? FitStatus::full : FitStatus::reduced);
        }
      }
}

// Fewer neighbours than basis terms: down to one and none.
TYPED_TEST(PeerFailures, FewerNeighboursThanTerms) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(50, 1), targets = random_points<Scalar, D>(20, 2);
  const auto u = sample<Scalar, D>(points, [](const auto& x) { return smooth<Scalar, D>(x); });
  for (const Solver solver : all_solvers)
    for (int degree = 1; degree <= 4; ++degree)
      for (std::size_t k = 1; k < static_cast<std::size_t>(monomial_count(D, degree)); ++k) {
        const BasicReconstruction<Scalar> fit(
            points_of(points), points_of(targets),
            {.degree = degree, .neighbours = Nearest{k}, .solver = solver});
        const auto v = fit.apply(field_of(u));
        for (std::size_t t = 0; t < targets.size(); ++t) {
          EXPECT_EQ(fit.report()[t].neighbours, k);
          EXPECT_LE(fit.report()[t].rank, k);
          EXPECT_EQ(fit.report()[t].status, FitStatus::reduced);
          EXPECT_LT(std::abs(v(t, 0)), 3) << "k " << k << " degree " << degree;
        }
      }
}

// Degree 1 with about as many neighbours as a careless default gives, on random clouds:
// errors of 0.64 (11 neighbours in 3-D) and of 1e2 (k = number of terms) have been seen on a
// function of size 1.
TYPED_TEST(PeerFailures, FewNeighboursOnRandomCloudsStayBounded) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(20000, 1);
  auto targets = random_points<Scalar, D>(10000, 2);
  for (auto& x : targets)
    for (Scalar& c : x) c = Scalar(0.1) + Scalar(0.8) * c;
  const auto u = sample<Scalar, D>(points, [](const auto& x) { return smooth<Scalar, D>(x); });
  const double spacing = D == 1   ? 1e-3
                         : D == 2 ? 0.02
                                  : 0.06;  // a few mean distances between neighbours
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt})
    for (const auto& [degree, k] : {std::pair<int, std::size_t>{1, 11},
                                    {1, D + 1},
                                    {2, 20},
                                    {2, std::size_t(monomial_count(D, 2))}}) {
      const BasicReconstruction<Scalar> fit(
          points_of(points), points_of(targets),
          {.degree = degree, .neighbours = Nearest{k}, .solver = solver});
      const auto v = fit.apply(field_of(u));
      double worst = 0;
      for (std::size_t t = 0; t < targets.size(); ++t)
        worst =
            std::max(worst, std::abs(static_cast<double>(v(t, 0)) - smooth<Scalar, D>(targets[t])));
      EXPECT_LT(worst, 6 * spacing + 1e3 * TypeParam::eps)
          << name_of(solver) << " degree " << degree << " k " << k;
    }
}

// Collinear support: NaN elsewhere. Here finite and right along the line, wherever the line points.
TYPED_TEST(PeerFailures, CollinearSupportIsFinite) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = diagonal_points<Scalar, D>(60, 1);
  const auto u =
      sample<Scalar, D>(points, [](const auto& x) { return 1 + x[0] - 2 * x[0] * x[0]; });
  PointList<Scalar, D> targets(2);
  targets[0].fill(Scalar(0.4));
  targets[1].fill(Scalar(0.61));
  for (const Solver solver : all_solvers) {
    const BasicReconstruction<Scalar> fit(
        points_of(points), points_of(targets),
        {.degree = 2, .neighbours = Radius{0.5}, .solver = solver});
    const auto v = fit.apply(field_of(u));
    for (int t = 0; t < 2; ++t) {
      const double x = targets[t][0];
      EXPECT_NEAR(v(t, 0), 1 + x - 2 * x * x, 200 * TypeParam::eps);
      EXPECT_EQ(fit.report()[t].rank, 3);  // 1, t, t^2 along the line
      EXPECT_EQ(fit.report()[t].degree, D == 1 ? 2 : 0);
    }
  }
}

// Tests of an absolute determinant call a small cloud singular: the unit of length must not matter.
TYPED_TEST(PeerFailures, UnitOfLengthDoesNotDecideRank) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const double unit : {1e-12, 1e-6, 1.0, 1e6, 1e12}) {
    auto points = jittered_points<Scalar, D>(D == 3 ? 8 : 15, 0.3, 1),
         targets = random_points<Scalar, D>(20, 2);
    for (auto* list : {&points, &targets})
      for (auto& x : *list)
        for (Scalar& c : x) c = static_cast<Scalar>(c * unit);
    for (const Solver solver : all_solvers) {
      const BasicReconstruction<Scalar> fit(
          points_of(points), points_of(targets),
          {.degree = 2, .neighbours = Radius{0.45 * unit}, .solver = solver});
      EXPECT_EQ(fit.report().summary().full, targets.size()) << unit << " " << name_of(solver);
    }
  }
}

// Absolute coordinates in the moment matrix lose all digits far from the origin.
TYPED_TEST(PeerFailures, FarFromTheOrigin) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const double far = sizeof(Scalar) == 4 ? 64 : 1e6;
  auto points = jittered_points<Scalar, D>(D == 3 ? 8 : 15, 0.3, 1),
       targets = random_points<Scalar, D>(20, 2);
  for (auto* list : {&points, &targets})
    for (auto& x : *list)
      for (Scalar& c : x) c = static_cast<Scalar>(c + far);
  const auto u = sample<Scalar, D>(
      points, [far](const auto& x) { return 3 * (x[0] - far) + (x[D - 1] - far) * (x[0] - far); });
  for (const Solver solver : all_solvers) {
    const BasicReconstruction<Scalar> fit(
        points_of(points), points_of(targets),
        {.degree = 2, .neighbours = Radius{0.45}, .solver = solver});
    const auto v = fit.apply(field_of(u));
    EXPECT_EQ(fit.report().summary().full, targets.size());
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const double a = targets[t][0] - far, b = targets[t][D - 1] - far;
      EXPECT_NEAR(v(t, 0), 3 * a + a * b, 300 * TypeParam::eps) << name_of(solver);
    }
  }
}

// A Cholesky whose success nobody checks: particles on one plane, duplicated, or all in one place.
TYPED_TEST(PeerFailures, SingularMomentMatrixIsNoticed) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  PointList<Scalar, D> one_place(30), targets(2);
  for (auto& x : one_place) x.fill(Scalar(0.5));
  targets[0].fill(Scalar(0.5));
  targets[1].fill(Scalar(0.45));
  std::vector<Scalar> u(30, Scalar(7));
  for (int i = 0; i < 30; ++i) u[i] += Scalar(i % 2);  // mean 7.5
  for (const Solver solver : all_solvers)
    for (int degree = 0; degree <= 4; ++degree) {
      const BasicReconstruction<Scalar> fit(
          points_of(one_place), points_of(targets),
          {.degree = degree, .neighbours = Radius{0.5}, .solver = solver});
      const auto v = fit.apply(field_of(u));
      for (int t = 0; t < 2; ++t) {
        EXPECT_NEAR(v(t, 0), 7.5, 100 * TypeParam::eps);
        EXPECT_EQ(fit.report()[t].rank, 1);
        EXPECT_EQ(fit.report()[t].degree, 0);
        EXPECT_EQ(fit.report()[t].status, degree == 0 ? FitStatus::full : FitStatus::reduced);
      }
    }
}

}  // namespace
}  // namespace recon::testing
