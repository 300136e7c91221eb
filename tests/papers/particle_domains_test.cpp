// Shape functions averaged over particle domains: the formulas of Gong (2015), chapter 6, and of
// Tran et al. (2019), section 3.1, as printed and as they must be. Both are decided by fields they
// must reproduce: the average slope of x is 1, the average of 1 is 1.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>

namespace recon {
namespace {

using Vector = Eigen::Vector2d;

// The bracket that (6.27) of Gong and (24) of Tran et al. share, for the field f.
template <class Field>
Vector bracket(const Field& f, const std::array<Vector, 4>& corner, const Vector& r1,
               const Vector& r2) {
  return (f(corner[0]) - f(corner[2])) * Vector(r1[1] - r2[1], r2[0] - r1[0]) +
         (f(corner[1]) - f(corner[3])) * Vector(r1[1] + r2[1], -r1[0] - r2[0]);
}

// The corners x_p -+ a -+ b, counter-clockwise.
std::array<Vector, 4> corners(const Vector& x, const Vector& a, const Vector& b) {
  return {x - a - b, x + a - b, x + a + b, x - a + b};
}

double cross(const Vector& a, const Vector& b) {
  return a[0] * b[1] - a[1] * b[0];
}

const Vector x_p(0.3, 0.7), side_1(0.2, 0.05), side_2(-0.03, 0.16), slope(1.5, -0.4);

double linear(const Vector& x) {
  return 2 + slope.dot(x);
}

// r_1, r_2 are whole sides. With half sides the domain has four times their product, and twice the
// gradient is missing.
TEST(Gong2015Equation627, IsOfWholeSides) {
  const double volume = cross(side_1, side_2);
  const auto corner = corners(x_p, side_1 / 2, side_2 / 2);
  EXPECT_LE((bracket(linear, corner, side_1, side_2) / (2 * volume) - slope).norm(), 1e-13);
  const Vector halves = bracket(linear, corner, side_1 / 2, side_2 / 2) / (2 * volume);
  EXPECT_LE((halves - slope / 2).norm(), 1e-13);
}

// (22) has half sides, so that the factor of (24) is 1 / V_p, not 1 / (2 V_p).
TEST(Tran2019Equation24, HasTheFactorOfHalfSides) {
  const Vector r1 = side_1 / 2, r2 = side_2 / 2;
  const double V_p = 4 * cross(r1, r2);
  const Vector sum = bracket(linear, corners(x_p, r1, r2), r1, r2);
  EXPECT_LE((sum / V_p - slope).norm(), 1e-13);
  EXPECT_LE((sum / (2 * V_p) - slope / 2).norm(), 1e-13);  // as printed
}

// (6.29), (6.30): the weights of the corners of a quadrilateral sum to 1; as printed, to
// 1 / (6 Omega_p), with areas and numbers added.
TEST(Gong2015Equation629, WeightsSumToOne) {
  const Vector x1(0, 0), x2(1, 0.1), x3(1.1, 0.8), x4(-0.1, 0.9);
  const double area = cross(x3 - x1, x4 - x2) / 2;
  const double a = (x4 - x1)[0] * (x2 - x3)[1] - (x2 - x3)[0] * (x4 - x1)[1];
  const double b = (x3 - x4)[0] * (x1 - x2)[1] - (x1 - x2)[0] * (x3 - x4)[1];
  const auto weights = [&](double first) {
    return Eigen::Vector4d(
        Eigen::Vector4d(first - a - b, first - a + b, first + a + b, first + a - b) / (24 * area));
  };
  EXPECT_NEAR(weights(6 * area).sum(), 1, 1e-14);
  EXPECT_NEAR(weights(1).sum(), 1 / (6 * area), 1e-14);
  // And they give the centroid, which is that of two triangles.
  const Eigen::Vector4d w = weights(6 * area);
  const double lower = cross(x2 - x1, x3 - x1) / 2, upper = cross(x3 - x1, x4 - x1) / 2;
  const Vector centroid = (lower * (x1 + x2 + x3) + upper * (x1 + x3 + x4)) / (3 * area);
  EXPECT_LE((w[0] * x1 + w[1] * x2 + w[2] * x3 + w[3] * x4 - centroid).norm(), 1e-14);
}

// (6.33), (6.34) in 1-D: the average of a linear function is the mean of its ends, without 1 /
// Omega_p; that of its slope is the difference of its ends over Omega_p.
TEST(Gong2015Equation633, IsTheMeanOfTheEnds) {
  const double x1 = 0.3, x2 = 0.37, omega = x2 - x1;
  const auto N = [](double x) { return 1 - x; };
  double average = 0;  // midpoint rule: exact for linear functions
  for (int i = 0; i < 10; ++i) average += N(x1 + (i + 0.5) * omega / 10) / 10;
  EXPECT_NEAR((N(x1) + N(x2)) / 2, average, 1e-15);
  EXPECT_NEAR((N(x1) + N(x2)) / (2 * omega), average / omega, 1e-13);  // as printed
  EXPECT_NEAR((N(x2) - N(x1)) / omega, -1, 1e-13);
}

}  // namespace
}  // namespace recon
