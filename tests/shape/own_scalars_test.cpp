// Number types of one's own: the least that is asked of one, and one of fifty digits.
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <compare>

#include "recon/points/generate.hpp"
#include "recon/shape/shape_function.hpp"
#include "support/message_of.hpp"

namespace own {

// No more than docs/concepts.md asks for: functions are found by the arguments, nothing
// converts by itself.
class Number {
 public:
  Number() = default;
  constexpr explicit Number(double value) : value_(value) {}
  explicit operator double() const { return value_; }

  Number operator-() const { return Number(-value_); }
  Number& operator+=(const Number& b) { return *this = Number(value_ + b.value_); }
  Number& operator-=(const Number& b) { return *this = Number(value_ - b.value_); }
  Number& operator*=(const Number& b) { return *this = Number(value_ * b.value_); }
  Number& operator/=(const Number& b) { return *this = Number(value_ / b.value_); }
  friend Number operator+(Number a, const Number& b) { return a += b; }
  friend Number operator-(Number a, const Number& b) { return a -= b; }
  friend Number operator*(Number a, const Number& b) { return a *= b; }
  friend Number operator/(Number a, const Number& b) { return a /= b; }
  friend auto operator<=>(const Number&, const Number&) = default;
  friend Number sqrt(const Number& a) { return Number(std::sqrt(a.value_)); }
  friend Number abs(const Number& a) { return Number(std::fabs(a.value_)); }

 private:
  double value_ = 0;
};

}  // namespace own

template <>
struct std::numeric_limits<own::Number> {
  static constexpr bool is_specialized = true;
  static constexpr own::Number epsilon() {
    return own::Number(std::numeric_limits<double>::epsilon());
  }
  static constexpr own::Number min() { return own::Number(std::numeric_limits<double>::min()); }
  static constexpr own::Number max() { return own::Number(std::numeric_limits<double>::max()); }
};

namespace recon {
namespace {

template <class T>
class OwnScalar : public ::testing::Test {};
using OwnScalars = ::testing::Types<own::Number, boost::multiprecision::cpp_bin_float_50>;
TYPED_TEST_SUITE(OwnScalar, OwnScalars);

// x y and its gradient to the last digits of the type, on a cloud that fills the plane and on one
// that lies on a line, where Gram-Schmidt has to look closer.
TYPED_TEST(OwnScalar, ReproducesToItsPrecision) {
  using T = TypeParam;
  const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
  const auto points = random_points<double, 2>(60, 3), line = diagonal_points<double, 2>(60, 3);
  std::vector<ParticleIndex> all(points.size());
  for (std::size_t p = 0; p < all.size(); ++p) all[p] = static_cast<ParticleIndex>(p);
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
    ShapeEvaluator<Monomials<2, 2>, BSpline<3>, T> shapes(BSpline<3>{}, solver);
    const auto fit = [&](const PointList<double, 2>& list, const std::array<T, 2>& x, auto field) {
      const auto position = [&](ParticleIndex p) {
        return std::array<T, 2>{T(list[p][0]), T(list[p][1])};
      };
      const auto& shape = shapes.at(x, T(0.5), std::span<const ParticleIndex>(all), position);
      std::array<T, 3> sum{};
      for (std::size_t p = 0; p < all.size(); ++p) {
        const T u = field(position(all[p]));
        sum[0] += shape.value[p] * u;
        for (int d = 0; d < 2; ++d) sum[1 + d] += shape.gradient[p][d] * u;
      }
      return std::pair(sum, shape.report);
    };
    const auto near = [&](const T& value, double expected) {
      EXPECT_NEAR(static_cast<double>(T(value - T(expected))), 0, 2000 * eps) << name_of(solver);
    };
    const auto [product, report] =
        fit(points, {T(0.5), T(0.375)}, [](const auto& x) { return T(x[0] * x[1]); });
    EXPECT_EQ(report.status, FitStatus::full);
    EXPECT_EQ(report.gradient_rank, 2);
    near(product[0], 0.5 * 0.375);
    near(product[1], 0.375);
    near(product[2], 0.5);

    const auto [along, on_line] =
        fit(line, {T(0.5), T(0.5)}, [](const auto& x) { return T(x[0] + x[1]); });
    EXPECT_EQ(on_line.status, FitStatus::reduced);
    EXPECT_EQ(on_line.gradient_rank, 1);
    near(along[0], 1);
    near(along[1], 1);
    near(along[2], 1);
  }
}

TYPED_TEST(OwnScalar, SolversOfEigenAreRefused) {
  using Shapes = ShapeEvaluator<Monomials<1, 1>, BSpline<1>, TypeParam>;
  EXPECT_EQ(
      testing::message_of([] { Shapes(BSpline<1>{}, Solver::svd); }),
      "solver = svd: must be moment_matrix or gram_schmidt for a scalar that is not built in");
}

TYPED_TEST(OwnScalar, BadSupportIsNamed) {
  ShapeEvaluator<Monomials<1, 1>, BSpline<1>, TypeParam> shapes(BSpline<1>{});
  const auto position = [](ParticleIndex) { return std::array<TypeParam, 1>{}; };
  const auto message = testing::message_of([&] {
    shapes.at({TypeParam(0.0)}, TypeParam(-1.0), std::span<const ParticleIndex>(), position);
  });
  EXPECT_EQ(message, "rho = -1: must be positive and finite");
}

}  // namespace
}  // namespace recon
