// Fits and sums whose supports are ellipsoids of any orientation, of targets or of pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "recon/operators/kernel_sum.hpp"
#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/derivative.hpp"
#include "support/invariants.hpp"
#include "support/message_of.hpp"
#include "support/solvers.hpp"
#include "support/tensors.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

using Eigen::MatrixXd;
using F = Functional;

template <class Scalar, int D>
struct Clouds {
  PointList<Scalar, D> points = random_points<Scalar, D>(300, 1);
  PointList<Scalar, D> targets = random_points<Scalar, D>(60, 2);
  double length = D == 1 ? 0.05 : D == 2 ? 0.15 : 0.3;
  std::vector<Matrix<D>> of_points = random_tensors<D>(300, length, 3 * length, 3);
  std::vector<Matrix<D>> of_targets = random_tensors<D>(60, length, 3 * length, 4);

  std::vector<std::pair<std::string, NeighbourRule>> rules() const {
    return {{"targets", Ellipsoids{field_of(of_targets)}},
            {"particles", PairEllipsoids{field_of(of_points)}},
            {"mean", PairEllipsoids{field_of(of_points), field_of(of_targets), PairSupport::mean}}};
  }
};

bool of_pairs(const NeighbourRule& rule) {
  return std::holds_alternative<PairEllipsoids>(rule);
}

template <class C>
class EllipsoidSupports : public ::testing::Test {};
TYPED_TEST_SUITE(EllipsoidSupports, AllCases, CaseNames);

TYPED_TEST(EllipsoidSupports, ReproducePolynomials) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Clouds<Scalar, D> clouds;
  for (const auto& [name, rule] : clouds.rules())
    for (const WeightForm form : all_forms)
      for (const Solver solver : all_solvers)
        for (int degree = 0; degree <= 2; ++degree) {
          if (form == WeightForm::tensor_product && of_pairs(rule)) continue;
          const Options options{
              .degree = degree, .form = form, .neighbours = rule, .solver = solver};
          const BasicReconstruction<Scalar> fit(points_of(clouds.points), points_of(clouds.targets),
                                                options);
          EXPECT_GT(fit.report().summary().full, 9 * clouds.targets.size() / 10);
          expect_reproduction<Scalar, D>(
              fit, clouds.points, clouds.targets, degree,
              name + ", " + std::string(name_of(solver)) + ", degree " + std::to_string(degree));
          if (::testing::Test::HasFailure()) return;
        }
}

// On lines, sheets, clusters and copies, beside them and far away.
TYPED_TEST(EllipsoidSupports, SurviveHostileClouds) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& [name, points] : hostile_clouds<Scalar, D>()) {
    const auto targets = hostile_targets<Scalar, D>(points);
    const auto of_points = random_tensors<D>(points.size(), 0.02, 0.8, 3),
               of_targets = random_tensors<D>(targets.size(), 0.02, 0.8, 4);
    for (const NeighbourRule& rule : {NeighbourRule(Ellipsoids{field_of(of_targets)}),
                                      NeighbourRule(PairEllipsoids{field_of(of_points)})})
      for (const Solver solver : all_solvers)
        for (const int degree : {0, 1, 2}) {
          const BasicReconstruction<Scalar> fit(
              points_of(points), points_of(targets),
              {.degree = degree, .neighbours = rule, .solver = solver});
          expect_reproduction<Scalar, D>(fit, points, targets, degree,
                                         name + ", " + std::string(name_of(solver)));
          for (const Scalar number : numbers_of(fit.gradient())) ASSERT_TRUE(std::isfinite(number));
          for (const Scalar number : numbers_of(fit.hessian())) ASSERT_TRUE(std::isfinite(number));
          if (::testing::Test::HasFailure()) return;
        }
  }
}

template <class Scalar>
void expect_near(const std::vector<Scalar>& a, const std::vector<Scalar>& b, double tolerance,
                 const std::string& where) {
  ASSERT_EQ(a.size(), b.size()) << where;
  double largest = 0;
  for (const Scalar number : b) largest = std::max(largest, std::abs(static_cast<double>(number)));
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_NEAR(a[i], b[i], tolerance * largest) << where << ", number " << i;
}

