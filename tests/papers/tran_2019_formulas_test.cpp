// Formulas of Tran et al. (2019) that have to be corrected, as printed and as they must be: section
// 2.1 on least squares, section 3.2 on what a map conserves, section 4 on manufactured solutions
// and tables. The neo-Hookean stress (45) is in neo_hookean_test.cpp, the gradient (24) in
// particle_domains_test.cpp.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "recon/points/generate.hpp"
#include "recon/recon.hpp"

namespace recon {
namespace {

constexpr double pi = std::numbers::pi;

template <class Function>
double derivative(const Function& f, double x, double step = 1e-5) {
  return (f(x + step) - f(x - step)) / (2 * step);
}

// (2), (3): the polynomials stand at x_p. At x, as printed, all particles have the same row, and
// the moment matrix has rank 1, however many they are.
TEST(Tran2019Equation2, TakesTheBasisAtTheParticles) {
  const auto points = random_points<double, 1>(20, 8);
  const PointList<double, 1> target{{0.4}};
  constexpr double rho = 0.5;
  Eigen::VectorXd u(points.size());
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero(), printed = moments;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  const Eigen::Vector2d here(1, 0.4);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double q = std::abs(0.4 - points[p][0]) / rho;
    double w;
    WeightFunction(Weight::cubic_b_spline).evaluate(&q, &w, nullptr, 1);
    const Eigen::Vector2d there(1, points[p][0]);
    u[p] = std::cos(3 * points[p][0]);
    moments += w * there * there.transpose();
    printed += w * here * here.transpose();
    sum += w * there * u[p];
  }
  const auto fit =
      reconstruct(points_of(points), points_of(target), {.degree = 1, .neighbours = Radius{rho}});
  EXPECT_NEAR(here.dot(moments.inverse() * sum), fit.apply(field_of(u))(0, 0), 1e-13);
  EXPECT_EQ(Eigen::FullPivLU<Eigen::Matrix2d>(printed).setThreshold(1e-12).rank(), 1);
}

// A grid of unequal particles in 1-D: the least-squares map, and the mass-weighted one of (30).
struct Mapped {
  Eigen::VectorXd mass, velocity, node_mass, fitted, weighted;
  double sum_of_phi = 0;  // farthest from 1

  Mapped() {
    constexpr int cells = 10;
    const auto points = jittered_points<double, 1>(40, 0.5, 3);
    PointList<double, 1> nodes;
    for (int i = 0; i <= cells; ++i) nodes.push_back({double(i) / cells});
    mass.resize(40);
    velocity.resize(40);
    node_mass = weighted = Eigen::VectorXd::Zero(cells + 1);
    for (int p = 0; p < 40; ++p) {
      const double x = points[p][0];
      mass[p] = 1 + 0.5 * std::sin(9 * x);
      velocity[p] = std::cos(5 * x);  // of both signs
      for (int i = 0; i <= cells; ++i) {
        const double N = std::max(0.0, 1 - std::abs(x * cells - i));
        node_mass[i] += N * mass[p];
        weighted[i] += N * mass[p] * velocity[p];
      }
    }
    weighted.array() /= node_mass.array();
    const auto fit = reconstruct(points_of(points), points_of(nodes),
                                 {.degree = 1, .neighbours = Radius{2.0 / cells}});
    fitted = fit.apply(field_of(velocity));
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(40);
    sum_of_phi = (fit.apply(field_of(ones)).array() - 1).abs().maxCoeff();
  }
};

// The text below (31): phi is a partition of unity, sum_p phi_ip = 1. Momentum is lost because
// sum_i m_i phi_ip is not m_p.
TEST(Tran2019Equation31, IsAPartitionOfUnityAndLosesMomentum) {
  const Mapped maps;
  const double momentum = maps.mass.dot(maps.velocity);
  EXPECT_LE(maps.sum_of_phi, 1e-13);
  EXPECT_GT(std::abs(maps.node_mass.dot(maps.fitted) - momentum), 1e-3 * maps.mass.sum());
  EXPECT_NEAR(maps.node_mass.dot(maps.weighted), momentum, 1e-13 * maps.mass.sum());
}

// (52), (53): sums of m |v| are no momentum. The mass-weighted map conserves momentum, and changes
// them.
TEST(Tran2019Equation52, SumsOfSpeedsAreNoMomentum) {
  const Mapped maps;
  const double on_particles = maps.mass.dot(maps.velocity.cwiseAbs());
  const double on_nodes = maps.node_mass.dot(maps.weighted.cwiseAbs());
  EXPECT_GT(std::abs(on_nodes - on_particles), 1e-3 * on_particles);
}

// Section 4.2, the bar of the length L, not necessarily 1.
struct Vibration {
  static constexpr double A = 0.1, L = 2, E = 1e7, rho = 1000, t = 0.0061;
  static constexpr double lambda = 5.77e6, mu = 3.85e6;
  const double c = std::sqrt(E / rho);

