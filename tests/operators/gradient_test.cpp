// Gradients: exact ones against finite differences, both kinds against polynomials,
// unresolved directions.
#include <gtest/gtest.h>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/derivative.hpp"
#include "support/invariants.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

template <class C>
class ExactGradient : public ::testing::Test {};
TYPED_TEST_SUITE(ExactGradient, DoubleCases, CaseNames);

// The gradient operator is the derivative of the value operator: through weights, supports that
// move with the neighbours, periodic images, anisotropy, and every solver.
TYPED_TEST(ExactGradient, EqualsFiniteDifferences) {
  constexpr int D = TypeParam::D;
  const auto points = random_points<double, D>(D == 1 ? 80 : 400, 3);
  const auto values = smooth_field<double, D>(points);
  auto targets = random_points<double, D>(15, 5);
  for (auto& x : targets)
    for (double& c : x) c = 0.15 + 0.7 * c;
  PeriodicDomain<double> periodic;
  for (int d = 0; d < D; ++d) {
    periodic.upper[d] = 1;
    periodic.periodic[d] = d != 1;
  }
  const std::size_t k = 3 * monomial_count(D, 2);

  std::vector<std::pair<std::string, Options>> cases;
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt, Solver::qr, Solver::svd})
    for (int degree = 0; degree <= 3; ++degree)
      cases.push_back({std::string(name_of(solver)) + " degree " + std::to_string(degree),
                       {.degree = degree, .neighbours = Radius{0.4}, .solver = solver}});
  for (const Weight weight : all_weights()) {
    if (weight == Weight::linear_b_spline)
      continue;  // has kinks where a finite difference may step over
    cases.push_back({std::string(name_of(weight)), {.weight = weight, .neighbours = Radius{0.4}}});
  }
  const auto tensor = WeightForm::tensor_product;
  cases.push_back({"tensor product", {.degree = 2, .form = tensor, .neighbours = Radius{0.4}}});
  cases.push_back({"nearest", {.degree = 2, .neighbours = Nearest{k}}});
  cases.push_back(
      {"nearest, tensor product", {.degree = 2, .form = tensor, .neighbours = Nearest{k}}});
  cases.push_back({"periodic", {.degree = 1, .neighbours = Radius{0.4}, .domain = periodic}});
  cases.push_back(
      {"stretched", {.degree = 1, .neighbours = Radius{0.4}, .stretch = {1.2, 0.8, 1.1}}});

  for (const auto& each : cases) {
    const Options& options = each.second;
    const auto evaluate = [&](const PointList<double, D>& at) {
      return reconstruct(points_of(points), points_of(at), options).apply(field_of(values));
    };
    const auto gradient = reconstruct(points_of(points), points_of(targets), options)
                              .gradient()
                              .apply(field_of(values));
    // The difference quotient of a function computed to about 1e-14 is good to 1e-8 at this step.
    expect_derivative<D>(gradient, targets, evaluate, 2e-7, each.first);
  }
}

// What a list says about its supports while the target moves: still, or a multiple of the distance
// to the farthest neighbour.
TYPED_TEST(ExactGradient, FollowsWhatTheListSays) {
  constexpr int D = TypeParam::D;
  const auto points = random_points<double, D>(D == 1 ? 80 : 400, 3);
  const auto values = smooth_field<double, D>(points);
  auto targets = random_points<double, D>(15, 5);
  for (auto& x : targets)
    for (double& c : x) c = 0.15 + 0.7 * c;
  const PointCloud<double> particles(points_of(points));
  const Options options{.degree = 1};
  const auto list_at = [&](const PointList<double, D>& at) {
    return find_neighbours(particles, PointCloud<double>(points_of(at)), Nearest{12, 1.5});
  };
  const NeighbourList<double> made = list_at(targets);
  EXPECT_EQ(made.support_factor, 1.5);
  for (const bool moves : {false, true}) {
    NeighbourList<double> list = made;
    if (!moves) list.support_factor = 0;
    const auto evaluate = [&](const PointList<double, D>& at) {
      // The same neighbours; the same supports only if they stand still.
      NeighbourList<double> here = made;
      if (moves) here = list_at(at);
      return reconstruct(points_of(points), points_of(at), here, options).apply(field_of(values));
    };
    const Reconstruction fit = reconstruct(points_of(points), points_of(targets), list, options);
    EXPECT_EQ(fit.neighbours().support_factor, list.support_factor);
    const auto gradient = fit.gradient().apply(field_of(values));
    expect_derivative<D>(gradient, targets, evaluate, 2e-7, moves ? "moves" : "still");
  }
}