// A tensor diag(a, b, c) rho for all is the radius rho with the stretch {a, b, c}.
TYPED_TEST(EllipsoidSupports, ThatAreDiagonalAreAStretch) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Clouds<Scalar, D> clouds;
  const std::array<double, 3> stretch{1.5, 0.75, 1.125};
  const double rho = 2 * clouds.length;
  Matrix<D> tensor = Matrix<D>::Zero();
  for (int d = 0; d < D; ++d) tensor(d, d) = stretch[d] * rho;
  const std::vector<Matrix<D>> of_targets(clouds.targets.size(), tensor),
      of_points(clouds.points.size(), tensor);
  for (const WeightForm form : all_forms)
    for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt, Solver::qr})
      for (const int degree : {1, 2}) {
        const BasicReconstruction<Scalar> stretched(points_of(clouds.points),
                                                    points_of(clouds.targets),
                                                    {.degree = degree,
                                                     .form = form,
                                                     .neighbours = Radius{rho},
                                                     .solver = solver,
                                                     .stretch = stretch});
        for (const NeighbourRule& rule :
             {NeighbourRule(Ellipsoids{field_of(of_targets)}),
              NeighbourRule(PairEllipsoids{field_of(of_points)}),
              NeighbourRule(
                  PairEllipsoids{field_of(of_points), field_of(of_targets), PairSupport::mean})}) {
          if (form == WeightForm::tensor_product && of_pairs(rule)) continue;
          const BasicReconstruction<Scalar> fit(
              points_of(clouds.points), points_of(clouds.targets),
              {.degree = degree, .form = form, .neighbours = rule, .solver = solver});
          const auto a = fit.neighbours(), b = stretched.neighbours();
          ASSERT_EQ(a.offsets, b.offsets);
          for (std::size_t t = 0; t < clouds.targets.size(); ++t) {
            std::vector<ParticleIndex> ours(a.of(t).begin(), a.of(t).end()),
                theirs(b.of(t).begin(), b.of(t).end());
            std::sort(ours.begin(), ours.end());
            std::sort(theirs.begin(), theirs.end());
            ASSERT_EQ(ours, theirs);
            EXPECT_EQ(fit.report()[t].status, stretched.report()[t].status);
          }
          // Rows are in the order of the caller's particles in both.
          const std::string where = std::string(name_of(solver)) + std::to_string(degree);
          const std::vector<Scalar> field = smooth_field<Scalar, D>(clouds.points);
          const auto numbers = [&](const CsrOperator<Scalar>& op) {
            const auto result = op.apply(field_of(field));
            return std::vector<Scalar>(result.data(), result.data() + result.size());
          };
          const double tolerance = 3e5 * TypeParam::eps;
          expect_near(numbers(fit.values()), numbers(stretched.values()), tolerance, where);
          expect_near(numbers(fit.gradient()), numbers(stretched.gradient()), tolerance, where);
          expect_near(numbers(fit.gradient(Derivative::diffuse)),
                      numbers(stretched.gradient(Derivative::diffuse)), tolerance, where);
          expect_near(numbers(fit.hessian()), numbers(stretched.hessian()), 10 * tolerance, where);
        }
      }
}

// sum_t f_t (L u)_t = sum_p (L^T f)_p u_p.
TYPED_TEST(EllipsoidSupports, AreAdjoint) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Clouds<Scalar, D> clouds;
  const auto u = smooth_field<Scalar, D>(clouds.points),
             f = smooth_field<Scalar, D>(clouds.targets);
  for (const auto& [name, rule] : clouds.rules()) {
    const BasicReconstruction<Scalar> fit(points_of(clouds.points), points_of(clouds.targets),
                                          {.degree = 1, .neighbours = rule});
    const auto [value, gradient] = fit.operators(F::value, F::gradient);
    const auto along = fit.apply(field_of(u)), slopes = gradient.apply(field_of(u));
    const auto back = value.apply_transpose(field_of(f));
    typename CsrOperator<Scalar>::Matrix g(static_cast<Eigen::Index>(f.size()), D);
    double there = 0, back_again = 0, size = 0;
    for (std::size_t t = 0; t < f.size(); ++t) {
      there += static_cast<double>(f[t]) * along(t, 0);
      for (int d = 0; d < D; ++d) {
        g(t, d) = f[t] * static_cast<Scalar>(d + 1);
        there += static_cast<double>(g(t, d)) * slopes(t, d);
        size += std::abs(static_cast<double>(g(t, d)) * slopes(t, d));
      }
    }
    const auto slopes_back = gradient.apply_transpose(field_of(g));
    for (std::size_t p = 0; p < u.size(); ++p)
      back_again += static_cast<double>(u[p]) * (back(p, 0) + slopes_back(p, 0));
    EXPECT_NEAR(there, back_again, 1000 * TypeParam::eps * size) << name;
  }
}

template <class C>
class EllipsoidGradient : public ::testing::Test {};
TYPED_TEST_SUITE(EllipsoidGradient, DoubleCases, CaseNames);

