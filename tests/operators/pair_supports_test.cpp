// Fits whose weights have a support radius for each pair: that of the particle, the mean, the larger.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "recon/operators/kernel_sum.hpp"
#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/derivative.hpp"
#include "support/invariants.hpp"
#include "support/message_of.hpp"
#include "support/solvers.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

std::vector<double> radii_between(std::size_t count, double least, double largest,
                                  std::uint64_t seed) {
  std::vector<double> radii;
  for (const auto& x : random_points<double, 1>(count, seed))
    radii.push_back(least + (largest - least) * x[0]);
  return radii;
}

template <class Scalar, int D>
struct Clouds {
  PointList<Scalar, D> points = random_points<Scalar, D>(300, 1);
  PointList<Scalar, D> targets = random_points<Scalar, D>(60, 2);
  double length = D == 1 ? 0.05 : D == 2 ? 0.2 : 0.4;
};

template <class C>
class PairSupports : public ::testing::Test {};
TYPED_TEST_SUITE(PairSupports, AllCases, CaseNames);

TYPED_TEST(PairSupports, ReproducePolynomials) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Clouds<Scalar, D> clouds;
  const auto of_particles =
      radii_between(clouds.points.size(), clouds.length, 2 * clouds.length, 3);
  const auto of_targets = radii_between(clouds.targets.size(), clouds.length, 2 * clouds.length, 4);
  for (const PairSupport support : {PairSupport::particle, PairSupport::mean, PairSupport::larger})
    for (const WeightForm form : all_forms)
      for (const Solver solver : all_solvers)
        for (int degree = 0; degree <= 2; ++degree) {
          PairRadii rule{of_particles, {}, support};
          if (support != PairSupport::particle) rule.targets = of_targets;
          Options options{.degree = degree, .form = form, .neighbours = rule, .solver = solver};
          const BasicReconstruction<Scalar> fit(points_of(clouds.points), points_of(clouds.targets),
                                                options);
          EXPECT_EQ(fit.report().summary().full, clouds.targets.size());
          expect_reproduction<Scalar, D>(
              fit, clouds.points, clouds.targets, degree,
              std::string(name_of(solver)) + ", degree " + std::to_string(degree));
          if (::testing::Test::HasFailure()) return;
        }
}

// Where all radii are one, the weights are those of Radius, and so is every bit.
TYPED_TEST(PairSupports, OfOneSizeAreThoseOfRadius) {
  using Scalar = typename TypeParam::Scalar;
  const Clouds<Scalar, TypeParam::D> clouds;
  const double h = 1.5 * clouds.length;
  const std::vector<double> of_particles(clouds.points.size(), h), of_targets(60, h);
  for (const WeightForm form : all_forms)
    for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
      Options options{.degree = 2, .form = form, .neighbours = Radius{h}, .solver = solver};
      const BasicReconstruction<Scalar> one(points_of(clouds.points), points_of(clouds.targets),
                                            options);
      for (const PairRadii& rule :
           {PairRadii{of_particles}, PairRadii{of_particles, of_targets, PairSupport::mean},
            PairRadii{of_particles, of_targets, PairSupport::larger}}) {
        options.neighbours = rule;
        const BasicReconstruction<Scalar> pairs(points_of(clouds.points), points_of(clouds.targets),
                                                options);
        EXPECT_EQ(numbers_of(pairs.values()), numbers_of(one.values()));
        EXPECT_EQ(numbers_of(pairs.gradient()), numbers_of(one.gradient()));
        EXPECT_EQ(numbers_of(pairs.hessian()), numbers_of(one.hessian()));
      }
    }
}

// Shepard's formula, written out: sum_p w(|x - x_p| / h_p) u_p / sum_p w(|x - x_p| / h_p).
TYPED_TEST(PairSupports, OfDegreeZeroAreShepardsFormula) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Clouds<Scalar, D> clouds;
  const auto radii = radii_between(clouds.points.size(), 0.5 * clouds.length, 2 * clouds.length, 3);
  const auto u = smooth_field<Scalar, D>(clouds.points);
  const auto at_targets =
      reconstruct(points_of(clouds.points), points_of(clouds.targets),
                  {.degree = 0, .weight = Weight::wendland_c2, .neighbours = PairRadii{radii}})
          .apply(field_of(u));
  const WeightFunction weight = Weight::wendland_c2;
  for (std::size_t t = 0; t < clouds.targets.size(); ++t) {
    double sum = 0, weights = 0;
    for (std::size_t p = 0; p < clouds.points.size(); ++p) {
      double distance = 0;
      for (int d = 0; d < D; ++d)
        distance =
            std::hypot(distance, static_cast<double>(clouds.points[p][d]) - clouds.targets[t][d]);
      const double q = distance / radii[p];
      double w = 0;
      weight.evaluate(&q, &w, nullptr, 1);
      sum += w * u[p];
      weights += w;
    }
    if (weights < 1e-3) continue;
    EXPECT_NEAR(at_targets(static_cast<Eigen::Index>(t), 0), sum / weights, 200 * TypeParam::eps)
        << "target " << t;
  }
}

