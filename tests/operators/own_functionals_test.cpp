// Functionals of the local polynomial: derivatives of any order, averages, integrals and those of
// one's own, exact on polynomials, and in agreement with values and derivatives wherever something
// was dropped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/message_of.hpp"
#include "support/solvers.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

using Eigen::MatrixXd;
using ::testing::HasSubstr;
using F = Functional;
using Powers = Functional::Powers;
using Offset = Functional::Offset;

template <int D>
Offset padded(const std::array<double, D>& x) {
  Offset full{};
  for (int d = 0; d < D; ++d) full[d] = x[d];
  return full;
}

// A polynomial of degree R in the coordinates, with coefficients that differ, and its derivatives.
template <int D, int R>
struct Polynomial {
  using Terms = Monomials<D, R>;
  std::array<double, Terms::size> coefficients;

  Polynomial() {
    RandomNumbers random(5);
    for (double& c : coefficients) c = random.uniform(-1, 1);
  }
  double derivative(const Offset& x, const Powers& orders) const {
    double sum = 0;
    for (int j = 0; j < Terms::size; ++j) {
      double term = coefficients[j];
      for (int d = 0; d < max_dimension; ++d) {
        const int power = d < D ? Terms::exponents[j][d] : 0;
        for (int n = 0; n < orders[d]; ++n) term *= power - n;
        for (int n = 0; n < power - orders[d]; ++n) term *= x[d];
      }
      sum += term;
    }
    return sum;
  }
  double operator()(const Offset& x) const { return derivative(x, {}); }
  std::vector<double> on(const PointList<double, D>& points) const {
    std::vector<double> values;
    for (const auto& x : points) values.push_back((*this)(padded<D>(x)));
    return values;
  }
};

// How much number `block` of a row amplifies errors of data of the order of one.
template <class Scalar>
double amplification_of(const CsrOperator<Scalar>& op, std::size_t t, int block) {
  const auto row = op.row(t);
  double sum = 0;
  for (std::size_t i = 0; i < row.size(); ++i)
    sum += std::abs(static_cast<double>(row.value(i, block)));
  return sum;
}

// What rounding may change in such a number: as rounding() of values.
template <class Scalar>
double allowed(const CsrOperator<Scalar>& op, const FitReport& report, std::size_t t, int block,
               double largest_datum) {
  const double loss =
      report.solver == Solver::moment_matrix ? 1 / static_cast<double>(report.smallest_pivot) : 1;
  return 8 * std::numeric_limits<Scalar>::epsilon() * (4 + report.rank) * loss * largest_datum *
         amplification_of(op, t, block);
}

// Every derivative up to order 4, in D dimensions.
template <int D>
std::vector<Powers> all_orders() {
  std::vector<Powers> all;
  for (const auto& exponents : Monomials<D, 4>::exponents) {
    Powers orders{};
    for (int d = 0; d < D; ++d) orders[d] = exponents[d];
    all.push_back(orders);
  }
  return all;
}

template <int D, int R>
void expect_derivatives() {
  const std::size_t near = static_cast<std::size_t>(4 * monomial_count(D, R) + 4);
  const auto points = random_points<double, D>(20 * near, 1),
             targets = random_points<double, D>(60, 2);
  const Polynomial<D, R> u;
  const std::vector<double> data = u.on(points);
  for (const Solver solver : all_solvers) {
    const auto fit = reconstruct(points_of(points), points_of(targets),
                                 {.degree = R, .neighbours = Nearest{near}, .solver = solver});
    for (const Powers& orders : all_orders<D>()) {
      const auto [op] =
          fit.operators(F::partial(orders[0], orders[1], orders[2]).with(Derivative::diffuse));
      const MatrixXd found = op.apply(field_of(data));
      for (std::size_t t = 0; t < targets.size(); ++t) {
        ASSERT_EQ(fit.report()[t].status, FitStatus::full);
        const bool above = orders[0] + orders[1] + orders[2] > R;
        const double expected = u.derivative(padded<D>(targets[t]), orders);
        if (above) {
          EXPECT_EQ(found(t, 0), 0);
        } else {
          EXPECT_NEAR(found(t, 0), expected, allowed(op, fit.report()[t], t, 0, 3) + 1e-14)
              << D << "-D, degree " << R << ", " << name_of(solver) << ", orders " << orders[0]
              << orders[1] << orders[2];
        }
      }
    }
  }
}

template <class Dimension>
class OwnFunctionals : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                                    std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(OwnFunctionals, Dimensions);