// The supports stand still with the target: of a moved target they are the same tensors.
TYPED_TEST(EllipsoidGradient, EqualsFiniteDifferences) {
  constexpr int D = TypeParam::D;
  const Clouds<double, D> clouds;
  const auto u = smooth_field<double, D>(clouds.points);
  PointList<double, D> targets;
  for (auto x : clouds.targets) {
    for (double& c : x) c = 0.1 + 0.8 * c;
    targets.push_back(x);
  }
  PeriodicDomain<double> periodic;
  for (int d = 0; d < D; ++d) {
    periodic.upper[d] = 1;
    periodic.periodic[d] = d != 1;
  }
  for (const auto& [name, rule] : clouds.rules())
    for (const WeightForm form : all_forms)
      for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt, Solver::qr})
        for (const int degree : {0, 1, 2})
          for (const bool around : {false, true}) {
            if (form == WeightForm::tensor_product && of_pairs(rule)) continue;
            if (around && degree != 1) continue;
            Options options{.degree = degree,
                            .weight = Weight::wendland_c4,
                            .form = form,
                            .neighbours = rule,
                            .solver = solver,
                            .stretch = {1.25, 1, 0.8}};
            if (around) options.domain = periodic;
            const auto at = [&](const PointList<double, D>& x) {
              return reconstruct(points_of(clouds.points), points_of(x), options);
            };
            expect_derivative<D>(
                at(targets).gradient().apply(field_of(u)), targets,
                [&](const PointList<double, D>& x) { return at(x).apply(field_of(u)); }, 1e-5,
                name + ", " + std::string(name_of(solver)) + ", degree " + std::to_string(degree));
          }
}

// A cubic, its derivatives of both kinds, averages and derivatives beyond the second.
TYPED_TEST(EllipsoidGradient, IsExactOnPolynomials) {
  constexpr int D = TypeParam::D;
  const auto points = random_points<double, D>(D == 3 ? 3000 : 600, 1),
             targets = random_points<double, D>(30, 2);
  const double length = D == 1 ? 0.1 : D == 2 ? 0.25 : 0.4;
  const auto of_points = random_tensors<D>(points.size(), length, 2 * length, 3),
             of_targets = random_tensors<D>(30, length, 2 * length, 4);
  constexpr int last = D - 1;
  const auto f = [](const std::array<double, D>& x) {
    return 1 + x[0] - x[last] + x[0] * x[0] - 3 * x[0] * x[last] + 2 * std::pow(x[last], 3);
  };
  std::vector<double> u;
  for (const auto& x : points) u.push_back(f(x));
  for (const NeighbourRule& rule : {NeighbourRule(Ellipsoids{field_of(of_targets)}),
                                    NeighbourRule(PairEllipsoids{field_of(of_points)})})
    for (const Solver solver : {Solver::gram_schmidt, Solver::qr}) {
      const auto fit = reconstruct(
          points_of(points), points_of(targets),
          {.degree = 3, .neighbours = rule, .solver = solver, .stretch = {1.2, 1, 0.9}});
      ASSERT_EQ(fit.report().summary().full, targets.size());
      std::array<double, 3> edges{0.2, 0.1, 0.3}, by{0.1, -0.2, 0.05};
      for (int d = D; d < 3; ++d) edges[d] = by[d] = 0;
      const auto [exact, diffuse, hessian, average, third, beside] = fit.operators(
          F::gradient, F::gradient.with(Derivative::diffuse), F::hessian, F::cell_average(edges),
          D == 1   ? F::partial(3)
          : D == 2 ? F::partial(0, 3)
                   : F::partial(0, 0, 3),
          F::gradient.at({by}));
      const auto gradient = [&](const std::array<double, D>& x) {
        std::array<double, D> g{};
        g[0] += 1 + 2 * x[0] - 3 * x[last];
        g[last] += -1 - 3 * x[0] + 6 * x[last] * x[last];
        return g;
      };
      for (std::size_t t = 0; t < targets.size(); ++t) {
        const auto& x = targets[t];
        const auto g = gradient(x);
        auto moved = x;
        for (int d = 0; d < D; ++d) moved[d] += by[d];
        const auto g_beside = gradient(moved);
        for (int d = 0; d < D; ++d) {
          EXPECT_NEAR(exact.apply(field_of(u))(t, d), g[d], 1e-8);
          EXPECT_NEAR(diffuse.apply(field_of(u))(t, d), g[d], 1e-8);
          EXPECT_NEAR(beside.apply(field_of(u))(t, d), g_beside[d], 1e-8);
        }
        MatrixXd second = MatrixXd::Zero(D, D);
        second(0, 0) += 2;
        second(0, last) += -3;
        second(last, 0) += -3;
        second(last, last) += 12 * x[last];
        const auto h = hessian.apply(field_of(u));
        for (int i = 0, n = 0; i < D; ++i)
          for (int j = i; j < D; ++j, ++n) EXPECT_NEAR(h(t, n), second(i, j), 1e-6);
        EXPECT_NEAR(third.apply(field_of(u))(t, 0), 12, 1e-5);
        // The mean of s^2 over an edge e is e^2 / 12, that of s_0 s_last between axes 0.
        const double e0 = edges[0] * edges[0] / 12, el = edges[last] * edges[last] / 12;
        EXPECT_NEAR(average.apply(field_of(u))(t, 0),
                    f(x) + e0 + (D == 1 ? -3 * e0 : 0) + 6 * x[last] * el, 1e-9);
      }
    }
}