  double u(double X, double time) const {
    return A * std::sin(2 * pi * X / L) * std::sin(c * pi * time / L);
  }
  double F(double X, double time) const {
    return 1 + 2 * A * pi / L * std::cos(2 * pi * X / L) * std::sin(c * pi * time / L);
  }
};

// (49) has lost 1 / L.
TEST(Tran2019Equation49, DividesByTheLength) {
  const Vibration bar;
  const double X = 0.3;
  const double v = derivative([&](double time) { return bar.u(X, time); }, bar.t, 1e-7);
  const double printed =
      bar.A * bar.c * pi * std::sin(2 * pi * X / bar.L) * std::cos(bar.c * pi * bar.t / bar.L);
  EXPECT_NEAR(printed / bar.L, v, 1e-6 * std::abs(v));
}

// (51): pi^2, where pi is printed. b = a - (dP / dX) / rho_0 with P of (45) in 1-D.
TEST(Tran2019Equation51, HasTheSquareOfPi) {
  const Vibration bar;
  const double X = 0.3, c2 = bar.c * bar.c;
  const double a = -c2 * pi * pi / (bar.L * bar.L) * bar.u(X, bar.t);
  const auto P = [&](double at) {
    const double F = bar.F(at, bar.t);
    return bar.lambda * std::log(F) / F + bar.mu * (F - 1 / F);
  };
  const double b = a - derivative(P, X) / bar.rho, F = bar.F(X, bar.t);
  const double printed = pi * bar.u(X, bar.t) / (bar.L * bar.L) *
                         (4 * bar.mu / bar.rho - c2 -
                          4 * (bar.lambda * (std::log(F) - 1) - bar.mu) / (bar.rho * F * F));
  EXPECT_NEAR(pi * printed, b, 1e-6 * std::abs(b));
}

// Tables 2 to 4: "10e7" and "10e3" are 1e7 and 1e3. The constants and the final time, one period 2
// L / c, say so; and lambda, mu of table 2 are those of poisson = 0.3, which is printed as 0.
TEST(Tran2019Tables, YoungsModuliAreTenTimesLess) {
  const auto lambda = [](double E, double nu) { return E * nu / ((1 + nu) * (1 - 2 * nu)); };
  const auto mu = [](double E, double nu) { return E / (2 * (1 + nu)); };
  EXPECT_NEAR(lambda(1e7, 0.3), 5.77e6, 0.005e6);
  EXPECT_NEAR(mu(1e7, 0.3), 3.85e6, 0.005e6);
  EXPECT_NEAR(2 / std::sqrt(1e7 / 1000), 0.02, 1e-15);
  EXPECT_NEAR(lambda(1e3, 0.3), 5.77e2, 0.005e2);
  EXPECT_NEAR(mu(1e3, 0.3), 3.85e2, 0.005e2);
  EXPECT_EQ(lambda(1e7, 0), 0);  // the printed poisson = 0 has another pair
}

// (55) with Hooke's strain F - 1 is not the energy of (45): at A = 0.1 the sum over the bar of
// section 4.2 (L = 1, poisson = 0.3, quarter of a period) is 13 % less.
TEST(Tran2019Equation55, UnderestimatesTheEnergy) {
  constexpr double lambda = 5.77e6, mu = 3.85e6;
  double exact = 0, printed = 0;
  for (int i = 0; i < 1000; ++i) {
    const double F = 1 + 0.2 * pi * std::cos(2 * pi * (i + 0.5) / 1000);
    const double kirchhoff = lambda * std::log(F) + mu * (F * F - 1);  // sigma V / V_0
    exact += lambda * std::pow(std::log(F), 2) / 2 + mu * ((F * F - 1) / 2 - std::log(F));
    printed += kirchhoff * (F - 1) / 2;
  }
  EXPECT_NEAR(printed / exact, 0.87, 0.01);
}

// Section 4.3, the radial displacement over A sin(...), with c_1 r where c_1 r_1 is printed.
struct Ring {
  static constexpr double r_i = 0.4, r_o = 0.6;
  static constexpr double c_1 = -6 * r_i / (r_o * (r_o - 3 * r_i)),
                          c_2 = 3 * (r_i + r_o) / (r_o * r_o * (r_o - 3 * r_i)),
                          c_3 = -2 / (r_o * r_o * (r_o - 3 * r_i));
  static double u(double r) { return c_3 * r * r * r + c_2 * r * r + c_1 * r; }
};

// (57), (58): then u is 1 outside and its slope vanishes at both faces. A constant, as printed,
// leaves the slope -c_1 there.
TEST(Tran2019Equation57, TheLastTermIsLinear) {
  EXPECT_NEAR(Ring::u(Ring::r_o), 1, 1e-14);
  for (const double r : {Ring::r_i, Ring::r_o}) {
    EXPECT_NEAR(derivative(Ring::u, r), 0, 1e-8);
    const auto printed = [](double at) { return Ring::u(at) - Ring::c_1 * at; };
    EXPECT_NEAR(derivative(printed, r), -Ring::c_1, 1e-8);
  }
}

// Table 3: the faces of the ring are free of traction for lambda = 0 only, which poisson = 0 gives;
// its lambda and mu are those of 0.3.
TEST(Tran2019Table3, LambdaIsZero) {
  const auto traction = [](double lambda, double mu, double r) {  // P_rr, A sin(...) = 0.1
    const double F_r = 1 + 0.1 * derivative(Ring::u, r), F_t = 1 + 0.1 * Ring::u(r) / r;
    return lambda * std::log(F_r * F_t) / F_r + mu * (F_r - 1 / F_r);
  };
  for (const double r : {Ring::r_i, Ring::r_o}) {
    EXPECT_NEAR(traction(0, 5e6, r), 0, 1);
    EXPECT_GT(std::abs(traction(5.77e6, 3.85e6, r)), 1e5);
  }
}

// Section 4.4, the vortex, with A = 2 so that A and A^2 differ.
struct Vortex {
  static constexpr double A = 2, c = 1;
  Eigen::Vector2d X;
  double R, angle;