TYPED_TEST(OwnFunctionals, AllDerivativesOfPolynomials) {
  constexpr int D = TypeParam::value;
  expect_derivatives<D, 0>();
  expect_derivatives<D, 1>();
  expect_derivatives<D, 2>();
  expect_derivatives<D, 3>();
  expect_derivatives<D, 4>();
}

// The average over a box by Gauss points, the integral along a line by the rule of Boole, both
// exact for degree 4.
template <int D, class Field>
double box_average(const Field& u, const Offset& centre, const Offset& edges) {
  const double gauss[3] = {-std::sqrt(0.6), 0, std::sqrt(0.6)},
               weight[3] = {5. / 18, 8. / 18, 5. / 18};
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < (D > 1 ? 3 : 1); ++j)
      for (int k = 0; k < (D > 2 ? 3 : 1); ++k) {
        const int at[3] = {i, j, k};
        Offset x = centre;
        double w = 1;
        for (int d = 0; d < D; ++d) {
          x[d] += gauss[at[d]] * edges[d] / 2;
          w *= weight[at[d]];
        }
        sum += w * u(x);
      }
  return sum;
}

template <class Field>
double along_line(const Field& u, const Offset& centre, const Offset& from, const Offset& to) {
  const double weight[5] = {7. / 90, 32. / 90, 12. / 90, 32. / 90, 7. / 90};
  double sum = 0, length2 = 0;
  for (int i = 0; i < 5; ++i) {
    Offset x = centre;
    for (int d = 0; d < max_dimension; ++d) x[d] += from[d] + i / 4.0 * (to[d] - from[d]);
    sum += weight[i] * u(x);
  }
  for (int d = 0; d < max_dimension; ++d) length2 += (to[d] - from[d]) * (to[d] - from[d]);
  return std::sqrt(length2) * sum;
}

TYPED_TEST(OwnFunctionals, AveragesAndIntegralsAreExactOnPolynomials) {
  constexpr int D = TypeParam::value;
  const auto points = random_points<double, D>(1500, 1), targets = random_points<double, D>(100, 2);
  const Polynomial<D, 4> u;
  const std::vector<double> data = u.on(points), ones(points.size(), 1.0);
  Offset edges{}, from{}, to{};
  for (int d = 0; d < D; ++d)
    edges[d] = 0.1 + 0.05 * d, from[d] = 0.02 * d - 0.01, to[d] = 0.1 - 0.03 * d;
  const auto fit = reconstruct(points_of(points), points_of(targets),
                               {.degree = 4, .neighbours = Nearest{D == 3 ? 140u : 60u}});
  const auto [average, integral, point] =
      fit.operators(F::cell_average(edges), F::line_integral(from, to), F::cell_average({0, 0, 0}));
  const MatrixXd a = average.apply(field_of(data)), i = integral.apply(field_of(data)),
                 one = average.apply(field_of(ones)), v = point.apply(field_of(data)),
                 value = fit.apply(field_of(data));
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const Offset x = padded<D>(targets[t]);
    const FitReport& report = fit.report()[t];
    ASSERT_EQ(report.degree, 4);
    EXPECT_NEAR(one(t, 0), 1, allowed(average, report, t, 0, 1));
    EXPECT_NEAR(a(t, 0), box_average<D>(u, x, edges), allowed(average, report, t, 0, 3));
    EXPECT_NEAR(i(t, 0), along_line(u, x, from, to), allowed(integral, report, t, 0, 3));
    EXPECT_NEAR(v(t, 0), value(t, 0), allowed(point, report, t, 0, 3));
  }
}