// x -> M x of points, targets and ellipsoids leaves q, and with it the shape functions, as they
// are; gradients become M^-T times theirs.
TYPED_TEST(EllipsoidGradient, FollowsALinearMap) {
  constexpr int D = TypeParam::D;
  const Clouds<double, D> clouds;
  RandomNumbers random(11);
  const Matrix<D> rotation = random_rotation<D>(random);
  Matrix<D> shear = Matrix<D>::Identity() * 0.3;
  shear(0, D - 1) += 4;
  for (const bool rotate : {true, false}) {
    const Matrix<D> map = rotate ? rotation : shear;
    Clouds<double, D> mapped = clouds;
    mapped.points = mapped_points<D>(clouds.points, map);
    mapped.targets = mapped_points<D>(clouds.targets, map);
    mapped.of_points = mapped_tensors<D>(clouds.of_points, map);
    mapped.of_targets = mapped_tensors<D>(clouds.of_targets, map);
    const auto rules = clouds.rules(), mapped_rules = mapped.rules();
    for (std::size_t r = 0; r < rules.size(); ++r)
      for (const Solver solver : all_solvers)
        for (const int degree : {0, 1, 2}) {
          const std::string where =
              rules[r].first + ", " + std::string(name_of(solver)) + std::to_string(degree);
          // Of a mean of two tensors the map is that of a rotation only.
          if (rules[r].first == "mean" && !rotate) continue;
          Options options{.degree = degree, .neighbours = rules[r].second, .solver = solver};
          const auto before =
              reconstruct(points_of(clouds.points), points_of(clouds.targets), options);
          options.neighbours = mapped_rules[r].second;
          const auto after =
              reconstruct(points_of(mapped.points), points_of(mapped.targets), options);
          const auto u = smooth_field<double, D>(clouds.points);
          const MatrixXd a = before.apply(field_of(u)), b = after.apply(field_of(u));
          const MatrixXd ga = before.gradient().apply(field_of(u)),
                         gb = after.gradient().apply(field_of(u)) * map;
          std::size_t compared = 0;
          for (std::size_t t = 0; t < clouds.targets.size(); ++t) {
            if (before.report()[t].status != FitStatus::full) continue;
            ++compared;
            EXPECT_EQ(after.report()[t].status, FitStatus::full) << where;
            EXPECT_EQ(after.report()[t].neighbours, before.report()[t].neighbours) << where;
            const double margin = 1e-10 * std::max(1.0f, before.report()[t].amplification) /
                                  std::max(1e-4f, before.report()[t].smallest_pivot);
            EXPECT_NEAR(a(t, 0), b(t, 0), margin) << where << ", target " << t;
            for (int d = 0; d < D; ++d)
              EXPECT_NEAR(ga(t, d), gb(t, d), 100 * margin * (1 + std::abs(ga(t, d))))
                  << where << ", target " << t;
          }
          EXPECT_GT(compared, 50u);
        }
  }
}

