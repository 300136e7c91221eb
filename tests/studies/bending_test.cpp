// The conclusions of Andersen, Andersen 2007, on bar.toml, cantilever.toml and box_on_beam.toml.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Largest over time, as parts of the energy at the start.
struct Errors {
  double interpolation = 0, total = 0;
};

Errors errors_of_bar(std::vector<std::string> settings) {
  Simulation<2> simulation(read_example<2>("bar.toml", settings).problem);
  Errors errors;
  std::optional<Ledger> start;
  run_until<2>(simulation, simulation.problem().time.end, [&] {
    const Ledger now = account(simulation, start);
    if (!start) start = now;
    errors.interpolation =
        std::max(errors.interpolation, std::abs(now.interpolation_error) / start->total());
    errors.total = std::max(errors.total, std::abs(now.total() / start->total() - 1));
  });
  return errors;
}

TEST(BendingBar, InterpolationErrorIsLeastWithQ9AndMostWithQ8) {
  const std::string end = "end=4", step = "step=0.006";
  const Errors linear = errors_of_bar({"name=mpm", end, step}),
               q8 = errors_of_bar({"name=q8", end, step}),
               q9 = errors_of_bar({"name=q9", end, step}),
               cubic = errors_of_bar({"name=bspline3", end, step});
  EXPECT_LT(q9.interpolation, 0.2 * linear.interpolation);
  EXPECT_LT(linear.interpolation, cubic.interpolation);
  EXPECT_LT(linear.interpolation, 0.03);
  EXPECT_LT(cubic.interpolation, 0.06);
  EXPECT_NEAR(q8.interpolation, 0.9, 0.1);
  for (const Errors& errors : {linear, q8, q9, cubic}) EXPECT_LT(errors.total, 1e-4);
}

TEST(BendingBar, ConsistentMassHasNoInterpolationError) {
  for (const char* method : {"mpm", "q8", "q9", "bspline2", "bspline3"}) {
    const Errors errors =
        errors_of_bar({std::string("name=") + method, "mass=consistent", "end=1.2", "step=0.006"});
    EXPECT_LT(errors.interpolation, 1e-5) << method;
    EXPECT_LT(errors.total, 1e-4) << method;
  }
}

// The loss of stress that comes last falls with the step: that much of it that first has none.
TEST(BendingBar, EnergyIsLostWhereStressComesLast) {
  const auto loss = [](const char* stress, const char* step) {
    return errors_of_bar({"name=mpm", stress, "end=4", step}).total;
  };
  const double last = loss("stress=last", "step=0.006"), half = loss("stress=last", "step=0.003");
  EXPECT_GT(half, 0.005);
  EXPECT_GT(last, 1.3 * half);
  EXPECT_LT(loss("stress=first", "step=0.006"), 0.01 * half);
}

// The mean over the last period of a slow ramp, with the load at its particle. Shear adds 1 % to
// the deflection of bending, and six rows of particles instead of a continuous height 1 / 35.
TEST(BendingCantilever, CorrectedSplinesDeflectAsTheBeam) {
  const double end = 60, F = 100.0 / 288, EI = 3e5 / 12, length = 8 - 1.0 / 12;
  const double frequency = 3.516 / 64 * std::sqrt(EI / 1e3);
  for (const char* method : {"bspline3", "q9"}) {
    Simulation<2> simulation(read_example<2>("cantilever.toml", {std::string("name=") + method,
                                                                 "T=60", "end=60", "step=0.016"})
                                 .problem);
    const Particles<2>& particles = simulation.particles();
    std::vector<std::size_t> tip;
    for (std::size_t p = 0; p < particles.size(); ++p)
      if (particles.X[p][0] > 7.9 && std::abs(particles.X[p][1] - 0.5) < 0.1) tip.push_back(p);
    ASSERT_EQ(tip.size(), 2u);
    double deflection = 0, expected = 0;
    run_until<2>(simulation, end, [&] {
      if (simulation.time() < end - 2 * std::numbers::pi / frequency) return;
      for (const std::size_t p : tip) deflection += (particles.X[p][1] - particles.x[p][1]) / 2;
      expected += F * simulation.time() / end * std::pow(length, 3) / (3 * EI);
    });
    EXPECT_NEAR(deflection / expected, 1.01 * 36 / 35, 0.02) << method;
  }
}

TEST(BendingBox, Q9BreaksByNegativeMassWhichIsReported) {
  Simulation<2> simulation(read_example<2>("box_on_beam.toml", {"name=q9"}).problem);
  EXPECT_THROW(run_until<2>(simulation, 3), Failure);
  EXPECT_LT(simulation.time(), 0.5);
  ASSERT_TRUE(simulation.negative_mass());
  ASSERT_TRUE(simulation.sign_change());
  EXPECT_LT(simulation.negative_mass()->mass, 0);
  EXPECT_LE(simulation.negative_mass()->step, simulation.sign_change()->step);
  EXPECT_LE(simulation.sign_change()->step, simulation.steps());

  Simulation<2> stopped(
      read_example<2>("box_on_beam.toml", {"name=q9", "negative_mass=stop"}).problem);
  try {
    run_until<2>(stopped, 3);
    FAIL() << "no negative mass";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.step(), simulation.negative_mass()->step);
    EXPECT_EQ(failure.number(), simulation.negative_mass()->node);
    EXPECT_THAT(failure.what(), AllOf(HasSubstr("node "), HasSubstr("mass is negative")));
  }
}

}  // namespace
}  // namespace recon::mpm::test