template <class C>
class PairSupportGradient : public ::testing::Test {};
TYPED_TEST_SUITE(PairSupportGradient, DoubleCases, CaseNames);

TYPED_TEST(PairSupportGradient, EqualsFiniteDifferences) {
  constexpr int D = TypeParam::D;
  const Clouds<double, D> clouds;
  const auto of_particles =
      radii_between(clouds.points.size(), clouds.length, 2 * clouds.length, 3);
  const auto of_targets = radii_between(clouds.targets.size(), clouds.length, 2 * clouds.length, 4);
  const auto u = smooth_field<double, D>(clouds.points);
  for (const PairSupport support : {PairSupport::particle, PairSupport::mean})
    for (const WeightForm form : all_forms)
      for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt})
        for (const int degree : {0, 1, 2}) {
          PairRadii rule{of_particles, {}, support};
          if (support != PairSupport::particle) rule.targets = of_targets;
          const Options options{.degree = degree,
                                .weight = Weight::wendland_c4,
                                .form = form,
                                .neighbours = rule,
                                .solver = solver};
          const auto at = [&](const PointList<double, D>& x) {
            return reconstruct(points_of(clouds.points), points_of(x), options);
          };
          expect_derivative<D>(
              at(clouds.targets).gradient().apply(field_of(u)), clouds.targets,
              [&](const PointList<double, D>& x) { return at(x).apply(field_of(u)); }, 1e-5,
              std::string(name_of(solver)) + ", degree " + std::to_string(degree));
        }
}

// With w_ij = w_ji the matrix of weights of particles among themselves is symmetric: a sees b
// exactly where b sees a. With the radius of the particle alone it is not.
TEST(PairSupportPattern, IsSymmetricWhereTheRadiusIs) {
  const auto points = random_points<double, 2>(200, 9);
  const auto radii = radii_between(200, 0.05, 0.3, 10);
  for (const PairSupport support :
       {PairSupport::mean, PairSupport::larger, PairSupport::particle}) {
    PairRadii rule{radii, {}, support};
    if (support != PairSupport::particle) rule.targets = radii;
    const auto list =
        reconstruct(points_of(points), points_of(points), {.degree = 0, .neighbours = rule})
            .neighbours();
    std::vector<std::vector<double>> support_of(200, std::vector<double>(200, 0));
    for (std::size_t t = 0; t < 200; ++t)
      for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e)
        support_of[t][list.indices[e]] = list.pair_support[e];
    bool symmetric = true;
    for (std::size_t a = 0; a < 200; ++a)
      for (std::size_t b = 0; b < 200; ++b) symmetric &= support_of[a][b] == support_of[b][a];
    EXPECT_EQ(symmetric, support != PairSupport::particle);
  }
}

// Sources in their own order, a periodic domain, updates with and without a new rule, supports that
// grow, targets that are too far: as one call with everything new.
TEST(PairSupportPattern, HoldsWhateverElseIsAsked) {
  auto points = random_points<double, 2>(2000, 11);
  const auto targets = random_points<double, 2>(1500, 12);
  const auto radii = radii_between(2000, 0.02, 0.08, 13),
             larger = radii_between(2000, 0.05, 0.1, 14);
  PeriodicDomain<double> box;
  box.periodic = {true, false, false};
  box.upper = {1, 1, 1};
  Options options{.degree = 1, .neighbours = PairRadii{radii}};
  options.grow = {.steps = 4};
  options.max_distance = 3;
  const auto expect_same = [](const Reconstruction& a, const Reconstruction& b) {
    EXPECT_EQ(numbers_of(a.values()), numbers_of(b.values()));
    for (std::size_t t = 0; t < a.report().size(); ++t) EXPECT_EQ(a.report()[t], b.report()[t]);
  };
  Sources sources(points_of(points), {.domain = box});
  Reconstruction fit = reconstruct(sources, points_of(targets), options);
  EXPECT_EQ(fit.report().summary().full, targets.size());
  Options alone = options;
  alone.domain = box;
  expect_same(fit, reconstruct(points_of(points), points_of(targets), alone));

  for (auto& x : points) x[1] = x[1] * x[1];
  sources.update(points_of(points));
  fit.update(points_of(targets));
  expect_same(fit, reconstruct(points_of(points), points_of(targets), alone));
  alone.neighbours = PairRadii{larger};
  fit.update(points_of(targets), PairRadii{larger});
  expect_same(fit, reconstruct(points_of(points), points_of(targets), alone));
  alone.neighbours = Radius{0.1};
  fit.update(points_of(targets), Radius{0.1});
  expect_same(fit, reconstruct(points_of(points), points_of(targets), alone));

  const std::vector<double> few(1999, 0.1);
  EXPECT_NE(message_of([&] {
              fit.update(points_of(targets), PairRadii{few});
            }).find("number of radii of particles = 1999"),
            std::string::npos);
  expect_same(fit, reconstruct(points_of(points), points_of(targets), alone));
}

