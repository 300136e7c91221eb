// The whole path from weights to shape functions where the compiler evaluates it: a constant
// expression has no undefined behaviour and no allocation that outlives it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "recon/basis/monomials.hpp"
#include "recon/shape/target_shapes.hpp"
#include "recon/weights/weight.hpp"

namespace recon {
namespace {

constexpr bool near(double a, double b, double tolerance) {
  return a - b <= tolerance && b - a <= tolerance;
}

// Square roots, to a rounding, over the range of numbers.
constexpr bool is_root(double root, double x) {
  return near(root * (root / x), 1, 4 * std::numeric_limits<double>::epsilon());
}
static_assert(is_root(detail::square_root(2.0), 2) && is_root(detail::square_root(0.3), 0.3) &&
              is_root(detail::square_root(7e300), 7e300) &&
              is_root(detail::square_root(3e-300), 3e-300) && detail::square_root(0.0) == 0 &&
              detail::square_root(9.0f) == 3);

static_assert(near(BSpline<3>{}(0.0), 2.0 / 3, 1e-15) && BSpline<3>{}(1.0) == 0);
static_assert(Wendland<2>{}(0.5) == 3.0 / 16 && Wendland<2>{}.derivative(0.5) == -1.25);
static_assert(near(Gaussian{}(0.0), 1, 1e-15) && near(Gaussian{}(1.0), 0, 1e-15));

constexpr double some_q[] = {0, 0.1, 0.25, 0.4, 0.6, 0.77, 0.9, 0.999};

template <class W>
struct Table {
  std::array<double, std::size(some_q)> value{}, slope{};
  constexpr Table() {
    for (std::size_t i = 0; i < std::size(some_q); ++i) {
      value[i] = W{}(some_q[i]);
      slope[i] = W{}.derivative(some_q[i]);
    }
  }
};

template <class W>
class ConstantWeights : public ::testing::Test {};
using Weights =
    ::testing::Types<BSpline<1>, BSpline<2>, BSpline<3>, BSpline<4>, BSpline<5>, Wendland<0>,
                     Wendland<2>, Wendland<4>, Wendland<6>, Gaussian, InverseDistance>;
TYPED_TEST_SUITE(ConstantWeights, Weights);

TYPED_TEST(ConstantWeights, EqualThoseOfTheRunningProgram) {
  static constexpr Table<TypeParam> constant;
  const TypeParam weight{};
  detail::validate_weight(weight);
  for (std::size_t i = 0; i < std::size(some_q); ++i) {
    volatile double q = some_q[i];
    EXPECT_NEAR(constant.value[i], weight(double(q)), 1e-14) << q;
    EXPECT_NEAR(constant.slope[i], weight.derivative(double(q)),
                1e-14 * (1 + std::abs(constant.slope[i])))
        << q;
  }
}

// Monomials: x y^2 z of (2, 3, 5), and (x + y)^2 = xx + 2 xy + yy.
using Cubic = Monomials<3, 4>;
constexpr double monomial(Cubic::Exponents e) {
  std::array<double, Cubic::size> values{};
  Cubic::evaluate<double>({2, 3, 5}, values.data());
  return values[Cubic::find(e)];
}
static_assert(monomial({1, 2, 1}) == 90 && monomial({0, 0, 0}) == 1 && monomial({0, 0, 4}) == 625);
constexpr auto square =
    Monomials<2, 2>::of_forms<double>({1, 1}, {std::array{1.0, 1.0}, std::array{1.0, 1.0}});
static_assert(square == std::array<double, 6>{0, 0, 0, 1, 2, 1});

// Seven points in general position, or seven on a line.
constexpr std::array<std::array<double, 2>, 7> anywhere{
    {{0.1, 0.2}, {0.8, 0.1}, {0.4, 0.9}, {0.5, 0.5}, {0.2, 0.7}, {0.9, 0.8}, {0.6, 0.3}}};
constexpr std::array<std::array<double, 2>, 7> on_a_line{
    {{0.1, 0.1}, {0.2, 0.2}, {0.35, 0.35}, {0.5, 0.5}, {0.6, 0.6}, {0.8, 0.8}, {0.9, 0.9}}};
constexpr std::array<double, 2> target{0.45, 0.55};

struct Outcome {
  FitReport report;
  double one = 0, xy = 0, slope_x = 0, slope_y = 0, mixed = 0, xx = 0;
};

template <class W, WeightForm form>
constexpr Outcome fit(const std::array<std::array<double, 2>, 7>& points, Solver solver) {
  TargetShapes<Monomials<2, 2>, W, double, RoomFor<7>> shapes(W{}, solver, form);
  Outcome outcome;
  outcome.report = shapes.fit(target, 1.1, 7, [&](int i) {
    return std::array<double, 2>{points[i][0] - target[0], points[i][1] - target[1]};
  });
  const auto phi = shapes.arrays();
  for (int p = 0; p < shapes.size(); ++p) {
    const auto& x = points[shapes.place(p)];
    outcome.one += phi.value[p];
    outcome.xy += phi.value[p] * x[0] * x[1];
    outcome.slope_x += phi.gradient[0][p] * x[0] * x[1];
    outcome.slope_y += phi.gradient[1][p] * x[0] * x[1];
    outcome.xx += phi.hessian[0][p] * x[0] * x[1];
    outcome.mixed += phi.hessian[1][p] * x[0] * x[1];
  }
  return outcome;
}

constexpr bool reproduces(const Outcome& of) {
  return of.report.status == FitStatus::full && near(of.one, 1, 1e-13) &&
         near(of.xy, target[0] * target[1], 1e-13) && near(of.slope_x, target[1], 1e-12) &&
         near(of.slope_y, target[0], 1e-12) && near(of.mixed, 1, 1e-11) && near(of.xx, 0, 1e-11);
}
static_assert(reproduces(fit<BSpline<3>, WeightForm::radial>(anywhere, Solver::moment_matrix)));
static_assert(reproduces(fit<BSpline<3>, WeightForm::radial>(anywhere, Solver::gram_schmidt)));
static_assert(reproduces(fit<Wendland<4>, WeightForm::tensor_product>(anywhere,
                                                                      Solver::moment_matrix)));
static_assert(reproduces(fit<Gaussian, WeightForm::tensor_product>(anywhere,
                                                                   Solver::gram_schmidt)));
static_assert(fit<BSpline<3>, WeightForm::radial>(anywhere, Solver::moment_matrix).report.solver ==
              Solver::moment_matrix);

// The moment matrix hands the line over. Along it the fit is of degree 2: x y is x^2 there, with
// the slope 2 x in the direction (1, 1), and so x along each axis.
constexpr Outcome line = fit<Wendland<2>, WeightForm::radial>(on_a_line, Solver::moment_matrix);
static_assert(line.report.solver == Solver::gram_schmidt && line.report.rank == 3 &&
              line.report.kept[1] == 1 && line.report.kept[2] == 1 &&
              line.report.gradient_rank == 1 && near(line.one, 1, 1e-13) &&
              near(line.xy, 0.25, 1e-13) && near(line.slope_x, 0.5, 1e-12) &&
              near(line.slope_y, 0.5, 1e-12));

// What was a constant is what the running program finds, to rounding.
TEST(ConstantFit, EqualsThatOfTheRunningProgram) {
  constexpr Outcome constant = fit<BSpline<3>, WeightForm::radial>(anywhere, Solver::gram_schmidt);
  volatile double first = anywhere[0][0];
  auto points = anywhere;
  points[0][0] = first;
  const Outcome running = fit<BSpline<3>, WeightForm::radial>(points, Solver::gram_schmidt);
  EXPECT_EQ(running.report.kept, constant.report.kept);
  EXPECT_NEAR(running.report.amplification, constant.report.amplification, 1e-5);
  EXPECT_NEAR(running.xy, constant.xy, 1e-14);
  EXPECT_NEAR(running.mixed, constant.mixed, 1e-12);
}

}  // namespace
}  // namespace recon