template <class C>
class Gradient : public ::testing::Test {};
TYPED_TEST_SUITE(Gradient, AllCases, CaseNames);

// sum_p grad phi_p m(x_p - x) = grad m at 0 for every monomial up to the degree, in both kinds; and
// second derivatives.
TYPED_TEST(Gradient, ReproducesPolynomials) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  using Terms = Monomials<D, 4>;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 40 : D == 2 ? 16 : 8, 0.3, 1);
  const auto targets = random_points<Scalar, D>(20, 2);
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt})
    for (int degree = 1; degree <= 4; ++degree)
      for (const int order : {1, 2, 3}) {  // exact gradient, diffuse gradient, Hessian
        Options options{
            .degree = degree,
            .neighbours = Nearest{static_cast<std::size_t>(3 * monomial_count(D, degree))},
            .solver = solver};
        const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
        if (order == 3 && degree < 2) continue;
        const auto op = order == 1   ? fit.gradient()
                        : order == 2 ? fit.gradient(Derivative::diffuse)
                                     : fit.hessian();
        for (std::size_t t = 0; t < targets.size(); ++t) {
          const FitReport& report = fit.report()[t];
          const double rho = fit.support(t);
          const auto row = op.row(t);
          for (int j = 0; j < Terms::begin(report.degree + 1); ++j) {
            const auto& e = Terms::exponents[j];
            for (int b = 0; b < op.blocks(); ++b) {
              long double sum = 0, scale = 0;
              for (std::size_t i = 0; i < row.size(); ++i) {
                long double term = row.value(i, b);
                for (int d = 0; d < D; ++d)
                  for (int n = 0; n < e[d]; ++n)
                    term *= (static_cast<long double>(points[row.particle(i)][d]) - targets[t][d]) /
                            rho;
                sum += term;
                scale += std::abs(term);
              }
              // In units of 1/rho, 1/rho^2: the derivative of xi^e at 0.
              const int jet = order == 3 ? 1 + D + b : 1 + b;
              double expected = j == jet ? 1 : 0;
              if (order == 3 && j == jet && *std::max_element(e.begin(), e.end()) == 2)
                expected = 2;
              const double unit = order == 3 ? rho * rho : rho;
              EXPECT_NEAR(static_cast<double>(sum) * unit, expected,
                          rounding<Scalar>(report) * 10 * (1 + static_cast<double>(scale) * unit))
                  << name_of(solver) << " degree " << degree << " order " << order << " monomial "
                  << j << " block " << b;
            }
          }
        }
      }
}

// Particles on a line: the slope along the line is found, none is invented across it, and the
// report says so.
TYPED_TEST(Gradient, UnresolvedDirectionIsReportedNotInvented) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  if constexpr (D >= 2) {
    const auto points = diagonal_points<Scalar, D>(40, 3);
    std::vector<Scalar> u;
    for (const auto& x : points)
      u.push_back(2 + 3 * x[0]);  // slope 3 per unit of x along the diagonal
    PointList<Scalar, D> targets(1);
    targets[0].fill(Scalar(0.5));
    targets[0][0] = Scalar(0.6);  // beside the line
    for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
      const BasicReconstruction<Scalar> fit(
          points_of(points), points_of(targets),
          {.degree = 1, .neighbours = Radius{0.5}, .solver = solver});
      EXPECT_EQ(fit.report()[0].kept[1], 1);
      EXPECT_EQ(fit.report()[0].status, FitStatus::reduced);
      const auto g = fit.gradient(Derivative::diffuse).apply(field_of(std::as_const(u)));
      // The gradient lies along the diagonal and has the right slope there: (3 / D, ..., 3 / D).
      for (int d = 0; d < D; ++d) EXPECT_NEAR(g(0, d), 3.0 / D, 200 * TypeParam::eps);
      // The value is that of the nearest point of the line.
      const double foot = (0.6 + 0.5 * (D - 1)) / D;
      EXPECT_NEAR(fit.apply(field_of(std::as_const(u)))(0, 0), 2 + 3 * foot, 100 * TypeParam::eps);
    }
  }
}

}  // namespace
}  // namespace recon::testing