// With a radius for each particle the integral over all space is the sum of the amounts: here over
// nodes so close that the smallest kernel spans thirty of them.
TEST(PairSupportSums, IntegrateToTheAmounts) {
  const auto points = random_points<double, 2>(40, 21);
  const auto radii = radii_between(40, 0.15, 0.6, 22), mass = radii_between(40, 0.5, 2, 23);
  StructuredGrid<double> grid;
  grid.dimension = 2;
  grid.counts = {230, 230, 1};
  grid.spacing = {0.01, 0.01, 1};
  grid.origin = {-0.65, -0.65, 0};
  const auto nodes = grid.nodes();
  const Sources sources(points_of(points));
  double whole = 0;
  for (const double m : mass) whole += m;
  for (const WeightForm form : all_forms) {
    const auto density =
        kernel_operator<double>(sources, nodes.view(), {.form = form, .support = PairRadii{radii}})
            .apply(field_of(mass));
    EXPECT_NEAR(density.sum() * 1e-4, whole, 1e-4 * whole);
  }
}

// Searches among Sources speak of the caller's particles, as those among points do.
TEST(PairSupportSums, SourcesHaveTheNumbersOfTheCaller) {
  const auto points = random_points<double, 3>(500, 24);
  const auto radii = radii_between(500, 0.05, 0.4, 25);
  const Sources sources(points_of(points));
  const NeighbourRule rule = PairRadii{radii};
  const auto by_sources = find_neighbours(sources, points_of(points), rule);
  const auto cloud = cloud_of(points);
  const auto by_points = find_neighbours(cloud, cloud, rule);
  ASSERT_EQ(by_sources.indices.size(), by_points.indices.size());
  for (std::size_t t = 0; t < 500; ++t) {
    std::vector<std::pair<ParticleIndex, double>> a, b;
    for (std::int64_t e = by_sources.offsets[t]; e < by_sources.offsets[t + 1]; ++e)
      a.push_back({by_sources.indices[e], by_sources.pair_support[e]});
    for (std::int64_t e = by_points.offsets[t]; e < by_points.offsets[t + 1]; ++e)
      b.push_back({by_points.indices[e], by_points.pair_support[e]});
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    EXPECT_EQ(a, b);
    for (const auto& [particle, support] : a) EXPECT_EQ(support, radii[particle]);
  }
}

// A reconstruction hands out the list that it has made, with the radius of each pair, and takes it back.
TEST(PairSupports, AListThatIsHandedOutGivesTheSameFit) {
  const auto points = random_points<double, 2>(900, 1), targets = random_points<double, 2>(700, 2);
  std::vector<double> radii(points.size());
  for (std::size_t p = 0; p < radii.size(); ++p) radii[p] = 0.1 + 0.05 * static_cast<double>(p % 3);
  const auto fit =
      reconstruct(points_of(points), points_of(targets), {.neighbours = PairRadii{radii}});
  const NeighbourList<double> list = fit.neighbours();
  ASSERT_EQ(list.pair_support.size(), list.indices.size());
  for (std::size_t e = 0; e < list.indices.size(); ++e)
    EXPECT_EQ(list.pair_support[e], radii[list.indices[e]]);
  const auto again = reconstruct(points_of(points), points_of(targets), list);
  EXPECT_LT((again.apply(field_of(points)) - fit.apply(field_of(points))).cwiseAbs().maxCoeff(),
            1e-12);
}

}  // namespace
}  // namespace recon::testing