// A cloud of layers, 1 wide along a diagonal of the plane and 1/50 across, with a field that varies
// as fast across as the layers allow. A ball that holds enough particles reaches over so many
// layers that the field is lost; ellipsoids along the layers see it.
TEST(EllipsoidsOnLayers, ResolveWhatBallsDoNot) {
  const double thin = 1.0 / 50, angle = 0.5;
  Matrix<2> axes;
  axes << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const Matrix<2> layers = axes * Eigen::Vector2d(1, thin).asDiagonal();
  const auto reference = jittered_points<double, 2>(60, 0.3, 1);
  auto inner = random_points<double, 2>(300, 2);
  for (auto& x : inner)
    for (double& c : x) c = 0.1 + 0.8 * c;
  const auto points = mapped_points<2>(reference, layers),
             targets = mapped_points<2>(inner, layers);
  const auto field = [&](const std::array<double, 2>& x) {
    return std::sin(20 * x[1]) + std::cos(5 * x[0]);
  };
  std::vector<double> u, expected;
  for (const auto& x : reference) u.push_back(field(x));
  for (const auto& x : inner) expected.push_back(field(x));
  const auto error_of = [&](const Reconstruction& fit) {
    const MatrixXd values = fit.apply(field_of(u));
    double largest = 0;
    for (std::size_t t = 0; t < targets.size(); ++t)
      largest = std::max(largest, std::abs(values(t, 0) - expected[t]));
    return largest;
  };
  const Matrix<2> tensor =
      3.0 / 60 * (axes * Eigen::Vector2d(1, thin).asDiagonal() * axes.transpose());
  const std::vector<Matrix<2>> of_targets(targets.size(), tensor), of_points(points.size(), tensor);
  const auto by = [&](const NeighbourRule& rule) {
    return reconstruct(points_of(points), points_of(targets), {.degree = 1, .neighbours = rule});
  };
  const Reconstruction ellipsoids = by(Ellipsoids{field_of(of_targets)});
  const Reconstruction of_particles = by(PairEllipsoids{field_of(of_points)});
  EXPECT_EQ(ellipsoids.report().summary().full, targets.size());
  EXPECT_EQ(of_particles.report().summary().full, targets.size());
  // As many neighbours, about 28, in a ball.
  const Reconstruction nearest = by(Nearest{28});
  EXPECT_LT(error_of(ellipsoids), 0.05);
  EXPECT_LT(error_of(of_particles), 0.05);
  EXPECT_GT(error_of(nearest), 10 * error_of(ellipsoids));
  ::testing::Test::RecordProperty("error_of_ellipsoids", std::to_string(error_of(ellipsoids)));
  ::testing::Test::RecordProperty("error_of_the_nearest", std::to_string(error_of(nearest)));
}