// The polynomials at other places, the same offsets for all targets or a place for each; lengths of
// any unit.
TYPED_TEST(OwnFunctionals, PolynomialsAtSeveralPoints) {
  constexpr int D = TypeParam::value;
  for (const double unit : {1.0, 1e-5, 1e5}) {
    auto points = random_points<double, D>(800, 1), targets = random_points<double, D>(50, 2),
         places = targets;
    const Polynomial<D, 3> u;
    const std::vector<double> data = u.on(points);
    RandomNumbers random(4);
    std::vector<Offset> offsets(4);
    for (Offset& offset : offsets)
      for (int d = 0; d < D; ++d) offset[d] = random.uniform(-0.05, 0.05);
    for (auto& x : places)
      for (double& c : x) c += random.uniform(-0.05, 0.05);
    std::vector<Offset> moves;
    for (std::size_t t = 0; t < targets.size(); ++t) {
      moves.push_back({});
      for (int d = 0; d < D; ++d) moves.back()[d] = unit * (places[t][d] - targets[t][d]);
    }
    std::vector<Offset> scaled = offsets;
    for (Offset& offset : scaled)
      for (double& c : offset) c *= unit;
    for (auto* list : {&points, &targets})
      for (auto& x : *list)
        for (double& c : x) c *= unit;
    const auto fit = reconstruct(points_of(points), points_of(targets),
                                 {.degree = 3, .neighbours = Nearest{D == 3 ? 60u : 30u}});
    const auto at_place = F::own([&](std::size_t t, const Powers& powers) {
      double product = 1;
      for (int d = 0; d < D; ++d) product *= std::pow(moves[t][d], powers[d]);
      return product;
    });
    const auto [value, gradient, hessian, laplacian, there, third] =
        fit.operators(F::value.at(scaled), F::gradient.at(scaled), F::hessian.at(scaled),
                      F::laplacian.at(scaled), at_place, F::partial(3).at(scaled));
    constexpr int seconds = D * (D + 1) / 2;
    ASSERT_EQ(value.blocks(), 4);
    ASSERT_EQ(gradient.blocks(), 4 * D);
    ASSERT_EQ(hessian.blocks(), 4 * seconds);
    const auto field = field_of(data);
    const MatrixXd v = value.apply(field), g = gradient.apply(field), h = hessian.apply(field),
                   l = laplacian.apply(field), p = there.apply(field), f = third.apply(field);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const FitReport& report = fit.report()[t];
      EXPECT_NEAR(p(t, 0), u(padded<D>(places[t])), allowed(there, report, t, 0, 3));
      for (int i = 0; i < 4; ++i) {
        Offset x = offsets[i];
        for (int d = 0; d < D; ++d) x[d] += targets[t][d] / unit;
        EXPECT_NEAR(v(t, i), u(x), allowed(value, report, t, i, 3));
        EXPECT_NEAR(f(t, i), u.derivative(x, {3, 0, 0}) / (unit * unit * unit),
                    allowed(third, report, t, i, 3));
        double sum = 0;
        int entry = i * seconds;
        for (int a = 0; a < D; ++a) {
          Powers orders{};
          ++orders[a];
          EXPECT_NEAR(g(t, i * D + a), u.derivative(x, orders) / unit,
                      allowed(gradient, report, t, i * D + a, 3));
          for (int b = a; b < D; ++b, ++entry) {
            ++orders[b];
            EXPECT_NEAR(h(t, entry), u.derivative(x, orders) / (unit * unit),
                        allowed(hessian, report, t, entry, 3));
            if (a == b) sum += u.derivative(x, orders) / (unit * unit);
            --orders[b];
          }
        }
        EXPECT_NEAR(l(t, i), sum, allowed(laplacian, report, t, i, 3));
      }
    }
  }
}

TYPED_TEST(OwnFunctionals, TransposesAreAdjoint) {
  constexpr int D = TypeParam::value;
  const auto points = random_points<double, D>(700, 1), targets = random_points<double, D>(600, 2);
  const auto fit = reconstruct(points_of(points), points_of(targets), {.degree = 3});
  RandomNumbers random(8);
  const auto numbers = [&](Eigen::Index rows, int columns) {
    MatrixXd m(rows, columns);
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = random.uniform(-1, 1);
    return m;
  };
  Offset offset{};
  offset[0] = 0.03;
  const auto [third, average, there, value] =
      fit.operators(F::partial(3), F::cell_average(offset),
                    F::gradient.at({offset, {}, offset, {}, offset}), F::value);
  for (const auto* op : {&third, &average, &there})
    for (const int components : {1, 2, 5}) {
      const MatrixXd u = numbers(700, components), f = numbers(600, components * op->blocks());
      const MatrixXd au = op->apply(field_of(u)), atf = op->apply_transpose(field_of(f));
      const double left = (au.array() * f.array()).sum(), right = (u.array() * atf.array()).sum();
      EXPECT_NEAR(left, right, 1e-13 * au.norm() * f.norm()) << op->blocks() << ", " << components;
    }
  const MatrixXd u = numbers(700, 2);  // operators of one fit add up
  const MatrixXd sum = (value + 0.5 * average).apply(field_of(u)),
                 parts = value.apply(field_of(u)) + 0.5 * average.apply(field_of(u));
  EXPECT_LT((sum - parts).cwiseAbs().maxCoeff(), 1e-13 * parts.cwiseAbs().maxCoeff());
}

