// The solvers by their defining identities: orthonormality, rank, agreement with higher precision.
#include "recon/local_solve/gram_schmidt.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "recon/shape/shape_function.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

// A cloud of offsets in [-1, 1]^D with weights, as a LocalCloud.
template <class T, int D>
struct Offsets {
  std::array<std::vector<T>, D> xi;
  std::vector<T> w;

  template <class Scalar>
  explicit Offsets(const PointList<Scalar, D>& points) {
    RandomNumbers random(5);
    for (const auto& x : points) {
      for (int d = 0; d < D; ++d) xi[d].push_back(T(2) * T(x[d]) - T(1));
      w.push_back(static_cast<T>(random.uniform(0.01, 1)));
    }
  }
  LocalCloud<T, D> cloud() const {
    LocalCloud<T, D> c;
    c.size = static_cast<int>(w.size());
    c.w = w.data();
    for (int d = 0; d < D; ++d) c.xi[d] = xi[d].data();
    return c;
  }
};

template <class C>
class GramSchmidtFit : public ::testing::Test {};
TYPED_TEST_SUITE(GramSchmidtFit, AllCases, CaseNames);

// Q^T Q = I to rounding on every cloud, however degenerate: what is not independent
// has been dropped.
TYPED_TEST(GramSchmidtFit, KeptColumnsAreOrthonormal) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const Offsets<Scalar, D> offsets(cloud.points);
    GramSchmidt<Scalar, Monomials<D, 4>> fit;
    const FitReport report = fit.fit(offsets.cloud());
    const auto& q = fit.result();
    ASSERT_EQ(q.rank(), report.rank);
    ASSERT_LE(q.rank(), static_cast<int>(cloud.points.size()));
    for (int a = 0; a < q.rank(); ++a)
      for (int b = 0; b <= a; ++b) {
        double product = 0;
        for (int p = 0; p < q.size(); ++p)
          product += double(q.column(a)[p]) * double(q.column(b)[p]);
        EXPECT_NEAR(product, a == b, 60 * TypeParam::eps)
            << cloud.name << " columns " << a << " " << b;
      }
  }
}

// One dependent term among six: five are kept, the quadratic block loses one
// direction, nothing else.
TEST(GramSchmidt, DropsExactlyTheDependentDirection) {
  const auto circle = sphere_points<double, 2>(40, 0.4, 1);  // x^2 + y^2 depends on 1, x, y
  const Offsets<double, 2> offsets(circle);
  GramSchmidt<double, Monomials<2, 2>> fit;
  const FitReport report = fit.fit(offsets.cloud());
  EXPECT_EQ(report.rank, 5);
  EXPECT_EQ(report.degree, 1);
  EXPECT_EQ(report.kept[0], 1);
  EXPECT_EQ(report.kept[1], 2);
  EXPECT_EQ(report.kept[2], 2);
  EXPECT_EQ(report.status, FitStatus::reduced);
}

// Rank against an SVD with a clear gap, over clouds whose rank is known.
TEST(GramSchmidt, RankOfKnownClouds) {
  const auto rank = [](const auto& points, auto basis) {
    constexpr int D = decltype(basis)::dimension;
    const Offsets<double, D> offsets(points);
    GramSchmidt<double, decltype(basis)> fit;
    return int(fit.fit(offsets.cloud()).rank);
  };
  EXPECT_EQ(rank(regular_points<double, 2>(2), Monomials<2, 2>{}), 4);  // 1, x, y, xy
  EXPECT_EQ(rank(regular_points<double, 2>(3), Monomials<2, 4>{}), 9);  // x^i y^j, i, j <= 2
  EXPECT_EQ(rank(regular_points<double, 3>(2), Monomials<3, 3>{}), 8);
  EXPECT_EQ(rank(diagonal_points<double, 3>(50, 1), Monomials<3, 4>{}), 5);  // 1, t, ..., t^4
  EXPECT_EQ(rank(flat_points<double, 3>(90, 1, 0, 1), Monomials<3, 4>{}), 15);
  EXPECT_EQ(rank(flat_points<double, 3>(90, 1, 1e-3, 1), Monomials<3, 4>{}), 35);
  EXPECT_EQ(rank(sphere_points<double, 3>(90, 0.4, 1), Monomials<3, 3>{}),
            16);  // harmonics to degree 3
  EXPECT_EQ(rank(duplicated_points<double, 2>(4, 9, 1), Monomials<2, 3>{}), 4);
}