// However thin the layers are, ellipsoids that are as thin see what they see where they are thick.
TEST(EllipsoidsOnLayers, SeeThinOnesAsThickOnes) {
  const auto reference = jittered_points<double, 2>(60, 0.3, 1);
  const auto inner = random_points<double, 2>(300, 2);
  const auto u = smooth_field<double, 2>(reference);
  RandomNumbers random(3);
  const Matrix<2> axes = random_rotation<2>(random);
  const auto values = [&](double thin, Solver solver) {
    const Matrix<2> layers = axes * Eigen::Vector2d(1, thin).asDiagonal();
    const Matrix<2> tensor = 3.5 / 60 * (layers * axes.transpose());
    const std::vector<Matrix<2>> tensors(reference.size(), (tensor + tensor.transpose()) / 2);
    const auto points = mapped_points<2>(reference, layers), at = mapped_points<2>(inner, layers);
    const auto fit = reconstruct(
        points_of(points), points_of(at),
        {.degree = 2, .neighbours = PairEllipsoids{field_of(tensors)}, .solver = solver});
    EXPECT_EQ(fit.report().summary().full, at.size());
    return fit.apply(field_of(u));
  };
  for (const Solver solver : all_solvers) {
    const MatrixXd thick = values(1, solver);
    EXPECT_LT((values(1e-2, solver) - thick).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((values(1e-4, solver) - thick).cwiseAbs().maxCoeff(), 1e-6);
  }
}

// Coordinates are rounded. What that moves particles by, across a line on which they lie, is no
// extent, however thin the ellipsoid is there.
TEST(EllipsoidsOnLayers, RoundingIsNoExtent) {
  PointList<double, 2> points;
  std::vector<double> u;
  for (const auto& s : random_points<double, 1>(300, 1)) {
    points.push_back({1000 + s[0], 1000 + 0.37 * s[0]});
    u.push_back(s[0]);
  }
  Matrix<2> axes;
  axes << 1, -0.37, 0.37, 1;
  axes /= std::hypot(1, 0.37);
  const Matrix<2> tensor = axes * Eigen::Vector2d(0.1, 2e-6).asDiagonal() * axes.transpose();
  const std::vector<Matrix<2>> tensors(300, tensor);
  for (const NeighbourRule& rule : {NeighbourRule(Ellipsoids{field_of(tensors)}),
                                    NeighbourRule(PairEllipsoids{field_of(tensors)})})
    for (const Solver solver : all_solvers) {
      const auto fit = reconstruct(points_of(points), points_of(points),
                                   {.degree = 1, .neighbours = rule, .solver = solver});
      const MatrixXd gradient = fit.gradient().apply(field_of(u));
      for (std::size_t t = 0; t < points.size(); ++t) {
        EXPECT_EQ(fit.report()[t].rank, 2) << name_of(solver);
        EXPECT_EQ(fit.report()[t].gradient_rank, 1);
        // Along the line; across it is 0, but for the direction of the line: in the coordinates of
        // the ellipsoid rounding by 1e-13 turns it by 1e-13 / 2e-6, and across it slopes are those
        // coordinates' times the ratio of the half axes.
        const double turned = 1e-13 / 2e-6 * (0.1 / 2e-6);
        const Eigen::Vector2d slope = axes.transpose() * gradient.row(t).transpose();
        EXPECT_NEAR(slope[0], 1 / std::hypot(1, 0.37), 1e-9);
        EXPECT_NEAR(slope[1], 0, turned);
      }
    }
}

void expect_same_bits(const Reconstruction& a, const Reconstruction& b, const std::string& where) {
  EXPECT_EQ(numbers_of(a.values()), numbers_of(b.values())) << where;
  EXPECT_EQ(numbers_of(a.gradient()), numbers_of(b.gradient())) << where;
  for (std::size_t t = 0; t < a.report().size(); ++t)
    EXPECT_EQ(a.report()[t], b.report()[t]) << where;
}

// Sources in their own order, a periodic domain, updates with and without new tensors, supports
// that grow, targets that are too far or have the nearest: as one call with everything new, with
// any number of threads and by any search.
TEST(EllipsoidPattern, HoldsWhateverElseIsAsked) {
  auto points = random_points<double, 2>(2000, 11);
  const auto targets = random_points<double, 2>(1500, 12);
  const auto of_points = random_tensors<2>(2000, 0.02, 0.08, 13),
             of_targets = random_tensors<2>(1500, 0.02, 0.08, 14),
             larger = random_tensors<2>(2000, 0.05, 0.1, 15);
  PeriodicDomain<double> box;
  box.periodic = {true, false, false};
  box.upper = {1, 1, 1};
  const std::vector<NeighbourRule> rules{
      Ellipsoids{field_of(of_targets)}, PairEllipsoids{field_of(of_points)},
      PairEllipsoids{field_of(of_points), field_of(of_targets), PairSupport::mean}};
  for (std::size_t r = 0; r < rules.size(); ++r) {
    const std::string where = "rule " + std::to_string(r);
    points = random_points<double, 2>(2000, 11);
    Options options{.degree = 1, .neighbours = rules[r]};
    options.grow = {.steps = 2};
    options.max_distance = 3;
    options.unsupported = Unsupported::nearest;
    Sources sources(points_of(points), {.domain = box});
    Reconstruction fit = reconstruct(sources, points_of(targets), options);
    EXPECT_GT(fit.report().summary().full, 9 * targets.size() / 10) << where;
    Options alone = options;
    alone.domain = box;
    const auto anew = [&] { return reconstruct(points_of(points), points_of(targets), alone); };
    expect_same_bits(fit, anew(), where);
    alone.threads = 1;
    expect_same_bits(fit, anew(), where);
    alone.threads = 5;
    expect_same_bits(fit, anew(), where);
    alone.search = SearchMethod::cell_grid;
    expect_same_bits(fit, anew(), where);
    alone.search = SearchMethod::automatic;

    for (auto& x : points) x[1] = x[1] * x[1];
    sources.update(points_of(points));
    fit.update(points_of(targets));
    expect_same_bits(fit, anew(), where + ", moved");
    alone.neighbours = PairEllipsoids{field_of(larger)};
    const Reconstruction copy = fit;
    fit.update(points_of(targets), *alone.neighbours);
    expect_same_bits(fit, anew(), where + ", larger");
    fit.update(points_of(targets));
    expect_same_bits(fit, anew(), where + ", larger again");
    alone.neighbours = Radius{0.1};
    fit.update(points_of(targets), Radius{0.1});
    expect_same_bits(fit, anew(), where + ", a radius");
    alone.neighbours = rules[r];
    fit.update(points_of(targets), rules[r]);
    expect_same_bits(fit, anew(), where + ", back");
    expect_same_bits(fit, copy, where + ", the copy");

    auto bad = of_points;
    bad[5](0, 0) = -1;
    EXPECT_NE(message_of([&] {
                fit.update(points_of(targets), PairEllipsoids{field_of(bad)});
              }).find("eigenvalue of the support tensor of particle 5"),
              std::string::npos);
    expect_same_bits(fit, copy, where + ", nothing changed");
  }
}

// Targets without any particle in their ellipsoid have the value of the nearest one, or grow until
// there are enough.
TEST(EllipsoidPattern, EmptySupportsAreHelped) {
  const auto points = regular_points<double, 2>(20);
  const auto targets = random_points<double, 2>(600, 5);
  const auto tiny = random_tensors<2>(600, 0.002, 0.01, 6);
  const auto u = smooth_field<double, 2>(points);
  Options options{.degree = 1, .neighbours = Ellipsoids{field_of(tiny)}};
  const auto alone = reconstruct(points_of(points), points_of(targets), options);
  EXPECT_GT(alone.report().summary().no_support, 500u);
  options.unsupported = Unsupported::nearest;
  const auto nearest = reconstruct(points_of(points), points_of(targets), options);
  EXPECT_EQ(nearest.report().summary().no_support, 0u);
  const auto list = nearest.neighbours();
  list.validate(600, 400);
  const MatrixXd slopes = nearest.gradient().apply(field_of(u));
  for (std::size_t t = 0; t < 600; ++t)
    if (nearest.report()[t].status == FitStatus::nearest) {
      EXPECT_EQ(list.count(t), 1);
      EXPECT_EQ(slopes(t, 0), 0);
    }
  options.grow = {.steps = 20};
  const auto grown = reconstruct(points_of(points), points_of(targets), options);
  EXPECT_EQ(grown.report().summary().full, targets.size());
  EXPECT_LT((grown.apply(field_of(u)).col(0) -
             Eigen::Map<const Eigen::VectorXd>(smooth_field<double, 2>(targets).data(), 600))
                .cwiseAbs()
                .maxCoeff(),
            0.2);
  grown.neighbours().validate(600, 400);
}

// The list of a fit says all that its weights are made of: given back, it makes the same fit.
TEST(EllipsoidPattern, IsAListOfOnesOwn) {
  const auto points = random_points<double, 3>(1200, 21),
             targets = random_points<double, 3>(700, 22);
  const auto of_points = random_tensors<3>(1200, 0.15, 0.4, 23),
             of_targets = random_tensors<3>(700, 0.15, 0.4, 24);
  std::vector<double> radii;
  for (const auto& x : random_points<double, 1>(1200, 25)) radii.push_back(0.2 + 0.2 * x[0]);
  for (const NeighbourRule& rule :
       {NeighbourRule(Ellipsoids{field_of(of_targets)}),
        NeighbourRule(PairEllipsoids{field_of(of_points)}),
        NeighbourRule(PairEllipsoids{field_of(of_points), field_of(of_targets), PairSupport::mean}),
        NeighbourRule(PairRadii{radii})}) {
    const Options options{.degree = 1, .neighbours = rule};
    const auto fit = reconstruct(points_of(points), points_of(targets), options);
    const auto again =
        reconstruct(points_of(points), points_of(targets), fit.neighbours(), options);
    EXPECT_EQ(numbers_of(again.values()), numbers_of(fit.values()));
    EXPECT_EQ(numbers_of(again.gradient()), numbers_of(fit.gradient()));
    EXPECT_EQ(numbers_of(again.hessian()), numbers_of(fit.hessian()));
  }
  NeighbourList<double> list = reconstruct(points_of(points), points_of(targets),
                                           {.neighbours = PairEllipsoids{field_of(of_points)}})
                                   .neighbours();
  // Without tensors of the targets the unit of length is the same along all axes.
  const auto fit = reconstruct(points_of(points), points_of(targets), list);
  NeighbourList<double> plain = list;
  plain.tensor.clear();
  const auto in_balls = reconstruct(points_of(points), points_of(targets), plain);
  EXPECT_EQ(fit.report().summary().full, in_balls.report().summary().full);
  expect_near(numbers_of(in_balls.values()), numbers_of(fit.values()), 1e-11, "values");
  expect_near(numbers_of(in_balls.gradient()), numbers_of(fit.gradient()), 1e-11, "gradient");
  EXPECT_NE(message_of([&] {
              reconstruct(points_of(points), points_of(targets), list,
                          {.form = WeightForm::tensor_product});
            }).find("form = tensor_product: must be radial"),
            std::string::npos);
  list.pair_tensor.assign(list.indices.size(), 1.0);
  list.tensor.clear();
  EXPECT_NE(message_of([&] {
              reconstruct(points_of(points), points_of(targets), list);
            }).find("numbers in the tensors of pairs"),
            std::string::npos);
}

TEST(EllipsoidPattern, WhatIsWrongIsNamed) {
  const auto points = random_points<double, 2>(100, 1);
  auto tensors = random_tensors<2>(100, 0.1, 0.3, 2);
  const auto message = [&](const Options& options) {
    return message_of([&] { reconstruct(points_of(points), points_of(points), options); });
  };
  const PairEllipsoids pairs{field_of(tensors)};
  EXPECT_NE(message({.form = WeightForm::tensor_product, .neighbours = pairs})
                .find("form = tensor_product: must be radial where pairs have ellipsoids"),
            std::string::npos);
  const auto spatial = random_tensors<3>(100, 0.1, 0.3, 2);
  EXPECT_NE(message({.neighbours = Ellipsoids{field_of(spatial)}})
                .find("components of a support tensor of a target = 9: must be 3 (packed) or 4"),
            std::string::npos);
  tensors[42](0, 1) += 0.5;
  EXPECT_NE(message({.neighbours = Ellipsoids{field_of(tensors)}})
                .find("difference of xy and yx in the support tensor of target 42 = 0.5"),
            std::string::npos);
  const Sources sources(points_of(points));
  EXPECT_NE(message_of([&] {
              kernel_operator<double>(sources, points_of(points), {.support = pairs});
            }).find("difference of xy and yx in the support tensor of particle 42 = 0.5"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              kernel_operator<double>(sources, points_of(points),
                                      {.form = WeightForm::tensor_product, .support = pairs});
            }).find("form = tensor_product"),
            std::string::npos);
}