// Wherever terms or directions were dropped, on every hostile cloud, the polynomial at the target
// has the value and the derivatives of the other operators.
TYPED_TEST(OwnFunctionals, AgreeWithTheOthersOnHostileClouds) {
  constexpr int D = TypeParam::value;
  for (const auto& [name, points] : hostile_clouds<double, D>()) {
    const auto targets = hostile_targets<double, D>(points);
    RandomNumbers random(9);
    std::vector<double> data;
    for (std::size_t p = 0; p < points.size(); ++p) data.push_back(random.uniform(-1, 1));
    for (const Solver solver : all_solvers)
      for (const int degree : {0, 1, 2, 3, 4})
        for (const auto unsupported : {Unsupported::fill, Unsupported::nearest}) {
          const BasicReconstruction<double> fit(points_of(points), points_of(targets),
                                                {.degree = degree,
                                                 .neighbours = Radius{0.3},
                                                 .solver = solver,
                                                 .unsupported = unsupported,
                                                 .fill_value = 7});
          const auto [v, g, h, value, gradient, hessian] =
              fit.operators(F::value.at({{}}), F::gradient.at({{}}), F::hessian.at({{}}), F::value,
                            F::gradient.with(Derivative::diffuse), F::hessian);
          const CsrOperator<double>* pairs[3][2] = {{&v, &value}, {&g, &gradient}, {&h, &hessian}};
          for (const auto& [found, expected] : pairs) {
            const MatrixXd a = found->apply(field_of(data)), b = expected->apply(field_of(data));
            for (std::size_t t = 0; t < targets.size(); ++t) {
              double rounding = 0;  // directions that are not resolved mix the numbers of a target
              for (int i = 0; i < found->blocks(); ++i)
                rounding += 8 * (allowed(*found, fit.report()[t], t, i, 1) +
                                 allowed(*expected, fit.report()[t], t, i, 1));
              for (int i = 0; i < found->blocks(); ++i)
                EXPECT_NEAR(a(t, i), b(t, i), rounding)
                    << name << ", " << name_of(solver) << ", degree " << degree << ", target " << t
                    << ", number " << i << " of " << found->blocks();
            }
          }
        }
  }
}

// With supports stretched along the axes, across periodic faces, with weights of the particles and
// in float.
TEST(OwnFunctionalOptions, StretchesPeriodsAndWeights) {
  const auto points = random_points<double, 2>(900, 3), targets = random_points<double, 2>(40, 4);
  std::vector<double> u, weights;
  RandomNumbers random(5);
  for (const auto& x : points) {
    u.push_back(1 + x[0] * x[0] - 3 * x[0] * x[1] + 2 * x[1] * x[1] * x[1]);
    weights.push_back(random.uniform(0.5, 2));
  }
  const Options options{
      .degree = 3, .particle_weights = weights, .neighbours = Nearest{40}, .stretch = {0.5, 2, 1}};
  const auto fit = reconstruct(points_of(points), points_of(targets), options);
  const auto [average, xx, yyy] =
      fit.operators(F::cell_average({0.2, 0.1}), F::partial(2).at({{0.1, 0.2}}), F::partial(0, 3));
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto [x, y] = targets[t];
    EXPECT_NEAR(average.apply(field_of(u))(t, 0),
                1 + x * x + 0.04 / 12 - 3 * x * y + 2 * y * (y * y + 0.01 / 4), 1e-11);
    EXPECT_NEAR(xx.apply(field_of(u))(t, 0), 2, 1e-8);
    EXPECT_NEAR(yyy.apply(field_of(u))(t, 0), 12, 1e-6);
  }

  PeriodicDomain<double> box;
  box.lower = {0, 0, 0};
  box.upper = {1, 1, 1};
  box.periodic = {true, false, false};
  const auto around = reconstruct(points_of(points), points_of(targets),
                                  {.degree = 2, .neighbours = Nearest{30}, .domain = box});
  std::vector<double> wave;
  for (const auto& x : points) wave.push_back(std::sin(2 * M_PI * x[0]));
  const MatrixXd shifted =
      std::get<0>(around.operators(F::value.at({{0.05, 0}}))).apply(field_of(wave));
  for (std::size_t t = 0; t < targets.size(); ++t)
    EXPECT_NEAR(shifted(t, 0), std::sin(2 * M_PI * (targets[t][0] + 0.05)), 0.05);

  std::vector<std::array<float, 2>> p, q;
  std::vector<float> v;
  for (const auto& x : points) {
    p.push_back({static_cast<float>(x[0]), static_cast<float>(x[1])});
    v.push_back(1 + p.back()[0] * p.back()[0] - 3 * p.back()[1]);
  }
  for (const auto& x : targets) q.push_back({static_cast<float>(x[0]), static_cast<float>(x[1])});
  const ReconstructionF small(points_of(p), points_of(q), {.degree = 2, .neighbours = Nearest{30}});
  const auto mean = std::get<0>(small.operators(F::cell_average({0.2, 0.1})));
  for (std::size_t t = 0; t < targets.size(); ++t)
    EXPECT_NEAR(mean.apply(field_of(v))(t, 0), 1 + q[t][0] * q[t][0] + 0.04 / 12 - 3 * q[t][1],
                allowed(mean, small.report()[t], t, 0, 5));
}

