// Formulas of Gong (2015), chapters 4, 5 and 7, on the material point method in 1-D: as printed and
// as they must be. Mathematics alone: what recon's driver does is tested in tests/mpm.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace recon {
namespace {

constexpr double pi = std::numbers::pi;

double hat(double x, double node, double h) {
  return std::max(0.0, 1 - std::abs(x - node) / h);
}
double slope_of_hat(double x, double node, double h) {
  return std::abs(x - node) >= h ? 0 : x < node ? 1 / h : -1 / h;
}

// A bar of density rho on [0, 1] under the stress s x, four particles in each of ten cells. The
// balance of momentum is rho a = s, and at inner nodes m_i a_i = f_i must say so.
struct LinearStress {
  static constexpr double rho = 1000, s = 70, h = 0.1;
  double mass = 0, force = 0, printed_force = 0;  // of the node at 0.5

  LinearStress() {
    for (int p = 0; p < 40; ++p) {
      const double x = (p + 0.5) * h / 4, M = rho * h / 4, sigma = s * x;
      mass += M * hat(x, 0.5, h);
      force -= slope_of_hat(x, 0.5, h) * M / rho * sigma;
      printed_force -= slope_of_hat(x, 0.5, h) * M * sigma;  // stress taken for specific stress
    }
  }
};

// f_int with its minus, as (4.14) has it, and divided by the density. Then (4.21) adds it.
TEST(Gong2015Section44, InternalForceDividesByTheDensityAndIsAdded) {
  const LinearStress bar;
  EXPECT_NEAR(bar.force / bar.mass, bar.s / bar.rho, 1e-12);
  EXPECT_NEAR(bar.printed_force / bar.mass, bar.s, 1e-9);  // rho times too much
}

// (4.28), (5.23): F^{s+1} = (I + dt sum v_i grad N_i) F^s is the slope of the map x^s -> x^{s+1} of
// (4.26) where grad N is taken at x^s. At x^{s+1} it is that of another cell for points that cross.
TEST(Gong2015Equation428, TakesGradientsAtTheOldPlace) {
  constexpr double h = 0.25, dt = 0.1;
  const double v[5] = {0.2, 0.5, -0.1, 0.4, 0.3};
  const auto velocity = [&](double x) {
    double sum = 0;
    for (int i = 0; i < 5; ++i) sum += hat(x, i * h, h) * v[i];
    return sum;
  };
  const auto factor = [&](double x) {
    double sum = 1;
    for (int i = 0; i < 5; ++i) sum += dt * v[i] * slope_of_hat(x, i * h, h);
    return sum;
  };
  const double x = 0.24, step = 1e-6;  // moves across the node at 0.25
  const auto moved = [&](double from) { return from + dt * velocity(from); };
  ASSERT_GT(moved(x), h);
  const double slope = (moved(x + step) - moved(x - step)) / (2 * step);
  EXPECT_NEAR(factor(x), slope, 1e-9);
  EXPECT_GT(std::abs(factor(moved(x)) - slope), 0.1);
}

// Text after (4.39).
TEST(Gong2015Equation439, YoungsModulusOfLamesConstants) {
  for (const double nu : {0.1, 0.3, 0.45}) {
    const double E = 1e7, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
    EXPECT_NEAR(lambda * (1 + nu) * (1 - 2 * nu) / nu, E, 1e-8 * E);
    EXPECT_GT(std::abs(lambda * (1 + mu) * (1 - 2 * mu) / mu), 1e3 * E);  // printed: mu for nu
  }
}

// Section 4.7: by (4.45) the faces Y = 0 and Y = 1 carry a normal traction, for their normal
// velocity is held, and no tangential one. The printed tau = 0 would be free of both.
TEST(Gong2015Section47, OnlyTheTangentialTractionVanishes) {
  constexpr double lambda = 5.77e6, mu = 3.85e6, G = 0.1;
  const auto F = [](double X) { return 1 + pi * G * std::cos(pi * X); };  // sin(c pi t) = 1
  const double X = 0.3;
  for (const double Y : {0.0, 1.0}) {
    const double P_22 = lambda / F(Y) * std::log(F(X) * F(Y)) + mu * (F(Y) - 1 / F(Y));
    EXPECT_GT(std::abs(P_22), 0.3 * mu);
    EXPECT_NEAR(std::sin(pi * Y), 0, 1e-15);  // the factor of U_2 and V_2
  }
}

// Section 5.4 assembles cell by cell. With rho and s x at the centres, inner nodes must have a = s
// / rho, and all nodes the mass of the bar.
TEST(Gong2015Section54, MassNeedsTheVolumeOfTheCell) {
  constexpr double rho = 1000, s = 70, h = 0.1;
  std::vector<double> m(11), printed_m(11), f(11);
  for (int i = 0; i < 10; ++i) {
    const double stress = s * (i + 0.5) * h;
    for (const int node : {i, i + 1}) {
      m[node] += rho * h / 2;
      printed_m[node] += rho / 2;
    }
    f[i] += stress;  // -(-1 / h) stress h, as printed
    f[i + 1] -= stress;
  }
  double mass = 0, printed_mass = 0;
  for (int i = 0; i <= 10; ++i) {
    mass += m[i];
    printed_mass += printed_m[i];
  }
  EXPECT_NEAR(mass, rho, 1e-9);
  EXPECT_NEAR(printed_mass, rho / h, 1e-9);
  EXPECT_NEAR(f[5] / m[5], s / rho, 1e-12);
  EXPECT_NEAR(f[5] / printed_m[5], s / rho * h, 1e-12);
}

// The slopes of the two hats of a cell are -1 / h and 1 / h: with them x itself has the slope 1,
// and (5.9) gives the forces +-sigma that the text assembles.
TEST(Gong2015Section54, SlopesOfHatsAreInverseLengths) {
  constexpr double h = 0.1, left = 0.3, right = left + h, middle = left + h / 2, sigma = 3;
  const auto slope_of_x = [&](double a, double b) { return a * left + b * right; };
  const double a = slope_of_hat(middle, left, h), b = slope_of_hat(middle, right, h);
  EXPECT_NEAR(a, -1 / h, 1e-12);
  EXPECT_NEAR(slope_of_x(a, b), 1, 1e-12);
  EXPECT_NEAR(-a * sigma * h, sigma, 1e-12);
  EXPECT_NEAR(slope_of_x(-h, h), h * h, 1e-12);  // as printed
}

// Intervals of the length dpt about x_i + (j - 1/2) dpt fill the cells, and their centre of mass is
// that of the bar. About x_i + (j - 1) dpt, as printed, they begin outside.
TEST(Gong2015Section54, ParticlesAreTheMiddlesOfTheirIntervals) {
  constexpr int cells = 8, per_cell = 4;
  constexpr double h = 1.0 / cells, dpt = h / per_cell;
  double centre = 0, printed = 0, least = 1, printed_least = 1;
  for (int i = 0; i < cells; ++i)
    for (int j = 1; j <= per_cell; ++j) {
      const double x = i * h + (j - 0.5) * dpt, x_printed = i * h + (j - 1) * dpt;
      centre += dpt * x;
      printed += dpt * x_printed;
      least = std::min(least, x - dpt / 2);
      printed_least = std::min(printed_least, x_printed - dpt / 2);
    }
  EXPECT_NEAR(centre, 0.5, 1e-15);
  EXPECT_NEAR(least, 0, 1e-15);
  EXPECT_NEAR(printed, 0.5 - dpt / 2, 1e-15);
  EXPECT_LT(printed_least, 0);
}

// Chapter 7 in steps: N particles in each of `cells` periodic cells; F of a particle follows the
// cell's (v_I - v_{I-1}) / h by (7.14), v_I the sum of all slopes of its hat by the first line of
// (7.13).
class Linearised {
 public:
  Linearised(int cells, int per_cell, double cfl)
      : cells_(cells), per_cell_(per_cell), cfl_(cfl), v_(cells), F_(cells * per_cell, 0.0) {}

