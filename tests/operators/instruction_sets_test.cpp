// Every instruction set that this processor has, forced: right by itself, and lanes that do not
// see each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "recon/core/instruction_set.hpp"
#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

constexpr std::array lane_solvers{Solver::moment_matrix, Solver::gram_schmidt};

template <class C>
class InstructionSets : public ::testing::Test {};
TYPED_TEST_SUITE(InstructionSets, AllCases, CaseNames);

TYPED_TEST(InstructionSets, ReproduceOnEveryCloud) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const InstructionSet set : available_instruction_sets())
    for (const auto& cloud : hostile_clouds<Scalar, D>()) {
      const auto targets = hostile_targets<Scalar, D>(cloud.points);
      for (const Solver solver : lane_solvers)
        for (const NeighbourRule& rule : {NeighbourRule(Radius{0.3}), NeighbourRule(Nearest{9})})
          for (int degree = 0; degree <= 4; ++degree) {
            Options options{.degree = degree, .neighbours = rule, .solver = solver};
            options.instruction_set = set;
            const BasicReconstruction<Scalar> fit(points_of(cloud.points), points_of(targets),
                                                  options);
            expect_reproduction<Scalar, D>(fit, cloud.points, targets, degree,
                                           cloud.name + ", " + std::string(name_of(set)) + ", " +
                                               std::string(name_of(solver)) + ", degree " +
                                               std::to_string(degree));
            if (::testing::Test::HasFailure()) return;
          }
    }
}

// Values, gradients and second derivatives agree with those of QR, which has no lanes.
TYPED_TEST(InstructionSets, AgreeWithSingleTargets) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 16 : 8, 0.4, 3);
  auto targets = random_points<Scalar, D>(61, 4);  // not a multiple of any number of lanes
  for (auto& x : targets)
    for (Scalar& c : x) c = Scalar(0.2) + Scalar(0.6) * c;
  for (const WeightForm form : {WeightForm::radial, WeightForm::tensor_product})
    for (int degree = 0; degree <= 3; ++degree) {
      Options options{.degree = degree, .form = form, .solver = Solver::qr};
      const BasicReconstruction<Scalar> wanted(points_of(points), points_of(targets), options);
      const auto g = numbers_of(wanted.gradient()), h = numbers_of(wanted.hessian());
      const auto v = numbers_of(wanted.values());
      const auto largest = [](const auto& numbers) {
        double most = 0;
        for (const Scalar x : numbers) most = std::max(most, std::abs(static_cast<double>(x)));
        return most;
      };
      for (const InstructionSet set : available_instruction_sets())
        for (const Solver solver : lane_solvers) {
          options.solver = solver;
          options.instruction_set = set;
          const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
          const auto& s = fit.report().summary();
          ASSERT_EQ(s.full, targets.size());
          const double loss = 1000 * TypeParam::eps * s.largest_amplification /
                              (solver == Solver::moment_matrix ? s.smallest_pivot : 1);
          const auto expect_near = [&](const auto& a, const auto& b, const char* what) {
            ASSERT_EQ(a.size(), b.size());
            for (std::size_t i = 0; i < a.size(); ++i)
              ASSERT_NEAR(a[i], b[i], loss * largest(b))
                  << what << " " << name_of(set) << " " << name_of(solver) << " degree " << degree;
          };
          expect_near(numbers_of(fit.values()), v, "value");
          expect_near(numbers_of(fit.gradient()), g, "gradient");
          if (degree >= 2) expect_near(numbers_of(fit.hessian()), h, "second derivative");
        }
    }
}

// A target's row has the same bits alone, in the middle of others, and beside targets with many
// more neighbours or none.
TYPED_TEST(InstructionSets, LanesDoNotSeeEachOther) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  auto points = random_points<Scalar, D>(400, 1);
  for (std::size_t i = 0; i < 200; ++i)  // half of them crowd in a corner
    for (Scalar& c : points[i]) c *= Scalar(0.2);
  auto targets = random_points<Scalar, D>(40, 2);
  for (Scalar& c : targets[7]) c = 30;
  for (const InstructionSet set : available_instruction_sets())
    for (const Solver solver : lane_solvers) {
      Options options{.degree = 2, .neighbours = Radius{0.25}, .solver = solver};
      options.instruction_set = set;
      const BasicReconstruction<Scalar> together(points_of(points), points_of(targets), options);
      const auto gradient = together.gradient();
      for (std::size_t t = 0; t < targets.size(); ++t) {
        const PointList<Scalar, D> one{targets[t]};
        const BasicReconstruction<Scalar> alone(points_of(points), points_of(one), options);
        EXPECT_EQ(alone.report()[0], together.report()[t]) << name_of(set) << " target " << t;
        const auto a = alone.values().row(0), b = together.values().row(t);
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a.value(i), b.value(i));
        const auto slopes = alone.gradient();
        for (std::size_t i = 0; i < a.size(); ++i)
          for (int d = 0; d < D; ++d)
            ASSERT_EQ(slopes.row(0).value(i, d), gradient.row(t).value(i, d));
      }
    }
}

TEST(InstructionSetChoice, OneThatIsMissingIsRefused) {
  const auto points = random_points<double, 2>(20, 1);
  Options options;
  options.instruction_set = static_cast<InstructionSet>(99);
  EXPECT_THROW(reconstruct(points_of(points), points_of(points), options), InvalidArgument);
}

}  // namespace
}  // namespace recon::testing
