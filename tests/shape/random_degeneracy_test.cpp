// Thousands of random neighbourhoods, most of them degenerate in some way: flattened by any factor
// down to zero, on spheres and cones, duplicated, sheared, far from the origin, with too few
// particles, seen from beside. Whatever comes, the result is finite, a partition of unity, bounded
// by the reported amplification, and as good as the report says.
#include <gtest/gtest.h>

#include "recon/points/generate.hpp"
#include "recon/shape/shape_function.hpp"
#include "support/invariants.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

// A neighbourhood of 1 to 40 particles with a target and a support.
template <class Scalar, int D>
struct Neighbourhood {
  PointList<Scalar, D> points;
  std::array<Scalar, D> target;
  Scalar rho;

  explicit Neighbourhood(RandomNumbers& random) : points(1 + random.next() % 40) {
    const auto decades = [&](double from, double to) {
      return std::pow(10.0, random.uniform(from, to));
    };
    std::array<double, D> extent;  // a third of the axes are flat, a third thin
    for (double& e : extent) {
      const double kind = random.uniform();
      e = kind < 0.33 ? 0 : kind < 0.67 ? decades(-14, 0) : 1;
    }
    double shear[D][D];
    for (auto& row : shear)
      for (double& c : row) c = random.uniform(-1, 1);
    const double away = random.uniform() < 0.3 ? decades(-3, sizeof(Scalar) == 4 ? 3 : 6) : 0;
    const bool duplicated = random.next() % 4 == 0, on_sphere = random.next() % 4 == 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (duplicated && i > 2) {
        points[i] = points[i % 3];
        continue;
      }
      std::array<double, D> y;
      double norm = 0;
      for (double& c : y) {
        c = random.uniform(-1, 1);
        norm += c * c;
      }
      for (int d = 0; d < D; ++d) y[d] *= extent[d] / (on_sphere ? std::sqrt(norm) : 1);
      for (int d = 0; d < D; ++d) {
        double c = away;
        for (int e = 0; e < D; ++e) c += shear[d][e] * y[e];
        points[i][d] = static_cast<Scalar>(c);
      }
    }
    const bool beside = random.uniform() < 0.5;
    for (int d = 0; d < D; ++d)
      target[d] = static_cast<Scalar>(away + random.uniform(-1, 1) * (beside ? 1 : extent[d]));
    if (random.uniform() < 0.2) target = points[random.next() % points.size()];
    rho = static_cast<Scalar>(decades(-1, 1));
  }
};

template <class C>
class RandomDegeneracy : public ::testing::Test {};
TYPED_TEST_SUITE(RandomDegeneracy, AllCases, CaseNames);

template <class Scalar, int D, int R>
void check_many(int cases, std::uint64_t seed) {
  RandomNumbers random(seed);
  std::array<ShapeEvaluator<Monomials<D, R>, BSpline<3>, Scalar>, 2> evaluators{
      ShapeEvaluator<Monomials<D, R>, BSpline<3>, Scalar>(BSpline<3>{}, Solver::moment_matrix),
      ShapeEvaluator<Monomials<D, R>, BSpline<3>, Scalar>(BSpline<3>{}, Solver::gram_schmidt)};
  std::vector<ParticleIndex> all;
  for (int n = 0; n < cases; ++n) {
    const Neighbourhood<Scalar, D> hood(random);
    all.resize(hood.points.size());
    for (std::size_t p = 0; p < all.size(); ++p) all[p] = static_cast<ParticleIndex>(p);
    for (auto& evaluator : evaluators) {
      const auto& shape = evaluator.at(hood.target, hood.rho, std::span<const ParticleIndex>(all),
                                       [&](ParticleIndex p) { return hood.points[p]; });
      const FitReport& report = shape.report;
      if (report.rank == 0) continue;
      long double sum = 0, size = 0;
      std::array<long double, D> first{};
      for (std::size_t p = 0; p < all.size(); ++p) {
        sum += shape.value[p];
        size += std::abs(shape.value[p]);
        for (int d = 0; d < D; ++d) {
          first[d] +=
              shape.value[p] * ((long double)(hood.points[p][d]) - hood.target[d]) / hood.rho;
          ASSERT_TRUE(std::isfinite(shape.gradient[p][d])) << "case " << n;
        }
        for (const Scalar h : shape.hessian[p]) ASSERT_TRUE(std::isfinite(h)) << "case " << n;
      }
      const double tolerance = rounding<Scalar>(report);
      ASSERT_NEAR(static_cast<double>(sum), 1, tolerance)
          << "case " << n << " " << name_of(report.solver);
      // 1e-6: the report keeps the bound in single precision.
      ASSERT_LE(size, report.amplification * (1 + 1e-6 + tolerance) + tolerance) << "case " << n;
      for (int d = 0; d < D && report.degree >= 1; ++d) {
        ASSERT_NEAR(static_cast<double>(first[d]), 0, tolerance) << "case " << n << " axis " << d;
      }
    }
  }
}

TYPED_TEST(RandomDegeneracy, ResultsAreFiniteBoundedAndReproduce) {
  check_many<typename TypeParam::Scalar, TypeParam::D, 1>(4000, 1);
  check_many<typename TypeParam::Scalar, TypeParam::D, 2>(4000, 2);
  check_many<typename TypeParam::Scalar, TypeParam::D, 4>(500, 3);
}

template <class C>
class RandomDegeneracySlow : public ::testing::Test {};
TYPED_TEST_SUITE(RandomDegeneracySlow, AllCases, CaseNames);

TYPED_TEST(RandomDegeneracySlow, ManyMore) {
  for (std::uint64_t seed = 10; seed < 30; ++seed) {
    check_many<typename TypeParam::Scalar, TypeParam::D, 1>(20000, seed);
    check_many<typename TypeParam::Scalar, TypeParam::D, 2>(20000, seed);
    check_many<typename TypeParam::Scalar, TypeParam::D, 3>(4000, seed);
    check_many<typename TypeParam::Scalar, TypeParam::D, 4>(2000, seed);
  }
}

}  // namespace
}  // namespace recon::testing
