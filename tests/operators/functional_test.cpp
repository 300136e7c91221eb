// Functionals against closed forms and differences, their sums, and the adjointness of what mixes components.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using Eigen::MatrixXd;
using ::testing::HasSubstr;
using F = Functional;

template <int D>
using Points = PointList<double, D>;

// u_c = sum over monomials of degree at most 2 of coefficients that differ from one to another, with its
// derivatives.
template <int D>
struct Quadratic {
  double constant[D], slope[D][D], second[D][D][D];  // second is symmetric in its last two

  Quadratic() {
    RandomNumbers random(5);
    for (int c = 0; c < D; ++c) {
      constant[c] = random.uniform(-1, 1);
      for (int a = 0; a < D; ++a) {
        slope[c][a] = random.uniform(-1, 1);
        for (int b = 0; b <= a; ++b) second[c][a][b] = second[c][b][a] = random.uniform(-1, 1);
      }
    }
  }
  double value(const std::array<double, D>& x, int c) const {
    double u = constant[c];
    for (int a = 0; a < D; ++a) {
      u += slope[c][a] * x[a];
      for (int b = 0; b < D; ++b) u += 0.5 * second[c][a][b] * x[a] * x[b];
    }
    return u;
  }
  double gradient(const std::array<double, D>& x, int c, int a) const {
    double g = slope[c][a];
    for (int b = 0; b < D; ++b) g += second[c][a][b] * x[b];
    return g;
  }
};

template <int D>
MatrixXd values_of(const Quadratic<D>& u, const Points<D>& points) {
  MatrixXd field(points.size(), D);
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int c = 0; c < D; ++c) field(p, c) = u.value(points[p], c);
  return field;
}

template <class Dimension>
class Functionals : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                                    std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Functionals, Dimensions);

TYPED_TEST(Functionals, AreThoseOfQuadratics) {
  constexpr int D = TypeParam::value;
  const auto points = random_points<double, D>(1200, 1), targets = random_points<double, D>(600, 2);
  const Quadratic<D> u;
  const MatrixXd field = values_of<D>(u, points);
  for (const Solver solver : {Solver::gram_schmidt, Solver::moment_matrix, Solver::svd}) {
    const auto fit = reconstruct(points_of(points), points_of(targets),
                                 {.degree = 2,
                                  .neighbours = Nearest{static_cast<std::size_t>(8 * D * D)},
                                  .solver = solver});
    const auto [value, grad, hess, lap, div, strain, mixed, first] = fit.operators(
        F::value, F::gradient, F::hessian, F::laplacian, F::divergence, F::strain_rate,
        D == 1 ? F::partial(2) : F::partial(1, 1), F::partial(1).with(Derivative::diffuse));
    const auto field_view = field_of(field);
    const MatrixXd v = value.apply(field_view), g = grad.apply(field_view),
                   h = hess.apply(field_view), l = lap.apply(field_view), d = div.apply(field_view),
                   s = strain.apply(field_view), m = mixed.apply(field_view),
                   f = first.apply(field_view);
    ASSERT_EQ(d.cols(), 1);
    ASSERT_EQ(s.cols(), D * (D + 1) / 2);
    ASSERT_EQ(l.cols(), D);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      ASSERT_EQ(fit.report()[t].status, FitStatus::full);
      double divergence = 0;
      int pair = 0;
      for (int a = 0; a < D; ++a) {
        divergence += u.gradient(targets[t], a, a);
        for (int b = a; b < D; ++b, ++pair)
          EXPECT_NEAR(s(t, pair), (u.gradient(targets[t], a, b) + u.gradient(targets[t], b, a)) / 2,
                      1e-8);
      }
      EXPECT_NEAR(d(t, 0), divergence, 1e-8);
      for (int c = 0; c < D; ++c) {
        EXPECT_NEAR(v(t, c), u.value(targets[t], c), 1e-10);
        double laplacian = 0;
        int entry = 0;
        for (int a = 0; a < D; ++a) {
          laplacian += u.second[c][a][a];
          EXPECT_NEAR(g(t, c * D + a), u.gradient(targets[t], c, a), 1e-8);
          for (int b = a; b < D; ++b, ++entry)
            EXPECT_NEAR(h(t, c * D * (D + 1) / 2 + entry), u.second[c][a][b], 1e-5);
        }
        EXPECT_NEAR(l(t, c), laplacian, 1e-5);
        EXPECT_NEAR(m(t, c), u.second[c][0][D == 1 ? 0 : 1], 1e-5);
        EXPECT_NEAR(f(t, c), u.gradient(targets[t], c, 0), 1e-8);
      }
    }
  }
}

