// The balance of energy with external forces, damping, and runs that end at rest.
#include <gmock/gmock.h>
#include <stdlib.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "recon/io/read.hpp"
#include "recon/runs/run.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class MpmRest : public InFolder {
 protected:
  template <int D>
  static ProblemFile<D> file_of(const std::string& text,
                                const std::vector<std::string>& settings = {}) {
    return std::get<ProblemFile<D>>(read_problem_text(text, "p.toml", settings));
  }
  template <int D>
  RunResult run_in(const std::string& name, const ProblemFile<D>& file, RunOptions options = {}) {
    options.folder = folder_ / name;
    return run(file, options);
  }
  static std::string refusal(const std::string& text) {
    try {
      read_problem_text(text, "p.toml");
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
};

// A column of 1 x 20 cells (or a bar of 20) on a roller, between rollers.
std::string column(int dimension, const std::string& method, const std::string& more) {
  const bool bar = dimension == 1;
  std::string text = "[grid]\nlower = " + std::string(bar ? "[0]" : "[0, 0]") +
                     "\nupper = " + (bar ? "[22]" : "[2, 22]") + "\ncells = 1\n" +
                     "[material]\nyoung = 1e5\npoisson = 0.25\ndensity = 10\n" +
                     "[[body]]\nshape = \"box\"\nlower = " + (bar ? "[0]" : "[0, 0]") +
                     "\nupper = " + (bar ? "[20]" : "[2, 20]") + "\n";
  if (bar)
    return text + "[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"roller\"\n" +
           "[loads]\ngravity = [-10]\n[method]\nname = \"" + method + "\"\n" + more;
  for (const char* each : {"axis = \"x\"\nat = 0", "axis = \"x\"\nat = 2", "axis = \"y\"\nat = 0"})
    text += "[[boundary]]\n" + std::string(each) + "\nkind = \"roller\"\n";
  return text + "[loads]\ngravity = [0, -10]\n[method]\nname = \"" + method + "\"\n" + more;
}

// Free fall, a load that follows time and a piston that moves: work is what energy gains. The work
// of a constant force on a mass that it accelerates is integrated exactly; elsewhere to the second
// order.
TEST_F(MpmRest, WorkIsWhatEnergyGains) {
  const std::string fall =
      "[grid]\nlower = [0, 0]\nupper = [1, 2]\ncells = 8\n"
      "[material]\nyoung = 1000\npoisson = 0.3\ndensity = 1000\n"
      "[[body]]\nshape = \"box\"\nlower = [0.25, 1.25]\nupper = [0.75, 1.75]\n"
      "[loads]\ngravity = [0, -1]\n[method]\nname = \"cpdi1\"\n[time]\nend = 1\n"
      "[output]\nframes = 0\n";
  const RunResult result = run_in("fall", file_of<2>(fall));
  EXPECT_NEAR(result.last.work, 250 * 0.5, 1e-9 * 125);
  EXPECT_NEAR(result.last.balance(), 0, 1e-9 * 125);
  EXPECT_NEAR(result.last.power, 250, 1e-9 * 250);  // m g . v at t
  // By formulas of the same gravity, and half of it by each.
  for (const char* loads :
       {"body_force = [0, -1]", "gravity = [0, -0.5]\nbody_force = [0, \"-1/2\"]"}) {
    std::string text = fall;
    text.replace(text.find("gravity = [0, -1]"), 17, loads);
    EXPECT_NEAR(run_in(loads, file_of<2>(text)).last.work, 125, 1e-9 * 125) << loads;
  }
}

// A bar under a gravity that swings it: the balance closes to the second order in the step.
TEST_F(MpmRest, TheBalanceOfALoadedBarClosesToSecondOrder) {
  const std::string loads[] = {
      "", "[[point_load]]\nat = [19.9]\ndirection = [1]\nmagnitude = \"20 * sin(t)\"\n",
      "[[pressure]]\nside = \"x_upper\"\nmagnitude = \"50 * t\"\n"};
  for (const std::string& load : loads) {
    std::vector<double> off;
    for (const char* step : {"0.002", "0.001"}) {
      auto file = file_of<1>(column(
          1, "bspline2+musl",
          load + "[time]\nend = 1\nrule = \"fixed\"\nstep = " + step + "\n[output]\nframes = 0\n"));
      const RunResult result = run_in(std::string(step) + load.substr(0, 8), file);
      double most = std::max(result.last.strain, std::abs(result.last.work));
      off.push_back(std::abs(result.last.balance() - result.first.balance()) / most);
    }
    EXPECT_LE(off[0], 0.01) << load;
    EXPECT_LE(off[1], off[0] + 1e-6) << load << off[0] << " " << off[1];
  }
}

// A piston at constant speed compresses a bar that cannot get away: its work is the reaction's.
TEST_F(MpmRest, APistonDoesTheWorkOfItsReaction) {
  const std::string text =
      "[grid]\nlower = [0]\nupper = [12]\ncells = 1\n"
      "[material]\nyoung = 1000\npoisson = 0\ndensity = 1\n"
      "[[body]]\nshape = \"box\"\nlower = [0]\nupper = [10]\n"
      "[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"fixed\"\n"
      "[[boundary]]\naxis = \"x\"\nat = 10\nkind = \"velocity\"\nvelocity = [-0.01]\n"
      "[method]\nname = \"cpdi1+musl\"\n"
      "[time]\nend = 20\nrule = \"fixed\"\nstep = 0.005\n[output]\nframes = 0\n";
  const RunResult result = run_in("piston", file_of<1>(text));
  // Strain 0.2 / 10, nearly static: E e^2 / 2 times the length, to a strain and to waves.
  EXPECT_NEAR(result.last.work, 1000 * 0.02 * 0.02 / 2 * 10, 0.1 * 2);
  EXPECT_NEAR(result.last.balance(), 0, 0.02 * result.last.work);
}

// With `mass` a body that flies loses momentum at that rate; `local` lets a body that feels no
// force fly.
TEST_F(MpmRest, DampingTakesMotionFromTheNodes) {
  const auto flight = [&](const std::string& damping) {
    const auto file = file_of<2>(
        "[grid]\nlower = [0, 0]\nupper = [3, 1]\ncells = 8\n"
        "[material]\nyoung = 1000\npoisson = 0.3\ndensity = 1000\n"
        "[[body]]\nshape = \"box\"\nlower = [0.25, 0.25]\nupper = [0.75, 0.75]\n"
        "velocity = [0.5, 0]\n[method]\nname = \"cpdi1\"\n"
        "[time]\nend = 2\nrule = \"fixed\"\nstep = 0.01\n[output]\nframes = 0\n" +
        damping);
    return run_in(damping, file);
  };
  const RunResult drag = flight("[damping]\nmass = 0.5\n");
  const double left = drag.last.momentum[0] / drag.first.momentum[0];
  // The first kick is half a step, and velocities are those of half a step before the end.
  EXPECT_NEAR(left, (1 - 0.5 * 0.005) * std::pow(1 - 0.5 * 0.01, 199), 1e-9);
  EXPECT_NEAR(drag.last.balance(), drag.first.total(), 1e-4 * drag.first.total());
  EXPECT_LT(drag.last.work, -0.8 * drag.first.total() * (1 - left * left));
  const RunResult local = flight("[damping]\nlocal = 0.8\n");
  EXPECT_NEAR(local.last.momentum[0], local.first.momentum[0], 1e-9 * local.first.momentum[0]);
}

// The force of `local` against the motion is the part `local` of the force: a body that falls from
// rest falls with (1 - local) g, and rises with (1 + local) g against it.
TEST_F(MpmRest, LocalDampingIsAPartOfTheForce) {
  const auto gained = [&](double up) {
    const auto file = file_of<2>(
        "[grid]\nlower = [0, 0]\nupper = [1, 4]\ncells = 8\n"
        "[material]\nyoung = 1000\npoisson = 0.3\ndensity = 1000\n"
        "[[body]]\nshape = \"box\"\nlower = [0.25, 1.25]\nupper = [0.75, 1.75]\nvelocity = [0, " +
        std::to_string(up) +
        "]\n[loads]\ngravity = [0, -1]\n[damping]\nlocal = 0.25\n[method]\nname = \"cpdi1\"\n"
        "[time]\nend = 0.5\nrule = \"fixed\"\nstep = 0.01\n[output]\nframes = 0\n");
    const RunResult result = run_in("up" + std::to_string(up), file);
    EXPECT_NEAR(result.last.balance(), result.first.total(), 2e-3 * (1 + result.first.total()));
    return (result.last.momentum[1] - result.first.momentum[1]) / result.last.mass;
  };
  // v = 0 has no direction: the first kick, a half step, is not damped.
  EXPECT_NEAR(gained(0), -0.005 - 0.49 * 0.75, 1e-9);
  EXPECT_NEAR(gained(2), -0.495 * 1.25, 1e-9);
}

TEST_F(MpmRest, RunsEndAtRestAndSaySo) {
  const std::string damped = "[damping]\nlocal = 0.3\n[time]\nuntil = \"rest\"\nend = 60\n";
  for (const int dimension : {1, 2})
    for (const char* method : {"mpm", "bspline2", "cpdi1+musl", "apic"}) {
      const auto check = [&](const auto& file, const RunResult& result) {
        ASSERT_TRUE(result.rest.has_value());
        EXPECT_TRUE(result.rest->reached) << method << dimension;
        EXPECT_LT(result.rest->unbalanced, 1e-4);
        EXPECT_LT(result.rest->kinetic, 1e-4);
        EXPECT_LT(result.time, 60);
        EXPECT_FALSE(result.stopped);
        EXPECT_GT(result.frames, 1u);
        EXPECT_GT(result.last.strain, 0);
        (void)file;
      };
      const std::string name = std::string(method) + std::to_string(dimension);
      if (dimension == 1) {
        const auto file = file_of<1>(column(1, method, damped));
        check(file, run_in(name, file));
      } else {
        const auto file = file_of<2>(column(2, method, damped));
        check(file, run_in(name, file));
      }
    }
  // What still swings at the end has not come to rest, and says so.
  const RunResult early =
      run_in("early", file_of<1>(column(1, "mpm", "[time]\nuntil = \"rest\"\nend = 0.5\n")));
  ASSERT_TRUE(early.rest.has_value());
  EXPECT_FALSE(early.rest->reached);
  EXPECT_GT(early.rest->unbalanced, 1e-4);
  EXPECT_NEAR(early.time, 0.5, 1e-12);
  EXPECT_FALSE(run_in("plain", file_of<1>(column(1, "mpm", "[time]\nend = 0.1\n"))).rest);
}

// At rest a column of 20 cells carries its weight, at any strain: the stress of particles averaged
// over cells is -density g (L - X) to 2 % of the largest, with every method that can run it. 8-node
// elements break: their masses are negative. The heavy column is strained by 1.7 %, so that
// particles have moved by up to a sixth of a cell, which some methods do not bear.
template <int D>
void expect_hydrostatic(const Method& method, double density, const std::filesystem::path& folder) {
  const std::string settings[] = {"material.density=" + std::to_string(density)};
  const auto file = std::get<ProblemFile<D>>(
      read_problem_text(column(D, method.name,
                               "[damping]\nlocal = 0.3\n[time]\nuntil = \"rest\"\nend = 60\n"
                               "[output]\nframes = 0\nledger = false\n"),
                        "p.toml", settings));
  const RunResult result = run(file, {.folder = folder});
  ASSERT_TRUE(result.rest->reached) << method.name;
  Simulation<D> at_rest(file.problem);
  read_checkpoint(folder / "checkpoint.h5", at_rest, file.formulas);
  const Particles<D>& particles = at_rest.particles();
  std::map<std::size_t, std::pair<double, double>> cells;  // sum of stresses less theirs; count
  for (std::size_t p = 0; p < particles.size(); ++p) {
    auto& [sum, count] = cells[file.problem.grid.cell_number(particles.x[p])];
    sum += particles.stress[p](D - 1, D - 1) + density * 10 * (20 - particles.X[p][D - 1]);
    count += 1;
  }
  for (const auto& [cell, at] : cells)
    EXPECT_LE(std::abs(at.first / at.second), 0.02 * density * 200)
        << method.name << ", cell " << cell << ", density " << density;
}
template <int D>
void expect_hydrostatic(const std::filesystem::path& folder) {
  for (const Method& method : methods()) {
    if (method.basis == Basis::q8) continue;
    expect_hydrostatic<D>(method, 1, folder / ("light" + method.name));
    const bool bears = method.basis != Basis::q9 && method.quadrature != Quadrature::nodal_cells &&
                       method.degree < 3;
    if (bears) expect_hydrostatic<D>(method, 10, folder / ("heavy" + method.name));
  }
}
TEST_F(MpmRest, AColumnCarriesItsWeight) {
  expect_hydrostatic<1>(folder_);
}
TEST_F(MpmRest, SlowAColumnInThePlaneCarriesItsWeight) {
  expect_hydrostatic<2>(folder_);
}

// A column of the small-strain material at rest has the displacement and the energy of a linear bar,
//     u = -(density g / M) (L X - X^2 / 2) ,   U = width (density g)^2 L^3 / (6 M) ,
// with M = lambda + 2 mu, both to the squares of strains (0.2 %), to what linear functions leave of
// a parabola in a cell, and to the tolerance of rest: 1 % of the largest.
template <int D>
void expect_linear_column(const std::string& method, const std::filesystem::path& folder) {
  std::string text = column(D, method,
                            "[damping]\nlocal = 0.3\n[time]\nuntil = \"rest\"\nend = 60\n"
                            "[output]\nframes = 0\nledger = false\n");
  text.replace(text.find("[material]"), 10, "[material]\nkind = \"small_strain\"");
  const std::string settings[] = {"material.density=1"};
  const auto file = std::get<ProblemFile<D>>(read_problem_text(text, "p.toml", settings));
  ASSERT_TRUE(std::holds_alternative<SmallStrain>(file.problem.materials[0]));
  const RunResult result = run(file, {.folder = folder});
  ASSERT_TRUE(result.rest->reached) << method;
  Simulation<D> at_rest(file.problem);
  read_checkpoint(folder / "checkpoint.h5", at_rest, file.formulas);
  constexpr double L = 20, weight = 10, M = 1.2e5, most = weight * L * L / (2 * M);
  const Particles<D>& particles = at_rest.particles();
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const double X = particles.X[p][D - 1];
    EXPECT_NEAR(particles.x[p][D - 1] - X, -weight / M * (L * X - X * X / 2), 0.01 * most)
        << method << " " << p;
  }
  const double energy = (D == 1 ? 1 : 2) * weight * weight * L * L * L / (6 * M);
  EXPECT_NEAR(result.last.strain, energy, 0.01 * energy) << method;
}
TEST_F(MpmRest, ASmallStrainColumnIsALinearOne) {
  for (const char* method : {"mpm", "cpdi1", "bspline2", "cpls"})
    expect_linear_column<1>(method, folder_ / method);
  expect_linear_column<2>("cpdi1", folder_ / "plane");
}

