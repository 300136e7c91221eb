// Formulas of Andersen, Andersen (2007) that have to be corrected, as printed and as they must be.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace recon {
namespace {

// Hat functions of the nodes 0, 1, 2 at x.
Eigen::Vector3d hats(double x) {
  return Eigen::Vector3d(std::max(0.0, 1 - x), 1 - std::abs(x - 1), std::max(0.0, x - 1));
}

// (19), (20), (39): velocities change by sum_ij Phi_i(x_p) m_ij^-1 f_j. With Phi_j, as printed, a
// uniform acceleration of the nodes is not that of the particles; only diagonal masses hide it.
TEST(Andersen2007Equation19, TakesTheFunctionOfTheAcceleratedNode) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const double x : {0.1, 0.4, 0.8, 1.1, 1.7, 1.9}) M += hats(x) * hats(x).transpose();
  const auto right = [](const Eigen::Matrix3d& inverse, const Eigen::Vector3d& f, double x) {
    return hats(x).dot(inverse * f);
  };
  const auto printed = [](const Eigen::Matrix3d& inverse, const Eigen::Vector3d& f, double x) {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) sum += inverse(i, j) * hats(x)[j] * f[j];
    return sum;
  };
  const Eigen::Matrix3d lumped = M.rowwise().sum().asDiagonal();
  const Eigen::Vector3d a = Eigen::Vector3d::Constant(3);
  for (const double x : {0.05, 1.0}) {
    EXPECT_NEAR(right(M.inverse(), M * a, x), 3, 1e-13);
    EXPECT_GT(std::abs(printed(M.inverse(), M * a, x) - 3), 0.1);
    EXPECT_NEAR(printed(lumped.inverse(), lumped * a, x), 3, 1e-13);
  }
}

// (33), (34) with the origin at the free end, x towards the clamp, y down, c half the height.
// Figure 1 has the origin at the clamp.
TEST(Andersen2007Equation33, HasItsOriginAtTheFreeEnd) {
  constexpr double L = 8, H = 1, c = H / 2, P = 100, E = 3e5, nu = 0.3, step = 1e-3;
  constexpr double G = E / (2 * (1 + nu)), I = 2 * c * c * c / 3;
  const auto u = [&](double x, double y) {
    return -P * x * x * y / (2 * E * I) - nu * P * y * y * y / (6 * E * I) +
           P * y * y * y / (6 * G * I) + (P * L * L / (2 * E * I) - P * c * c / (2 * G * I)) * y;
  };
  const auto v = [&](double x, double y) {
    return nu * P * x * y * y / (2 * E * I) + P * x * x * x / (6 * E * I) -
           P * L * L * x / (2 * E * I) + P * L * L * L / (3 * E * I);
  };
  const double tip = P * L * L * L / (3 * E * I);
  // At rest and level at x = L; at x = 0 it is the tip.
  EXPECT_NEAR(v(L, 0), 0, 1e-12 * tip);
  EXPECT_NEAR((v(L + step, 0) - v(L - step, 0)) / (2 * step), 0, 1e-6 * tip);
  EXPECT_NEAR(v(0, 0), tip, 1e-12 * tip);
  // The shear strain vanishes at y = +-c: these are the faces, H / 2 from the axis.
  for (const double y : {-c, 0.0, c}) {
    const double shear = (u(2, y + step) - u(2, y - step)) / (2 * step) +
                         (v(2 + step, y) - v(2 - step, y)) / (2 * step);
    EXPECT_NEAR(shear, -P / (2 * G * I) * (c * c - y * y), 1e-4 * P / (G * I));
  }
}

// (40): places change by dt sum_i (p_i / m_i) Phi_i, and p_i = m_i v_i where no force acts. On a
// three-node element, with a particle beyond its quarter the mass of a node is negative: a
// translation is exact all the same, for the signs of p_i and m_i cancel.
TEST(Andersen2007Equation40, DividesByTheMassOfTheNode) {
  const auto functions = [](double xi) {
    return Eigen::Vector3d(xi * (xi - 1) / 2, 1 - xi * xi, xi * (xi + 1) / 2);
  };
  constexpr double m_p = 2, v = 3;
  const double place[2] = {0.5, 0.7};
  Eigen::Vector3d mass = Eigen::Vector3d::Zero();
  for (const double xi : place) mass += m_p * functions(xi);
  ASSERT_LT(mass[0], 0);
  const Eigen::Vector3d momentum = v * mass;
  for (const double xi : place) {
    EXPECT_NEAR(momentum.cwiseQuotient(mass).dot(functions(xi)), v, 1e-13);
    EXPECT_GT(std::abs(momentum.dot(functions(xi)) / m_p - v), 0.1);  // as printed
  }
}

}  // namespace
}  // namespace recon