// Of a turning v = omega x r: the curl is 2 omega, the strain rate 0.
TEST(VectorFunctionals, OfATurning) {
  const auto points = random_points<double, 3>(900, 3);
  const std::array<double, 3> omega{0.3, -1.2, 0.7};
  std::vector<std::array<double, 3>> v;
  for (const auto& x : points)
    v.push_back({omega[1] * x[2] - omega[2] * x[1], omega[2] * x[0] - omega[0] * x[2],
                 omega[0] * x[1] - omega[1] * x[0]});
  const auto fit = reconstruct(points_of(points), points_of(points));
  const auto [curl, strain] = fit.operators(F::curl, F::strain_rate);
  const MatrixXd c = curl.apply(field_of(v)), s = strain.apply(field_of(v));
  for (Eigen::Index t = 0; t < c.rows(); ++t)
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(c(t, i), 2 * omega[i], 1e-9);
  EXPECT_LT(s.cwiseAbs().maxCoeff(), 1e-9);

  const auto flat = random_points<double, 2>(400, 3);
  std::vector<std::array<double, 2>> w;
  for (const auto& x : flat) w.push_back({-0.5 * x[1], 0.5 * x[0]});
  const auto flat_fit = reconstruct(points_of(flat), points_of(flat));
  const MatrixXd z = std::get<0>(flat_fit.operators(F::curl)).apply(field_of(w));
  ASSERT_EQ(z.cols(), 1);
  EXPECT_NEAR(z(7, 0), 1, 1e-10);
}

TYPED_TEST(Functionals, TransposesAreAdjoint) {
  constexpr int D = TypeParam::value;
  const auto points = random_points<double, D>(700, 1), targets = random_points<double, D>(600, 2);
  const auto fit = reconstruct(points_of(points), points_of(targets), {.degree = 2});
  RandomNumbers random(8);
  const auto numbers = [&](Eigen::Index rows, int columns) {
    MatrixXd m(rows, columns);
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = random.uniform(-1, 1);
    return m;
  };
  const auto check = [&](const auto& op, int in, int out, const char* name) {
    const MatrixXd u = numbers(700, in), f = numbers(600, out);
    const MatrixXd au = op.apply(field_of(u)), atf = op.apply_transpose(field_of(f));
    const double left = (au.array() * f.array()).sum(), right = (u.array() * atf.array()).sum();
    EXPECT_NEAR(left, right, 1e-12 * au.norm() * f.norm()) << name;
  };
  const auto [value, grad, lap, div, strain] =
      fit.operators(F::value, F::gradient, F::laplacian, F::divergence, F::strain_rate);
  check(value, 3, 3, "value");
  check(grad, 2, 2 * D, "gradient");
  check(lap, 2, 2, "laplacian");
  check(div, D, 1, "divergence");
  check(strain, D, D * (D + 1) / 2, "strain rate");
  check(value + 0.3 * lap, 2, 2, "a sum");
  if constexpr (D > 1) check(std::get<0>(fit.operators(F::curl)), D, D == 2 ? 1 : 3, "curl");
}

