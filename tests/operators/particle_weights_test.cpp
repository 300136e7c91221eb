// Weights of the particles: what they mean (copies of a particle, Shepard's formula), and that all
// that holds without them holds with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/derivative.hpp"
#include "support/invariants.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

constexpr std::array solvers{Solver::moment_matrix, Solver::gram_schmidt, Solver::qr, Solver::svd};

std::vector<double> spread_weights(std::size_t count, double decades) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> exponent(-decades / 2, decades / 2);
  std::vector<double> weights(count);
  for (double& weight : weights) weight = std::pow(10, exponent(random));
  return weights;
}

template <int D>
PeriodicDomain<double> unit_period() {
  PeriodicDomain<double> domain;
  for (int d = 0; d < D; ++d) {
    domain.upper[d] = 1;
    domain.periodic[d] = d != 1;
  }
  return domain;
}

template <class C>
class ParticleWeights : public ::testing::Test {};
TYPED_TEST_SUITE(ParticleWeights, AllCases, CaseNames);

// A particle of weight 3 counts as three particles at its place: for every solver, form,
// instruction set, across periods, and whether or not the cloud is sorted (it is from
// 512 particles on).
TYPED_TEST(ParticleWeights, CountLikeCopies) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const std::size_t count : {std::size_t{150}, std::size_t{700}}) {
    const auto points = random_points<Scalar, D>(count, 3);
    const auto u = smooth_field<Scalar, D>(points);
    const auto targets = random_points<Scalar, D>(37, 5);
    PointList<Scalar, D> copies;
    std::vector<Scalar> u_copies;
    std::vector<double> weights;
    for (std::size_t p = 0; p < count; ++p) {
      weights.push_back(static_cast<double>(1 + p % 3));
      copies.insert(copies.end(), 1 + p % 3, points[p]);
      u_copies.insert(u_copies.end(), 1 + p % 3, u[p]);
    }
    const double rho = D == 1 ? 0.1 : D == 2 ? 0.2 : 0.3;
    for (const InstructionSet set : available_instruction_sets())
      for (const Solver solver : solvers)
        for (const WeightForm form : {WeightForm::radial, WeightForm::tensor_product})
          for (int degree = 0; degree <= 2; ++degree) {
            Options options{.degree = degree,
                            .form = form,
                            .neighbours = Radius{rho},
                            .solver = solver,
                            .domain = unit_period<D>()};
            options.instruction_set = set;
            const BasicReconstruction<Scalar> wanted(points_of(copies), points_of(targets),
                                                     options);
            options.particle_weights = weights;
            const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
            const auto a = fit.apply(field_of(u)), b = wanted.apply(field_of(u_copies));
            for (std::size_t t = 0; t < targets.size(); ++t) {
              const FitReport& report = fit.report()[t];
              EXPECT_EQ(report.kept, wanted.report()[t].kept);
              EXPECT_NEAR(a(t, 0), b(t, 0), 4 * rounding<Scalar>(report))
                  << name_of(solver) << " degree " << degree << " target " << t;
            }
          }
  }
}

// Degree 0 is Shepard's formula with w m, as particle-in-cell codes weigh by mass.
TYPED_TEST(ParticleWeights, AreThoseOfShepard) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(200, 3);
  const auto u = smooth_field<Scalar, D>(points);
  const auto targets = random_points<Scalar, D>(20, 5);
  const auto weights = spread_weights(points.size(), 4);
  const BasicReconstruction<Scalar> fit(
      points_of(points), points_of(targets),
      {.degree = 0, .particle_weights = weights, .neighbours = Radius{0.4}});
  const auto values = fit.apply(field_of(u));
  for (std::size_t t = 0; t < targets.size(); ++t) {
    double above = 0, below = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      double square = 0;
      for (int d = 0; d < D; ++d)
        square +=
            std::pow(static_cast<double>(points[p][d]) - static_cast<double>(targets[t][d]), 2);
      const double q = std::sqrt(square) / 0.4;
      if (q >= 1) continue;
      above += weights[p] * BSpline<3>{}(q)*u[p];
      below += weights[p] * BSpline<3>{}(q);
    }
    EXPECT_NEAR(values(t, 0), above / below, 50 * TypeParam::eps);
  }
}

// Partition of unity and polynomials, with weights over eight decades, on every hostile cloud.
TYPED_TEST(ParticleWeights, KeepReproduction) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const auto weights = spread_weights(cloud.points.size(), 8);
    const auto targets = hostile_targets<Scalar, D>(cloud.points);
    for (const Solver solver : solvers)
      for (int degree = 0; degree <= 3; ++degree) {
        const BasicReconstruction<Scalar> fit(points_of(cloud.points), points_of(targets),
                                              {.degree = degree,
                                               .particle_weights = weights,
                                               .neighbours = Radius{0.3},
                                               .solver = solver});
        expect_reproduction<Scalar, D>(fit, cloud.points, targets, degree,
                                       cloud.name + ", " + std::string(name_of(solver)));
        if (::testing::Test::HasFailure()) return;
      }
  }
}