// The account of the soft cantilever that falls closes where strains are those of velocities that
// particles keep, and what affine velocities leave is small; 1 % of the largest energy.
TEST_F(MpmRest, TheBalanceOfACantileverCloses) {
  for (const char* method :
       {"cpdi1+musl", "cpdi2+musl", "bspline3+musl", "affine_cpdi2", "improved_cpdi"}) {
    auto file = read_example<2>("benchmarks/cantilever_gravity.toml",
                                {std::string("method.name=") + method, "frames=0"});
    const RunResult result = run_in(method, file);
    const ParticleTable ledger = read_particles(folder_ / method / "ledger.csv");
    double most = 0, off = 0;
    for (const double total : ledger.column("total")) most = std::max(most, total);
    for (const double balance : ledger.column("balance")) off = std::max(off, std::abs(balance));
    EXPECT_LE(off, 0.01 * most) << method;
    EXPECT_GT(most, 0.5 * result.last.work) << method;
  }
}

// No rest before the loads are what they will be, while a boundary moves, and where nothing acts.
TEST_F(MpmRest, NoRestWhileLoadsGrowOrBoundariesMove) {
  const std::string slow =
      "[[point_load]]\nat = [19.9]\ndirection = [-1]\nmagnitude = \"0.1 * min(t, 50)\"\n"
      "[damping]\nlocal = 0.8\n[time]\nuntil = \"rest\"\nend = 80\ntolerance = 1e-3\n"
      "[output]\nframes = 1\n";
  std::string text = column(1, "bspline2+musl", slow);
  text.replace(text.find("gravity = [-10]"), 15, "gravity = [0]");
  const RunResult ramp = run_in("ramp", file_of<1>(text));
  EXPECT_TRUE(ramp.rest->reached);
  EXPECT_GE(ramp.time, 49.9);
  EXPECT_LT(ramp.time, 70);
  const std::string nothing = column(1, "mpm", "[time]\nuntil = \"rest\"\nend = 0.1\n");
  std::string still = nothing;
  still.replace(still.find("gravity = [-10]"), 15, "gravity = [0]");
  EXPECT_FALSE(run_in("still", file_of<1>(still)).rest->reached);
  std::string pushed = column(1, "bspline2+musl",
                              "[damping]\nlocal = 0.8\n[time]\nuntil = \"rest\"\nend = 100\n"
                              "tolerance = 0.01\n[output]\nframes = 1\n");
  pushed.replace(pushed.find("gravity = [-10]"), 15, "gravity = [0]");
  pushed += "[[boundary]]\naxis = \"x\"\nat = 20\nkind = \"velocity\"\nvelocity = [-0.0001]\n";
  EXPECT_FALSE(run_in("pushed", file_of<1>(pushed)).rest->reached);
}