TEST(FunctionalOperators, OperatorsAddUp) {
  const auto points = random_points<double, 2>(700, 1);
  const auto fit = reconstruct(points_of(points), points_of(points), {.degree = 2});
  std::vector<double> u;
  for (const auto& x : points) u.push_back(std::sin(3 * x[0]) * x[1]);
  const auto [v, lap, xx, yy] =
      fit.operators(F::value, F::laplacian, F::partial(2, 0), F::partial(0, 2));
  const double dt = 1e-3;
  const MatrixXd heat = (v + dt * lap).apply(field_of(u)),
                 parts = v.apply(field_of(u)) + dt * lap.apply(field_of(u));
  EXPECT_LT((heat - parts).cwiseAbs().maxCoeff(), 1e-12);
  const MatrixXd none = (lap - xx - yy).apply(field_of(u));
  EXPECT_LT(none.cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ((v * 2.0).apply(field_of(u)), (2.0 * v).apply(field_of(u)));
}

TEST(FunctionalOperators, AreThoseOfTheSingleCalls) {
  const auto points = random_points<double, 3>(700, 1);
  const auto fit = reconstruct(points_of(points), points_of(points), {.degree = 2});
  std::vector<double> u;
  for (const auto& x : points) u.push_back(std::sin(3 * x[0]) * x[1] + x[2]);
  const auto [hess, grad, diffuse, again] =
      fit.operators(F::hessian, F::gradient, F::gradient.with(Derivative::diffuse), F::gradient);
  EXPECT_EQ(hess.apply(field_of(u)), fit.hessian().apply(field_of(u)));
  EXPECT_EQ(grad.apply(field_of(u)), fit.gradient().apply(field_of(u)));
  EXPECT_EQ(again.apply(field_of(u)), fit.gradient().apply(field_of(u)));
  EXPECT_EQ(diffuse.apply(field_of(u)), fit.gradient(Derivative::diffuse).apply(field_of(u)));
}

TEST(FunctionalOperators, WithoutSupportHaveTheFillValue) {
  const Points<2> points{{0, 0}, {0.1, 0}, {0, 0.1}, {0.1, 0.1}}, targets{{0.05, 0.05}, {5, 5}};
  const auto fit = reconstruct(points_of(points), points_of(targets),
                               {.neighbours = Radius{0.3}, .fill_value = 7});
  const std::vector<std::array<double, 2>> v{{0, 0}, {0.1, 0}, {0, 0.2}, {0.1, 0.2}};
  const MatrixXd div = std::get<0>(fit.operators(F::divergence)).apply(field_of(v));
  EXPECT_NEAR(div(0, 0), 3, 1e-12);
  EXPECT_EQ(div(1, 0), 7);
}

TEST(FunctionalOperators, ChosenWhileTheProgramRunsAreTheSame) {
  const auto points = random_points<double, 2>(400, 1), targets = random_points<double, 2>(700, 2);
  const Quadratic<2> u;
  const MatrixXd field = values_of<2>(u, points);
  const auto fit = reconstruct(points_of(points), points_of(targets), {.degree = 2});
  const auto [lap, curl, mean] = fit.operators(F::laplacian, F::curl, F::cell_average({0.1, 0.1}));
  const std::vector<AnyFunctional> chosen{F::laplacian, F::curl, F::cell_average({0.1, 0.1})};
  const auto made = fit.operators(chosen);
  ASSERT_EQ(made.size(), 3U);
  EXPECT_EQ(std::get<CsrOperator<double>>(made[0]).apply(field_of(field)),
            lap.apply(field_of(field)));
  EXPECT_EQ(std::get<VectorOperator<double>>(made[1]).apply(field_of(field)),
            curl.apply(field_of(field)));
  EXPECT_EQ(std::get<CsrOperator<double>>(made[2]).apply(field_of(field)),
            mean.apply(field_of(field)));
  EXPECT_TRUE(fit.operators(std::span<const AnyFunctional>()).empty());
}

// Rows stand in an order of their own where there are many targets: the pattern says which is whose.
TEST(FunctionalOperators, NumbersAreThoseOfTheRows) {
  const auto points = random_points<double, 2>(400, 1), targets = random_points<double, 2>(700, 2);
  const auto gradient = reconstruct(points_of(points), points_of(targets)).gradient();
  const SparsityPattern<double>& pattern = gradient.pattern();
  for (std::size_t row = 0; row < gradient.rows(); ++row) {
    const auto expected = gradient.row(pattern.target(row));
    const auto begin = pattern.neighbours.offsets[row];
    ASSERT_EQ(static_cast<std::size_t>(pattern.neighbours.count(row)), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      for (int b = 0; b < 2; ++b)
        EXPECT_EQ(gradient.numbers()[(begin + i) * 2 + b], expected.value(i, b));
  }
}

TEST(FunctionalOperators, MistakesAreNamed) {
  EXPECT_THAT(message_of([] { F::partial(3, 2); }), HasSubstr("must be at most 4"));
  EXPECT_THAT(message_of([] { F::partial(-1); }), HasSubstr("must not be negative"));
  const auto points = random_points<double, 2>(50, 1), others = random_points<double, 2>(50, 2);
  const auto line = random_points<double, 1>(50, 1);
  const auto fit = reconstruct(points_of(points), points_of(points));
  const auto other = reconstruct(points_of(points), points_of(others));
  EXPECT_THAT(message_of([&] { fit.operators(F::partial(0, 0, 1)); }),
              HasSubstr("must be an axis of the points"));
  EXPECT_THAT(message_of([&] { fit.values() + other.values(); }), HasSubstr("pattern"));
  EXPECT_THAT(message_of([&] { fit.values() + fit.gradient(); }), HasSubstr("blocks"));
  EXPECT_THAT(message_of([&] { reconstruct(points_of(line), points_of(line)).operators(F::curl); }),
              HasSubstr("must be 2 or 3"));
  const std::vector<double> scalar(50, 1.0);
  EXPECT_THAT(
      message_of([&] { std::get<0>(fit.operators(F::divergence)).apply(field_of(scalar)); }),
      HasSubstr("components of the field = 1"));
}

}  // namespace
}  // namespace recon::testing
