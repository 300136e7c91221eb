// Orders of convergence on random clouds: with h the spacing, values of a fit of degree R are of
// order h^(R + 1), first derivatives of order h^R, second ones of order h^(R - 1); degree 1 has no
// second derivatives.
#include <gtest/gtest.h>

#include <cmath>

#include "recon/basis/monomials.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"

namespace recon::testing {
namespace {

using Eigen::MatrixXd;
using F = Functional;

// u = prod_d sin(2 x_d + d + 0.5) with its derivatives.
template <int D>
struct Wave {
  static double factor(double x, int d, int order) {
    const double phase = 2 * x + d + 0.5;
    return order == 0 ? std::sin(phase) : order == 1 ? 2 * std::cos(phase) : -4 * std::sin(phase);
  }
  static double derivative(const std::array<double, D>& x, const Functional::Powers& orders) {
    double product = 1;
    for (int d = 0; d < D; ++d) product *= factor(x[d], d, orders[d]);
    return product;
  }
};

// The root mean square errors of value, exact and diffuse gradient, Hessian and Laplacian.
using Errors = std::array<double, 5>;

template <int D>
Errors errors_of(int degree, std::size_t count) {
  const auto points = random_points<double, D>(count, 11);
  auto targets = random_points<double, D>(400, 12);
  for (auto& x : targets)
    for (double& c : x) c = 0.25 + 0.5 * c;
  std::vector<double> u;
  for (const auto& x : points) u.push_back(Wave<D>::derivative(x, {}));
  const std::size_t near = static_cast<std::size_t>(3 * monomial_count(D, degree));
  const auto fit = reconstruct(points_of(points), points_of(targets),
                               {.degree = degree, .neighbours = Nearest{near}});
  const std::array<Functional, 5> functionals{
      F::value, F::gradient, F::gradient.with(Derivative::diffuse), F::hessian, F::laplacian};
  const auto operators =
      fit.operators(functionals[0], functionals[1], functionals[2], functionals[3], functionals[4]);
  Errors errors{};
  const auto add = [&](const CsrOperator<double>& op, int i) {
    const MatrixXd found = op.apply(field_of(u));
    const auto sums = functionals[i].derivatives(D);
    double squares = 0;
    for (std::size_t t = 0; t < targets.size(); ++t)
      for (std::size_t n = 0; n < sums.size(); ++n) {
        double expected = 0;
        for (const auto& orders : sums[n]) expected += Wave<D>::derivative(targets[t], orders);
        squares += (found(t, n) - expected) * (found(t, n) - expected);
      }
    errors[i] = std::sqrt(squares / static_cast<double>(targets.size()));
  };
  add(std::get<0>(operators), 0);
  add(std::get<1>(operators), 1);
  add(std::get<2>(operators), 2);
  add(std::get<3>(operators), 3);
  add(std::get<4>(operators), 4);
  return errors;
}

template <int D>
void expect_orders(std::size_t few, std::size_t many) {
  const double refinement = std::pow(static_cast<double>(many) / static_cast<double>(few), 1.0 / D);
  for (int degree = 1; degree <= 4; ++degree) {
    const Errors coarse = errors_of<D>(degree, few), fine = errors_of<D>(degree, many);
    const int orders[5] = {degree + 1, degree, degree, degree - 1, degree - 1};
    for (int i = 0; i < (degree == 1 ? 3 : 5); ++i)
      EXPECT_GE(std::log(coarse[i] / fine[i]) / std::log(refinement), orders[i] - 0.3)
          << D << "-D, degree " << degree << ", functional " << i << ": " << coarse[i] << ", "
          << fine[i];
  }
}

TEST(ConvergenceOrders, OnALine) {
  expect_orders<1>(100, 1600);
}
TEST(ConvergenceOrders, InThePlane) {
  expect_orders<2>(2000, 32000);
}
TEST(ConvergenceOrders, InSpace) {
  expect_orders<3>(8000, 128000);
}

// Of degree 1 there are no second derivatives.
TEST(ConvergenceOrders, DegreeOneHasNoCurvature) {
  const auto points = random_points<double, 2>(500, 1);
  std::vector<double> u;
  for (const auto& x : points) u.push_back(x[0] * x[0]);
  const auto fit = reconstruct(points_of(points), points_of(points), {.degree = 1});
  EXPECT_EQ(fit.hessian().apply(field_of(u)).cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(fit.report()[7].hessian_rank, 0);
}

}  // namespace
}  // namespace recon::testing