// In balance the reactions carry the weight, and damping has no part in it.
TEST_F(MpmRest, ReactionsCarryTheWeight) {
  const auto file =
      file_of<2>(column(2, "bspline2",
                        "[damping]\nlocal = 0.5\n[time]\nuntil = \"rest\"\nend = 60\n"
                        "[[probe]]\nkind = \"reaction\"\nboundary = 3\nname = \"foot\"\n"
                        "[[probe]]\nkind = \"reaction\"\nboundary = 1\nname = \"left\"\n"
                        "[[probe]]\nkind = \"reaction\"\nboundary = 2\nname = \"right\"\n"));
  const RunResult result = run_in("foot", file);
  ASSERT_TRUE(result.rest->reached);
  const ParticleTable probes = read_particles(folder_ / "foot/probes.csv");
  const double weight = 10 * 10 * 40;
  EXPECT_NEAR(probes.column("foot.force_y").back(), weight, 1e-4 * 5 * weight);  // of all reactions
  EXPECT_EQ(probes.column("foot.force_x").back(), 0);
  // Sideways nu / (1 - nu) = 1/3 of the stress upwards, over the height.
  const double aside = 1.0 / 3 * 10 * 10 * 20 * 20 / 2;
  EXPECT_NEAR(probes.column("left.force_x").back(), aside, 0.03 * aside);
  EXPECT_NEAR(probes.column("right.force_x").back(), -aside, 0.03 * aside);
}