// Only ratios matter: the unit of mass changes nothing.
TYPED_TEST(ParticleWeights, HaveAnyUnit) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  const auto u = smooth_field<Scalar, D>(points);
  const auto targets = random_points<Scalar, D>(20, 5);
  const auto weights = spread_weights(points.size(), 2);
  Options options{.degree = 1, .particle_weights = weights};
  const auto values = BasicReconstruction<Scalar>(points_of(points), points_of(targets), options)
                          .apply(field_of(u));
  for (const double unit : {1e-290, 1e-26, 3.7, 1e290}) {
    auto scaled = weights;
    for (double& weight : scaled) weight *= unit;
    options.particle_weights = scaled;
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
    const auto other = fit.apply(field_of(u));
    for (std::size_t t = 0; t < targets.size(); ++t)
      EXPECT_NEAR(other(t, 0), values(t, 0), rounding<Scalar>(fit.report()[t])) << unit;
  }
}

TYPED_TEST(ParticleWeights, TransposeIsTheTranspose) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(600, 3);
  const auto targets = random_points<Scalar, D>(550, 5);
  const auto u = smooth_field<Scalar, D>(points), f = smooth_field<Scalar, D>(targets);
  const auto weights = spread_weights(points.size(), 3);
  const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                        {.particle_weights = weights});
  const auto forward = fit.apply(field_of(u));
  const auto back = fit.apply_transpose(field_of(f));
  double there = 0, here = 0, scale = 0;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    there += static_cast<double>(forward(t, 0)) * f[t];
    scale += std::abs(static_cast<double>(forward(t, 0)) * f[t]);
  }
  for (std::size_t p = 0; p < points.size(); ++p) here += static_cast<double>(back(p, 0)) * u[p];
  EXPECT_NEAR(there, here, 10 * TypeParam::eps * scale);
}

template <class C>
class ParticleWeightGradient : public ::testing::Test {};
TYPED_TEST_SUITE(ParticleWeightGradient, DoubleCases, CaseNames);

TYPED_TEST(ParticleWeightGradient, EqualsFiniteDifferences) {
  constexpr int D = TypeParam::D;
  const auto points = random_points<double, D>(D == 1 ? 80 : 400, 3);
  const auto values = smooth_field<double, D>(points);
  const auto weights = spread_weights(points.size(), 2);
  auto targets = random_points<double, D>(15, 5);
  for (auto& x : targets)
    for (double& c : x) c = 0.15 + 0.7 * c;
  std::vector<Options> cases;
  for (const Solver solver : solvers)
    for (int degree = 0; degree <= 2; ++degree)
      cases.push_back({.degree = degree, .neighbours = Radius{0.4}, .solver = solver});
  cases.push_back({.form = WeightForm::tensor_product, .neighbours = Radius{0.4}});
  cases.push_back({.degree = 2, .neighbours = Nearest{3 * monomial_count(D, 2)}});
  cases.push_back({.neighbours = Radius{0.4}, .domain = unit_period<D>()});
  for (std::size_t c = 0; c < cases.size(); ++c) {
    Options& options = cases[c];
    options.particle_weights = weights;
    const auto evaluate = [&](const PointList<double, D>& at) {
      return reconstruct(points_of(points), points_of(at), options).apply(field_of(values));
    };
    const auto gradient = reconstruct(points_of(points), points_of(targets), options)
                              .gradient()
                              .apply(field_of(values));
    expect_derivative<D>(gradient, targets, evaluate, 4e-7, "case " + std::to_string(c));
  }
}

TEST(ParticleWeightErrors, NameTheParticle) {
  const auto points = random_points<double, 2>(50, 1);
  std::vector<double> weights(50, 2.0);
  const auto said = [&] {
    return message_of(
        [&] { reconstruct(points_of(points), points_of(points), {.particle_weights = weights}); });
  };
  using ::testing::HasSubstr;
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    weights[7] = bad;
    EXPECT_THAT(said(), HasSubstr("particle_weights of particle 7 = "));
    EXPECT_THAT(said(), HasSubstr("must be positive and finite"));
  }
  weights[7] = 1e-31;
  EXPECT_THAT(said(), HasSubstr("particle_weights of particle 7 = "));
  EXPECT_THAT(said(), HasSubstr("1e-30 times the largest"));
  weights.resize(49);
  weights[7] = 1;
  EXPECT_THAT(said(), HasSubstr("number of particle_weights = 49"));
}

}  // namespace
}  // namespace recon::testing