  // sin(omega dt / 2) of the wave cos(k x_I): its amplitude a has
  // a^{s+1} - 2 a^s + a^{s-1} = -4 sin^2(omega dt / 2) a^s.
  double sine(double kh) {
    for (int I = 0; I < cells_; ++I) v_[I] = std::cos(kh * I);
    const double first = v_[0];
    step();
    const double second = v_[0];
    step();
    return std::sqrt((2 * second - v_[0] - first) / (4 * second));
  }

 private:
  void step() {                                // C F_0 dt / h = cfl; lengths in h
    for (int cell = 0; cell < cells_; ++cell)  // between the nodes cell and cell + 1
      for (int p = 0; p < per_cell_; ++p)
        F_[cell * per_cell_ + p] += cfl_ * (v_[(cell + 1) % cells_] - v_[cell]);
    for (int I = 0; I < cells_; ++I)
      for (int p = 0; p < per_cell_; ++p) {
        const int left = (I + cells_ - 1) % cells_;
        const double offset = (p + 0.5) / per_cell_;
        v_[I] -= cfl_ / per_cell_ *
                 (slope_of_hat(offset - 1, 0, 1) * F_[left * per_cell_ + p] +
                  slope_of_hat(offset, 0, 1) * F_[I * per_cell_ + p]);
      }
  }
  int cells_, per_cell_;
  double cfl_;
  std::vector<double> v_, F_;
};

// (7.29): F is the same for all particles of a cell, not exp(i k x_p) times a constant as (7.17)
// has it. Hence sin(omega dt / 2) = CFL sin(k h / 2), whatever the number of particles.
TEST(Gong2015Equation729, DoesNotDependOnTheNumberOfParticles) {
  constexpr int cells = 12;
  constexpr double cfl = 0.3;
  for (const int N : {1, 2, 4})
    for (const int wave : {2, 3, 4}) {
      const double kh = 2 * pi * wave / cells;
      const double sine = Linearised(cells, N, cfl).sine(kh), of_particles = std::sin(kh / (2 * N));
      const double printed = cfl / N * std::pow(std::sin(kh / 2), 2) / of_particles;
      EXPECT_NEAR(sine, cfl * std::sin(kh / 2), 1e-12) << N << " particles";
      if (N == 1) {
        EXPECT_NEAR(printed, sine, 1e-12);
      } else {
        EXPECT_GT(std::abs(printed / sine - 1), 0.01) << N << " particles";
      }
    }
}

// (7.13), second line: the slopes of the hat have their signs, and the two sums are added. With the
// printed minus a uniform F would push the node.
TEST(Gong2015Equation713, AddsTheTwoSums) {
  constexpr int N = 4;
  double left = 0, right = 0;
  for (int p = 0; p < N; ++p) {
    left += slope_of_hat((p + 0.5) / N - 1, 0, 1);
    right += slope_of_hat((p + 0.5) / N, 0, 1);
  }
  EXPECT_EQ(left + right, 0);
  EXPECT_EQ(left - right, 2 * N);
}

// (7.31), and M in the sentence above it, have lost a square: by (7.23) it is sin^2(theta / 2).
TEST(Gong2015Equation731, HasTheSquareOfTheSine) {
  for (const int N : {2, 4})
    for (const double theta : {0.3, 1.2, 2.8}) {
      double sum = 0;
      for (int p = 1; p <= N; ++p) sum += std::sin(theta / N * (2 * p - 1) / 2);
      const double of_particles = std::sin(theta / (2 * N));
      EXPECT_NEAR(sum, std::pow(std::sin(theta / 2), 2) / of_particles, 1e-13);
      EXPECT_GT(std::abs(sum - std::sin(theta / 2) / of_particles), 1e-2);
    }
}

}  // namespace
}  // namespace recon
