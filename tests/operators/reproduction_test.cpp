// Reproduction of polynomials and partition of unity, for every solver, on every hostile cloud.
#include <gtest/gtest.h>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/solvers.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

template <class C>
class Reproduction : public ::testing::Test {};
TYPED_TEST_SUITE(Reproduction, AllCases, CaseNames);

TYPED_TEST(Reproduction, EverySolverOnEveryCloudWithRadius) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const auto targets = hostile_targets<Scalar, D>(cloud.points);
    for (const Solver solver : all_solvers)
      for (const WeightForm form : {WeightForm::radial, WeightForm::tensor_product})
        for (int degree = 0; degree <= 4; ++degree)
          for (const double radius : {0.12, 0.5}) {
            Options options;
            options.degree = degree;
            options.form = form;
            options.solver = solver;
            options.neighbours = Radius{radius};
            const BasicReconstruction<Scalar> fit(points_of(cloud.points), points_of(targets),
                                                  options);
            expect_reproduction<Scalar, D>(fit, cloud.points, targets, degree,
                                           cloud.name + ", " + std::string(name_of(solver)) +
                                               ", degree " + std::to_string(degree) + ", radius " +
                                               std::to_string(radius));
            if (::testing::Test::HasFailure()) return;
          }
  }
}

TYPED_TEST(Reproduction, EveryWeightOnEveryCloudWithNearest) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const auto targets = hostile_targets<Scalar, D>(cloud.points);
    for (const Weight weight : all_weights())
      for (int degree = 0; degree <= 4; degree += 2) {
        Options options;
        options.degree = degree;
        options.weight = weight;
        const BasicReconstruction<Scalar> fit(points_of(cloud.points), points_of(targets), options);
        expect_reproduction<Scalar, D>(fit, cloud.points, targets, degree,
                                       cloud.name + ", " + std::string(name_of(weight)) +
                                           ", degree " + std::to_string(degree));
        if (cloud.points.size() > 0) {
          EXPECT_EQ(fit.report().no_support(), 0u) << cloud.name;
        }
        if (::testing::Test::HasFailure()) return;
      }
  }
}

// Well-spread clouds keep their full degree and a moderate Lebesgue constant: the guards must
// not bite there.
TYPED_TEST(Reproduction, WellSpreadCloudsAreFull) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 20 : 10, 0.4, 3);
  PointList<Scalar, D> targets = random_points<Scalar, D>(200, 4);
  for (auto& x : targets)
    for (Scalar& c : x) c = Scalar(0.1) + Scalar(0.8) * c;
  for (const Solver solver : all_solvers)
    for (int degree = 0; degree <= 4; ++degree) {
      Options options;
      options.degree = degree;
      options.solver = solver;
      options.neighbours = Nearest{static_cast<std::size_t>(3 * monomial_count(D, degree))};
      const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
      EXPECT_EQ(fit.report().summary().full, targets.size())
          << name_of(solver) << " degree " << degree;
      EXPECT_LT(fit.report().summary().largest_amplification, 15)
          << name_of(solver) << " degree " << degree;
    }
}

// All all_solvers give the same shape functions where the problem is regular, to the digits that
// conditioning leaves.
TYPED_TEST(Reproduction, SolversAgreeWhereRegular) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const auto targets = hostile_targets<Scalar, D>(cloud.points);
    for (int degree = 0; degree <= 4; ++degree) {
      Options options;
      options.degree = degree;
      options.neighbours = Radius{0.5};
      const BasicReconstruction<Scalar> reference(points_of(cloud.points), points_of(targets),
                                                  options);
      for (const Solver solver : {Solver::moment_matrix, Solver::qr, Solver::svd}) {
        options.solver = solver;
        const BasicReconstruction<Scalar> fit(points_of(cloud.points), points_of(targets), options);
        for (std::size_t t = 0; t < targets.size(); ++t) {
          const FitReport &report = fit.report()[t], &expected = reference.report()[t];
          ASSERT_EQ(report.rank, expected.rank)
              << cloud.name << " target " << t << " " << name_of(solver);
          ASSERT_EQ(report.kept, expected.kept);
          const double tolerance =
              20 * TypeParam::eps * (4 + report.rank) * std::max(1.0f, report.amplification) /
              std::max(std::min(report.smallest_pivot, expected.smallest_pivot), 1e-7f);
          const auto row = fit.values().row(t), wanted = reference.values().row(t);
          ASSERT_EQ(row.size(), wanted.size());
          for (std::size_t i = 0; i < row.size(); ++i)
            ASSERT_NEAR(row.value(i), wanted.value(i), tolerance)
                << cloud.name << " target " << t << " " << name_of(solver) << " degree " << degree;
        }
      }
    }
  }
}

}  // namespace
}  // namespace recon::testing