// Particles on a line in the plane: derivatives along it, none across; averages as far as the line
// tells.
TEST(OwnFunctionalReports, OfALine) {
  PointList<double, 2> points;
  std::vector<double> u;
  for (int i = 0; i <= 40; ++i) {
    points.push_back({i / 40.0, 0.5});
    u.push_back(std::pow(i / 40.0, 3));
  }
  const PointList<double, 2> targets{{0.4, 0.5}};
  for (const Solver solver : all_solvers) {
    const auto fit = reconstruct(points_of(points), points_of(targets),
                                 {.degree = 3, .neighbours = Radius{0.2}, .solver = solver});
    ASSERT_EQ(fit.report()[0].gradient_rank, 1);
    EXPECT_EQ(fit.report()[0].hessian_rank, 1);
    const auto [xxx, xxy, yyy, average, there] =
        fit.operators(F::partial(3), F::partial(2, 1), F::partial(0, 3),
                      F::cell_average({0.2, 0.2}), F::value.at({{0.05, 10}}));
    EXPECT_NEAR(xxx.apply(field_of(u))(0, 0), 6, 1e-8);
    EXPECT_EQ(xxy.apply(field_of(u))(0, 0), 0);
    EXPECT_EQ(yyy.apply(field_of(u))(0, 0), 0);
    EXPECT_NEAR(average.apply(field_of(u))(0, 0), 0.4 * 0.4 * 0.4 + 0.4 * 0.04 / 4, 1e-12);
    EXPECT_NEAR(there.apply(field_of(u))(0, 0), 0.45 * 0.45 * 0.45, 1e-12);
  }
}

TEST(OwnFunctionalReports, WithoutSupport) {
  const PointList<double, 2> points{{0, 0}, {0.1, 0}, {0, 0.1}, {0.1, 0.1}},
      targets{{0.05, 0.05}, {5, 5}};
  const std::vector<double> u{1, 2, 3, 4};
  const auto functional = F::own(2, [](std::size_t, const Powers& n, std::span<double> out) {
    out[0] = n == Powers{} ? 3 : 0;
    out[1] = n == Powers{1, 0, 0} ? 1 : 0;
  });
  const auto filled =
      std::get<0>(reconstruct(points_of(points), points_of(targets), {.neighbours = Radius{0.3}})
                      .operators(functional));
  const MatrixXd f = filled.apply(field_of(u));
  EXPECT_NEAR(f(0, 0), 7.5, 1e-12);
  EXPECT_NEAR(f(0, 1), 10, 1e-11);
  EXPECT_TRUE(std::isnan(f(1, 0)) && std::isnan(f(1, 1)));

  const auto nearest =
      reconstruct(points_of(points), points_of(targets),
                  {.neighbours = Radius{0.3}, .unsupported = Unsupported::nearest});
  const MatrixXd n = std::get<0>(nearest.operators(functional)).apply(field_of(u));
  EXPECT_EQ(n(1, 0), 12);  // three times the value of the nearest, which is constant about it
  EXPECT_EQ(n(1, 1), 0);

  const auto far = reconstruct(points_of(points), points_of(targets),
                               {.neighbours = Radius{10}, .max_distance = 2});
  EXPECT_EQ(far.report()[1].status, FitStatus::too_far);
  EXPECT_TRUE(std::isnan(std::get<0>(far.operators(functional)).apply(field_of(u))(1, 0)));
}