// The square of the ratio of the extreme singular values of the weighted basis, columns scaled to
// one length: the reciprocal condition number of the moment matrix scaled to unit diagonal.
template <class B, class T>
double reciprocal_condition(const LocalCloud<T, B::dimension>& cloud) {
  Eigen::MatrixXd a(cloud.size, B::size);
  for (int p = 0; p < cloud.size; ++p) {
    std::array<double, B::dimension> xi;
    for (int d = 0; d < B::dimension; ++d) xi[d] = static_cast<double>(cloud.xi[d][p]);
    std::array<double, B::size> values;
    B::evaluate(xi, values.data());
    for (int j = 0; j < B::size; ++j)
      a(p, j) = std::sqrt(static_cast<double>(cloud.w[p])) * values[j];
  }
  a.colwise().normalize();
  const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(a).singularValues();
  return std::pow(s[B::size - 1] / s[0], 2);
}

// The smallest pivot is no less than the reciprocal condition number, and no estimate of it.
TYPED_TEST(GramSchmidtFit, SmallestPivotBoundsTheReciprocalCondition) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  using B = Monomials<D, 2>;
  int clear = 0;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const Offsets<Scalar, D> offsets(cloud.points);
    LocalSolve<Scalar, B> moments(Solver::moment_matrix), columns(Solver::gram_schmidt);
    for (auto* solve : {&moments, &columns}) {
      const FitReport report = solve->fit(offsets.cloud());
      if (report.status != FitStatus::full || report.smallest_pivot < 1e-3f) continue;
      ++clear;
      const double truth = reciprocal_condition<B>(offsets.cloud());
      EXPECT_GE(report.smallest_pivot, truth * (1 - 1e-5)) << cloud.name;
      EXPECT_LE(report.smallest_pivot, truth * 1000) << cloud.name;
    }
  }
  EXPECT_GT(clear, 3);
}

template <class C>
class LongDouble : public ::testing::Test {};
TYPED_TEST_SUITE(LongDouble, DoubleCases, CaseNames);

// Gram-Schmidt in double against itself in extended precision, on all clouds: the difference is
// rounding times the amplification of the fit, even where directions are dropped. (Measured: 8
// roundings on even clouds, up to 600 on clusters of 1e-6.)
TYPED_TEST(LongDouble, GramSchmidtIsAccurate) {
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<double, D>()) {
    if (D == 1 && cloud.name == "on a sphere")
      continue;  // two places, told apart from rounding in double only
    std::vector<ParticleIndex> all(cloud.points.size());
    for (std::size_t p = 0; p < all.size(); ++p) all[p] = static_cast<ParticleIndex>(p);
    ShapeEvaluator<Monomials<D, 1>, BSpline<3>> shapes(BSpline<3>{});
    ShapeEvaluator<Monomials<D, 1>, BSpline<3>, long double> reference(BSpline<3>{});
    for (const auto& target : hostile_targets<double, D>(cloud.points)) {
      std::array<long double, D> x;
      for (int d = 0; d < D; ++d) x[d] = target[d];
      const auto& expected =
          reference.at(x, 0.5L, std::span<const ParticleIndex>(all), [&](ParticleIndex p) {
            std::array<long double, D> y;
            for (int d = 0; d < D; ++d) y[d] = cloud.points[p][d];
            return y;
          });
      const auto& shape = shapes.at(target, 0.5, std::span<const ParticleIndex>(all),
                                    [&](ParticleIndex p) { return cloud.points[p]; });
      // Rounded coordinates may put particles a hair off the line or plane that they
      // were meant for.
      if (shape.report.rank != expected.report.rank) {
        EXPECT_LT(std::min(shape.report.smallest_pivot, expected.report.smallest_pivot), 1e-20f)
            << cloud.name;
        continue;
      }
      for (std::size_t p = 0; p < all.size(); ++p)
        EXPECT_NEAR(shape.value[p], static_cast<double>(expected.value[p]),
                    1000 * TypeParam::eps * std::max(1.0f, shape.report.amplification))
            << cloud.name << ", smallest_pivot " << shape.report.smallest_pivot;
    }
  }
}

}  // namespace
}  // namespace recon::testing