  explicit Vortex(const Eigen::Vector2d& at)
      : X(at), R(at.norm()), angle(std::atan2(at[1], at[0])) {}
  static double h(double R) { return 1 - 32 * std::pow(R - 1, 2) + 256 * std::pow(R - 1, 4); }
  double alpha(double t) const { return A * std::sin(c * pi * t) * h(R); }
  // (65) as corrected: X is turned by alpha.
  Eigen::Vector2d displacement(double t) const { return Eigen::Rotation2Dd(alpha(t)) * X - X; }
};

// (61): the angle is atan2(Y, X), for (X, Y) = R (cos, sin).
TEST(Tran2019Equation61, IsTheAngleOfTheParticle) {
  const Vortex vortex({0.3, 0.9});
  const auto place = [&](double angle) {
    return Eigen::Vector2d(vortex.R * std::cos(angle), vortex.R * std::sin(angle));
  };
  EXPECT_LE((place(std::atan2(0.9, 0.3)) - vortex.X).norm(), 1e-15);
  EXPECT_GT((place(std::atan2(0.3, 0.9)) - vortex.X).norm(), 0.5);  // arctan(X, Y), as printed
}

// (65): no displacement at the start, and the radius stays. As printed it is A times the new place.
TEST(Tran2019Equation65, IsADisplacement) {
  const Vortex vortex({0.3, 0.9});
  const auto printed = [&](double t) {
    return Eigen::Vector2d(Vortex::A * (Eigen::Rotation2Dd(vortex.alpha(t)) * vortex.X));
  };
  EXPECT_LE(vortex.displacement(0).norm(), 1e-15);
  EXPECT_NEAR((vortex.X + vortex.displacement(0.3)).norm(), vortex.R, 1e-14);
  EXPECT_GT(printed(0).norm(), 1);
}

// (66): A, not A^2, before the velocity.
TEST(Tran2019Equation66, IsTheRateOfTheDisplacement) {
  const Vortex vortex({0.3, 0.9});
  const double t = 0.2, step = 1e-6;
  const Eigen::Vector2d v =
      (vortex.displacement(t + step) - vortex.displacement(t - step)) / (2 * step);
  const double rate = pi * Vortex::c * Vortex::h(vortex.R) * std::cos(pi * Vortex::c * t);
  const double sin = std::sin(vortex.alpha(t)), cos = std::cos(vortex.alpha(t));
  const Eigen::Vector2d across(-vortex.X[0] * sin - vortex.X[1] * cos,
                               vortex.X[0] * cos - vortex.X[1] * sin);
  EXPECT_LE((Vortex::A * rate * across - v).norm(), 1e-8);
  EXPECT_LE((Vortex::A * Vortex::A * rate * across - Vortex::A * v).norm(), 1e-8);  // as printed
}

// (68): -64 (R - 1), where -64 (-1 - R) is printed: h'(R), which the stress (46) of the motion has.
TEST(Tran2019Equation68, HasTheSlopeOfTheTurn) {
  constexpr double mu = 385, t = 0.2, step = 1e-6;
  const Eigen::Vector2d X(0.3, 0.9);
  Eigen::Matrix2d F = Eigen::Matrix2d::Identity();
  for (int d = 0; d < 2; ++d) {
    const Eigen::Vector2d change = step * Eigen::Vector2d::Unit(d);
    F.col(d) +=
        (Vortex(X + change).displacement(t) - Vortex(X - change).displacement(t)) / (2 * step);
  }
  EXPECT_NEAR(F.determinant(), 1, 1e-7);
  const Vortex vortex(X);
  const Eigen::Rotation2Dd q(vortex.angle + vortex.alpha(t));  // (70)
  const Eigen::Matrix2d stress = mu * (F * F.transpose() - Eigen::Matrix2d::Identity());
  const Eigen::Matrix2d polar = q.inverse() * stress * q.toRotationMatrix();
  const double size = Vortex::A * vortex.R * std::sin(pi * Vortex::c * t), R = vortex.R;
  const double slope = -64 * (R - 1) + 1024 * std::pow(R - 1, 3),
               printed = -64 * (-1 - R) + 1024 * std::pow(R - 1, 3);
  EXPECT_NEAR(polar(0, 0), 0, 1e-4);
  EXPECT_NEAR(polar(0, 1), mu * size * slope, 1e-4);
  EXPECT_NEAR(polar(1, 1), mu * std::pow(size * slope, 2), 1e-4);
  EXPECT_GT(std::abs(polar(0, 1) - mu * size * printed), mu);
}

}  // namespace
}  // namespace recon