TEST(OwnFunctionalOptions, TheSameBitsForAnyNumberOfThreads) {
  const auto points = random_points<double, 3>(4000, 1),
             targets = random_points<double, 3>(1500, 2);
  std::vector<std::vector<double>> numbers;
  for (const int threads : {1, 2, 5}) {
    const auto fit =
        reconstruct(points_of(points), points_of(targets), {.degree = 2, .threads = threads});
    numbers.push_back(
        numbers_of(std::get<0>(fit.operators(F::gradient.at({{0.01, 0, 0}, {0, 0.01, 0}})))));
  }
  EXPECT_EQ(numbers[0], numbers[1]);
  EXPECT_EQ(numbers[0], numbers[2]);
}

TEST(OwnFunctionalOptions, MistakesAreNamed) {
  const auto points = random_points<double, 2>(50, 1);
  const auto fit = reconstruct(points_of(points), points_of(points), {.degree = 2});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of([] { F::cell_average({-1, 1}); }), HasSubstr("must not be negative"));
  EXPECT_THAT(message_of([&] { F::cell_average({nan, 1}); }), HasSubstr("must be finite"));
  EXPECT_THAT(message_of([&] { F::line_integral({0, 0}, {nan, 1}); }), HasSubstr("must be finite"));
  EXPECT_THAT(message_of([&] { F::value.at({{0, nan}}); }), HasSubstr("must be finite"));
  EXPECT_THAT(message_of([&] { F::value.at({}); }), HasSubstr("must be at least one"));
  EXPECT_THAT(message_of([] { F::cell_average({1e-80, 1}); }), HasSubstr("underflow"));
  EXPECT_THAT(message_of([] { F::line_integral({0, 0}, {-1e-80, 1}); }), HasSubstr("underflow"));
  EXPECT_THAT(message_of([] { F::gradient.at({{0, 1e-80}}); }), HasSubstr("underflow"));
  EXPECT_THAT(message_of([] { OwnFunctional::of({}); }), HasSubstr("must be a function"));
  EXPECT_THAT(message_of([&] {
                fit.operators(F::cell_average({1, 1, 1}));
              }),
              HasSubstr("must be 0 along axes that the points do not have"));
  EXPECT_THAT(message_of([&] {
                fit.operators(F::value.at({{0, 0, 1}}));
              }),
              HasSubstr("must be 0 along axes"));
  EXPECT_THAT(message_of([&] { fit.operators(F::partial(1, 1, 1)); }),
              HasSubstr("must be an axis of the points"));
  EXPECT_THAT(message_of([&] { F::own(0, [](std::size_t, const Powers&, std::span<double>) {}); }),
              HasSubstr("must be at least 1"));
  EXPECT_THAT(message_of([&] {
                fit.operators(F::own([&](std::size_t t, const Powers& n) {
                  return t == 17 && n[0] == 1 && n[1] == 1 ? nan : 1;
                }));
              }),
              HasSubstr("powers (1, 1, 0) at target 17 = nan: must be finite"));
  // Numbers that are not written are not taken for zeros.
  EXPECT_THAT(message_of([&] {
                fit.operators(F::own(
                    2, [](std::size_t, const Powers&, std::span<double> out) { out[0] = 1; }));
              }),
              HasSubstr("must be finite"));
}

// The fourth derivative of (x / L)^4 in float: 24 / L^4 is right, or below the normal numbers and
// refused.
TEST(OwnFunctionalOptions, HighOrdersInLargeUnitsAreRightOrRefused) {
  for (const float length : {1.0f, 1e5f, 1e9f, 1e11f, 1e12f}) {
    auto points = random_points<float, 2>(400, 1);
    std::vector<float> u;
    for (auto& x : points) {
      u.push_back(x[0] * x[0] * x[0] * x[0]);
      for (float& c : x) c *= length;
    }
    const PointList<float, 2> target{{0.5f * length, 0.5f * length}};
    const auto fit = reconstruct(points_of(points), points_of(target),
                                 {.degree = 4, .neighbours = Radius{0.4 * length}});
    const auto fourth = [&] {
      const auto [partial] = fit.operators(Functional::partial(4));
      return static_cast<double>(partial.apply(field_of(u))(0, 0)) * length * length * length *
             length;
    };
    if (length < 1e10f)
      EXPECT_NEAR(fourth(), 24, 0.5) << length;
    else
      EXPECT_THROW(fourth(), InvalidArgument) << length;
  }
}

}  // namespace
}  // namespace recon::testing
