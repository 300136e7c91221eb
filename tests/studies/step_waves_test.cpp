// Eigenvalues of a step say what runs do.
#include "recon/studies/step_waves.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "mpm/support.hpp"
#include "recon/runs/compose.hpp"
#include "recon/studies/stability.hpp"

namespace recon::mpm::test {
namespace {

constexpr double pi = std::numbers::pi;

double distance_to_nearest(const Eigen::VectorXcd& all, std::complex<double> one) {
  return (all.array() - one).abs().minCoeff();
}

// Velocity and stress of the shortest wave obey [[1, -W K], [K, 1 - K^2]], K = 2 c_p dt / h, where
// W is the mean of (1 - 2 xi)^2 over the particles of a cell (stability.hpp).
TEST(StepWaves, KnowTheShortestWave) {
  for (const int n : {1, 2, 3, 4}) {
    double W = 0;
    for (int j = 0; j < n; ++j) W += std::pow(1 - (2 * j + 1.0) / n, 2) / n;
    for (const double courant : {0.2, 0.6}) {
      const double K = 2 * courant;
      Eigen::Matrix2d step;
      step << 1, -W * K, K, 1 - K * K;
      const Eigen::VectorXcd expected = step.eigenvalues();
      const Eigen::VectorXcd found =
          StepSymbol<1>(method_named("mpm"), n, courant).at(Vector<1>(pi)).eigenvalues();
      for (int k = 0; k < 2; ++k) EXPECT_LT(distance_to_nearest(found, expected[k]), 1e-5) << n;
    }
    EXPECT_NEAR(largest_step_by_eigenvalues(method_named("mpm"), 1, n), 1 / std::sqrt(2 - W),
                0.006);
  }
}

// The bar of the runs has ends, where fits are one-sided; the waves of the eigenvalues have none.
TEST(StepWaves, HaveTheFrequencyAndDampingOfRuns) {
  for (const char* name : {"mpm", "cpdi1", "cpls", "impm", "bspline2", "apic"}) {
    const Method& method = method_named(name);
    const auto curve = dispersion(method, 2, 0.4);
    const double margin = is_fit(method.velocity) ? 0.02 : 0.005;
    for (const std::size_t k : {0u, 4u, 7u}) {  // k h up to 0.47 pi
      const StepWave wave = step_wave(method, 2, 0.4, curve[k].kh);
      EXPECT_NEAR(wave.frequency, curve[k].measured, margin * wave.frequency) << name << k;
      EXPECT_NEAR(wave.damping, curve[k].damping, 0.02) << name << k;
    }
  }
}

// Strain and force are transposes of each other then, and nothing is lost.
TEST(StepWaves, AreNotDampedWithTheStressFirst) {
  for (const double kh : {0.3, 1.0, 2.0}) {
    EXPECT_NEAR(step_wave(composed("mpm+stress=first"), 2, 0.4, kh).damping, 0, 1e-5);
    EXPECT_GT(step_wave(method_named("mpm"), 2, 0.4, kh).damping, 1e-3);
  }
}

// In 2-D a wave along x is that of 1-D, whatever the number of particles across.
TEST(StepWaves, AreTheSameInTwoDimensions) {
  for (const char* name : {"cpdi1", "mls_mpm"}) {
    const double kh = 1.2;
    const auto line = StepSymbol<1>(method_named(name), 2, 0.4).at(Vector<1>(kh)).eigenvalues();
    const auto square =
        StepSymbol<2>(method_named(name), 2, 0.4).at(Vector<2>(kh, 0)).eigenvalues().eval();
    for (const std::complex<double>& each : line)
      EXPECT_LT(distance_to_nearest(square, each), 1e-4) << name;
  }
}

// The spread of velocities in a free bar that flies over the grid, for a cell crossed: the mean of
// the later half.
double growth_of_a_run(const Method& method, int steps_per_cell, int cells, int crossed) {
  constexpr double courant = 0.4;
  const double speed = 1 / (steps_per_cell * courant);
  Problem<1> problem;
  problem.grid = Grid<1>(Vector<1>(0.0), Vector<1>(cells + crossed + 10.0), 1);
  problem.materials = {LinearElastic{Lame{0, 0.5}}};
  problem.densities = {1};
  problem.method = method;
  for (int p = 0; p < 2 * cells; ++p) {
    problem.particles.add(Vector<1>(4 + (p + 0.5) / 2 + 0.37 / steps_per_cell),
                          Matrix<1>::Identity() * 0.25, 1, 0);
    problem.particles.v.back()[0] = speed + 1e-9 * std::sin(3.7 * p * p);
  }
  Simulation<1> simulation(std::move(problem));
  const auto spread = [&] {
    const auto& v = simulation.particles().v;
    double mean = 0, sum = 0;
    for (const auto& each : v) mean += each[0] / static_cast<double>(v.size());
    for (const auto& each : v) sum += std::pow(each[0] - mean, 2);
    return std::sqrt(sum);
  };
  double middle = 0;
  for (int cell = 0; cell < crossed; ++cell) {
    for (int s = 0; s < steps_per_cell; ++s) simulation.step(courant);
    if (2 * (cell + 1) == crossed) middle = spread();
  }
  return std::pow(spread() / middle, 2.0 / crossed);
}

TEST(StepWaves, GrowAsInAFlyingBar) {
  const Method &polypic = method_named("polypic"), &apic = method_named("apic");
  EXPECT_NEAR(growth_of_a_run(polypic, 10, 10, 60),
              spectral_radius(polypic, 1, 2, 0.4, 10, true, 10), 0.01);
  EXPECT_GT(spectral_radius(polypic, 1, 2, 0.4, 10), 1.1);
  EXPECT_LT(growth_of_a_run(apic, 10, 10, 60), 1.001);
  EXPECT_LT(spectral_radius(apic, 1, 2, 0.4, 10, true, 10), 1.001);
}

TEST(StepWaves, KnowTheLargestStep) {
  for (const char* name : {"impm"}) {
    const Method& method = method_named(name);
    EXPECT_NEAR(largest_step_by_eigenvalues(method, 1, 2), stability_limit(method, 2).measured,
                0.02)
        << name;
  }
  // W = 1/4 with 2 particles along each axis: the shortest wave along x is that of 1-D.
  EXPECT_NEAR(largest_step_by_eigenvalues(method_named("mpm"), 2, 2), 1 / std::sqrt(1.75), 0.006);
}

TEST(StepWaves, RefuseWhatTheyCannotDo) {
  EXPECT_THROW(StepSymbol<1>(method_named("q8"), 2, 0.4), InvalidArgument);
  EXPECT_THROW(StepSymbol<1>(method_named("mpm"), 0, 0.4), InvalidArgument);
  EXPECT_THROW(StepSymbol<1>(method_named("mpm"), 2, 0), InvalidArgument);
  EXPECT_THROW(step_wave(method_named("mpm"), 2, 0.4, 4), InvalidArgument);
  EXPECT_THROW(spectral_radius(method_named("mpm"), 3, 2, 0.4), InvalidArgument);
  EXPECT_THROW(spectral_radius(method_named("mpm"), 1, 2, 0.4, -1), InvalidArgument);
}

}  // namespace
}  // namespace recon::mpm::test
