// The manufactured solutions: against the balance of momentum, and against the sources' formulas.
#include "recon/runs/manufactured.hpp"

#include <cmath>
#include <numbers>

#include "mpm/support.hpp"

namespace recon::mpm::test {
namespace {

constexpr double pi = std::numbers::pi;
const NeoHookean steel{Lame::from(1e7, 0.3)};
constexpr double density = 1000;

template <int D>
Matrix<D> first_piola(const NeoHookean& m, const Matrix<D>& F) {
  return m.mu * F + (m.lambda * std::log(F.determinant()) - m.mu) * F.inverse().transpose();
}

// rho0 a = Div P + rho0 b, with all derivatives by central differences of displacement and F.
template <int D>
void expect_balance(const std::string& name, const NeoHookean& material, double G, double from,
                    double to) {
  const auto exact = make_manufactured<D>(name, G, material, density);
  std::mt19937 random(11);
  for (int round = 0; round < 40; ++round) {
    Vector<D> X;
    for (int d = 0; d < D; ++d) X[d] = uniform(random, from, to);
    const double t = uniform(random, 0, exact->period()), dt = 1e-4 * exact->period(), dx = 1e-4;
    const auto now = exact->at(X, t), after = exact->at(X, t + dt), before = exact->at(X, t - dt);
    const Vector<D> velocity = (after.displacement - before.displacement) / (2 * dt);
    const Vector<D> a = (after.velocity - before.velocity) / (2 * dt);
    Vector<D> divergence = Vector<D>::Zero();
    Matrix<D> F = Matrix<D>::Identity(), rate = Matrix<D>::Zero();
    for (int d = 0; d < D; ++d) {
      const auto up = exact->at(X + dx * Vector<D>::Unit(d), t),
                 down = exact->at(X - dx * Vector<D>::Unit(d), t);
      F.col(d) += (up.displacement - down.displacement) / (2 * dx);
      rate.col(d) = (up.velocity - down.velocity) / (2 * dx);
      divergence +=
          (first_piola<D>(material, up.F) - first_piola<D>(material, down.F)).col(d) / (2 * dx);
    }
    const double speed = G / exact->period(), size = speed / exact->period() * 40;
    EXPECT_LE((velocity - now.velocity).norm(), 1e-4 * speed * 10) << name;
    EXPECT_LE((F - now.F).norm(), 1e-4) << name;
    EXPECT_LE((rate * now.F.inverse() - now.velocity_gradient).norm(), 1e-3 * speed * 100) << name;
    EXPECT_LE((a - divergence / density - now.body_force).norm(), 1e-3 * size) << name;
  }
}

TEST(Manufactured, MomentumIsBalanced) {
  expect_balance<1>("vibration", steel, 0.1, 0, 1);
  expect_balance<2>("vibration", steel, 0.1, 0, 1);
  expect_balance<3>("vibration", steel, 0.1, 0, 1);
  expect_balance<2>("axis_vibration", steel, 0.1, 0, 1);
  expect_balance<2>("wave_along_x", steel, 0.1, 0, 1);
  expect_balance<2>("ring", NeoHookean{Lame::from(1e7, 0)}, 0.1, 0.3, 0.42);
  expect_balance<2>("vortex", NeoHookean{Lame::from(1000, 0.3)}, 1, 0.55, 0.85);
}

// Gong 2015, eq. 4.39 and 4.46.
TEST(Manufactured, VibrationHasTheSourcesBodyForce) {
  const auto exact = make_manufactured<2>("vibration", 0.1, steel, density);
  const double c = std::sqrt(1e7 / density), lambda = steel.lambda, mu = steel.mu;
  for (const double t : {0.0013, 0.004, 0.0171}) {
    const Vector<2> X(0.3, 0.85);
    const auto state = exact->at(X, t);
    Vector<2> U, F, B;
    for (int d = 0; d < 2; ++d) {
      U[d] = 0.1 * std::sin(pi * X[d]) * std::sin(c * pi * t);
      F[d] = 1 + 0.1 * pi * std::cos(pi * X[d]) * std::sin(c * pi * t);
    }
    for (int d = 0; d < 2; ++d)
      B[d] = pi * pi * U[d] / density *
             (lambda / (F[d] * F[d]) * (1 - std::log(F[0] * F[1])) + mu * (1 + 1 / (F[d] * F[d])) -
              1e7);
    EXPECT_LE((state.body_force - B).norm(), 1e-10 * B.norm());
  }
}

// Tran et al. 2019, eq. 51 with pi^2 for pi (docs/misprints.md, T14). It is for the bar: in 1-D.
TEST(Manufactured, AxisVibrationHasTheSourcesBodyForce) {
  const auto exact = make_manufactured<1>("axis_vibration", 0.1, steel, density);
  const double c2 = 1e7 / density, lambda = steel.lambda, mu = steel.mu, t = 0.0037, X = 0.21;
  const double u = 0.1 * std::sin(2 * pi * X) * std::sin(std::sqrt(c2) * pi * t);
  const double F = 1 + 0.2 * pi * std::cos(2 * pi * X) * std::sin(std::sqrt(c2) * pi * t);
  const double b =
      pi * pi * u *
      (4 * mu / density - c2 - 4 * (lambda * (std::log(F) - 1) - mu) / (density * F * F));
  EXPECT_NEAR(exact->at(Vector<1>(X), t).body_force[0], b, 1e-10 * std::abs(b));
}

// A bar's wave, whatever the dimension: nothing moves across it, and no force is needed there.
TEST(Manufactured, TheWaveAlongXIsThatOfABar) {
  const auto bar = make_manufactured<1>("axis_vibration", 0.1, steel, density);
  const auto square = make_manufactured<2>("wave_along_x", 0.1, steel, density);
  const auto cube = make_manufactured<3>("wave_along_x", 0.1, steel, density);
  for (const double X : {0.0, 0.21, 0.8})
    for (const double t : {0.0037, 0.012}) {
      const auto a = bar->at(Vector<1>(X), t);
      const auto b = square->at(Vector<2>(X, 0.3), t);
      const auto c = cube->at(Vector<3>(X, 0.3, 0.9), t);
      EXPECT_NEAR(b.displacement[0], a.displacement[0], 1e-16);
      EXPECT_NEAR(b.body_force[0], a.body_force[0], 1e-10 * std::abs(a.body_force[0]) + 1e-10);
      EXPECT_NEAR(c.body_force[0], a.body_force[0], 1e-10 * std::abs(a.body_force[0]) + 1e-10);
      EXPECT_EQ(b.displacement[1], 0);
      EXPECT_EQ(b.body_force[1], 0);
      EXPECT_EQ(c.velocity.tail<2>().norm() + c.body_force.tail<2>().norm(), 0);
      EXPECT_EQ(b.F(1, 1), 1);
    }
}

// Tran et al. 2019, eq. 72-74 as corrected (docs/misprints.md, T26, T27).
TEST(Manufactured, VortexHasTheSourcesBodyForce) {
  const NeoHookean soft{Lame::from(1000, 0.3)};
  const double A = 1, c = 1, mu = soft.mu;
  const auto exact = make_manufactured<2>("vortex", A, soft, density);
  for (const double R : {0.8, 0.95, 1.1, 1.2})
    for (const double angle : {0.3, 2.0, 4.4}) {
      const double t = 0.37, s = std::sin(c * pi * t), k = std::cos(c * pi * t);
      const double p = (4 * R - 5) * (4 * R - 3);
      const double turn = A * s * (1 - 32 * std::pow(R - 1, 2) + 256 * std::pow(R - 1, 4));
      const double b_r =
          R * A * A * p * p *
          (-c * c * pi * pi * k * k * p * p + 4096 * mu / density * std::pow(R - 1, 2) * s * s);
      const double b_t = -A * s *
                         (R * c * c * pi * pi * p * p +
                          64 * mu / density * (96 * R * R * R - 240 * R * R + 188 * R - 45));
      const double beta = angle + turn;
      const Vector<2> b(b_r * std::cos(beta) - b_t * std::sin(beta),
                        b_r * std::sin(beta) + b_t * std::cos(beta));
      const auto state = exact->at(Vector<2>(R * std::cos(angle), R * std::sin(angle)), t);
      EXPECT_LE((state.body_force - b).norm(), 1e-9 * (1 + b.norm())) << R;
    }
}

// The surfaces of the ring carry no traction when poisson = 0.
TEST(Manufactured, RingHasNoTraction) {
  const NeoHookean cork{Lame::from(1e7, 0)};
  const auto exact = make_manufactured<2>("ring", 0.1, cork, density);
  for (const double R : {0.4, 0.6}) {
    const Vector<2> N(0.6, 0.8);
    const auto state = exact->at(R * N, 0.0031);
    EXPECT_LE((first_piola<2>(cork, state.F) * N).norm(), 1e-8 * cork.mu);
  }
}

TEST(Manufactured, WrongNamesAreAnswered) {
  EXPECT_THROW(make_manufactured<2>("vibrations", 0.1, steel, density), InvalidArgument);
  EXPECT_THROW(make_manufactured<1>("vortex", 0.1, steel, density), InvalidArgument);
}

}  // namespace
}  // namespace recon::mpm::test