TEST_F(MpmRest, WhatIsWrongIsAnswered) {
  const auto with = [](const std::string& more) { return column(1, "mpm", more); };
  EXPECT_EQ(refusal(with("[time]\nend = 1\n[damping]\nlocal = 0.5\nmass = 2\n")), "");
  EXPECT_THAT(refusal(with("[time]\nend = 1\n[damping]\nlocal = 1\n")),
              HasSubstr("damping.local: local = 1: must be at least 0 and below 1"));
  EXPECT_THAT(refusal(with("[time]\nend = 1\n[damping]\nlocal = -0.1\n")),
              HasSubstr("damping.local"));
  EXPECT_THAT(refusal(with("[time]\nend = 1\n[damping]\nmass = -1\n")),
              HasSubstr("damping.mass: mass = -1: must be finite and not negative"));
  EXPECT_THAT(refusal(with("[time]\nend = 1\n[damping]\nviscous = 1\n")),
              HasSubstr("damping.viscous: unknown key"));
  EXPECT_THAT(refusal(with("[time]\nend = 1\nuntil = \"quiet\"\n")),
              AllOf(HasSubstr("time.until: unknown 'quiet'"), HasSubstr("end, rest")));
  EXPECT_THAT(refusal(with("[time]\nend = 1\nuntil = \"rest\"\ntolerance = 0\n")),
              HasSubstr("time.tolerance: tolerance = 0: must lie between 0 and 1"));
  EXPECT_THAT(refusal(with("[time]\nend = 1\ntolerance = 0.1\n")),
              HasSubstr("has no meaning with the other keys here"));
  const auto set = file_of<1>(with("[time]\nend = 1\n"),
                              {"local=0.25", "damping.mass=3", "until=rest", "tolerance=0.5"});
  EXPECT_EQ(set.problem.damping.local, 0.25);
  EXPECT_EQ(set.problem.damping.mass, 3);
  EXPECT_EQ(set.problem.time.rest, 0.5);
  EXPECT_EQ(file_of<1>(with("[time]\nend = 1\nuntil = \"rest\"\n")).problem.time.rest, 1e-4);
}