// The nodes of a grid are targets, too, more of them than are treated at once.
TEST(EllipsoidsOnAGrid, AreThoseOfItsNodes) {
  const auto points = random_points<double, 2>(3000, 1);
  const auto u = smooth_field<double, 2>(points);
  StructuredGrid<double> grid;
  grid.dimension = 2;
  grid.counts = {70, 80, 1};
  grid.spacing = {1.0 / 69, 1.0 / 79, 1};
  const auto of_points = random_tensors<2>(3000, 0.05, 0.15, 2),
             of_nodes = random_tensors<2>(grid.size(), 0.05, 0.15, 3);
  for (const NeighbourRule& rule :
       {NeighbourRule(Ellipsoids{field_of(of_nodes)}),
        NeighbourRule(
            PairEllipsoids{field_of(of_points), field_of(of_nodes), PairSupport::mean})}) {
    const Options options{.degree = 1, .form = WeightForm::radial, .neighbours = rule};
    const MatrixXd on_grid =
        reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options).values();
    const MatrixXd at_nodes = reconstruct(points_of(points), grid, options).apply(field_of(u));
    EXPECT_LT((on_grid - at_nodes).cwiseAbs().maxCoeff(), 1e-11);
  }
}

// With a tensor for each particle the integral over all space is the sum of the amounts; with one
// for all targets it is that of a stretch, in both forms.
TEST(EllipsoidSums, IntegrateToTheAmounts) {
  const auto points = random_points<double, 2>(40, 21);
  const auto tensors = random_tensors<2>(40, 0.15, 0.6, 22);
  std::vector<double> mass;
  for (const auto& x : random_points<double, 1>(40, 23)) mass.push_back(0.5 + x[0]);
  StructuredGrid<double> grid;
  grid.dimension = 2;
  grid.counts = {230, 230, 1};
  grid.spacing = {0.01, 0.01, 1};
  grid.origin = {-0.65, -0.65, 0};
  const auto nodes = grid.nodes();
  const Sources sources(points_of(points));
  double whole = 0;
  for (const double m : mass) whole += m;
  const auto density = [&](const KernelOptions& options) {
    return kernel_operator<double>(sources, nodes.view(), options).apply(field_of(mass));
  };
  EXPECT_NEAR(density({.support = PairEllipsoids{field_of(tensors)}}).sum() * 1e-4, whole,
              2e-4 * whole);

  const std::vector<Matrix<2>> same(grid.size(), tensors[3]), of_particles(40, tensors[3]);
  for (const WeightForm form : all_forms)
    EXPECT_NEAR(density({.form = form, .support = Ellipsoids{field_of(same)}}).sum() * 1e-4, whole,
                2e-4 * whole);
  const MatrixXd mean = density({.support = PairEllipsoids{field_of(of_particles), field_of(same),
                                                           PairSupport::mean}}),
                 one = density({.support = Ellipsoids{field_of(same)}});
  EXPECT_LT((mean - one).cwiseAbs().maxCoeff(), 1e-12 * one.maxCoeff());

  const Matrix<2> diagonal = Eigen::Vector2d(0.2, 0.5).asDiagonal();
  const std::vector<Matrix<2>> straight(grid.size(), diagonal);
  const Sources stretched(points_of(points), {.stretch = {0.2, 0.5, 1}});
  for (const WeightForm form : all_forms) {
    const MatrixXd a = density({.form = form, .support = Ellipsoids{field_of(straight)}}),
                   b = kernel_operator<double>(stretched, nodes.view(),
                                               {.form = form, .support = Radius{1}})
                           .apply(field_of(mass));
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-12 * b.maxCoeff());
  }
}

TEST(EllipsoidSums, DeterminantsOutOfRangeAreNamed) {
  const auto points = random_points<float, 3>(40, 21);
  std::vector<Matrix<3>> tensors(40, Matrix<3>::Identity());
  tensors[7] *= 1e-14;
  const SourcesF sources(points_of(points));
  EXPECT_NE(message_of([&] {
              kernel_operator<float>(sources, points_of(points),
                                     {.support = Ellipsoids{field_of(tensors)}});
            }).find("determinant of the support tensor of target 7 in a kernel sum"),
            std::string::npos);
}

}  // namespace
}  // namespace recon::testing