// Work, rows of probes and rest are those of the run in one piece, to the last bit.
TEST_F(MpmRest, ARestartIsExact) {
  const std::string more =
      "[damping]\nlocal = 0.2\nmass = 0.01\n[time]\nend = 2\n[output]\nframes = 4\n"
      "probe_interval = 0.13\n"
      "[[probe]]\nkind = \"particle\"\nat = [19]\n[[probe]]\nkind = \"section\"\naxis = \"x\"\nat "
      "= 3\n";
  const auto whole = file_of<1>(column(1, "cpdi1", more));
  run_in("whole", whole);
  int calls = 0;
  RunOptions stopping;
  stopping.stop = [&] { return ++calls > 37; };
  EXPECT_TRUE(run_in("parts", whole, stopping).stopped);
  RunOptions on;
  on.restart = folder_ / "parts/checkpoint.h5";
  run_in("parts", whole, on);
  for (const char* name : {"ledger.csv", "probes.csv", "checkpoint.h5"})
    EXPECT_EQ(contents(folder_ / "whole" / name), contents(folder_ / "parts" / name)) << name;
  // Damping belongs to the problem.
  RunOptions other;
  other.restart = folder_ / "parts/checkpoint.h5";
  try {
    run_in("parts", file_of<1>(column(1, "cpdi1", more), {"local=0.3"}), other);
    FAIL();
  } catch (const NoRestart& error) {
    EXPECT_THAT(error.what(), HasSubstr("damping.local is 0.2 in the checkpoint, 0.3 now"));
  }
  // Other probes would give other columns: the rows that are there are not thrown away.
  const std::string before = contents(folder_ / "parts/probes.csv");
  std::string fewer = more;
  fewer.replace(fewer.find("[[probe]]\nkind = \"section\""), std::string::npos, "");
  try {
    run_in("parts", file_of<1>(column(1, "cpdi1", fewer)), on);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("probes.csv:1"), HasSubstr("other columns")));
  }
  EXPECT_EQ(before, contents(folder_ / "parts/probes.csv"));
}

// Without a ledger nobody has summed up the work: it is unknown, also after a restart.
TEST_F(MpmRest, WorkIsUnknownWithoutALedger) {
  const std::string more = "[time]\nend = 0.5\n[output]\nframes = 2\n";
  const auto silent = file_of<1>(column(1, "cpdi1", more + "ledger = false\n"));
  const RunResult result = run_in("silent", silent);
  EXPECT_EQ(result.first.work, 0);
  EXPECT_TRUE(std::isnan(result.last.work));
  RunOptions on;
  on.restart = folder_ / "silent/checkpoint.h5";
  EXPECT_TRUE(
      std::isnan(run_in("silent", file_of<1>(column(1, "cpdi1", more), {"end=1"}), on).last.work));
}

}  // namespace
}  // namespace recon::mpm::test
