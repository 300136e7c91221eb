// A simulation on the ranks that there are moves as one on a single rank.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <map>

#include "mpm/support.hpp"
#include "ranks/folder.hpp"
#include "recon/io/read.hpp"
#include "recon/ranks/distributed_simulation.hpp"
#include "recon/runs/compose.hpp"
#include "recon/runs/simulation.hpp"

namespace recon::mpm::test {
namespace {

using recon::testing::world;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// The largest difference of an array, over its largest entry.
template <class A, class B>
double off(const A& a, const B& b) {
  double most = 0, largest = 0;
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    most = std::max(most, (a[i] - b[i]).norm());
    largest = std::max(largest, a[i].norm());
  }
  return largest > 0 ? most / largest : most;
}

// After some steps, which each side chooses: the gathered state is that of one rank, no particle is
// lost, and the ledger is the same.
template <int D>
void expect_motion_of_one_rank(const Problem<D>& problem, int steps, bool some_change = false,
                               double tolerance = 1e-12) {
  const std::string& name = problem.method.name;
  Simulation<D> whole(problem);
  DistributedSimulation<D> parts(world(), problem);
  for (int i = 0; i < steps; ++i) {
    const TimeStep one = whole.choose_step(), each = parts.choose_step();
    ASSERT_NEAR(one.dt, each.dt, 1e-12 * one.dt) << name;
    whole.step(one.dt);
    parts.step(each.dt);
    ASSERT_EQ(world().sum(static_cast<long long>(parts.part().own())),
              static_cast<long long>(problem.particles.size()));
  }
  whole.map();
  parts.map();
  const Ledger one = account(whole), all = parts.account();
  const double energy = one.kinetic + one.strain;
  EXPECT_NEAR(one.mass, all.mass, tolerance * one.mass) << name;
  EXPECT_NEAR(one.node_mass, all.node_mass, tolerance * one.mass) << name;
  EXPECT_NEAR(one.kinetic, all.kinetic, tolerance * energy) << name;
  EXPECT_NEAR(one.node_kinetic, all.node_kinetic, tolerance * energy) << name;
  EXPECT_NEAR(one.strain, all.strain, tolerance * energy) << name;
  const double momentum = std::sqrt(2 * one.mass * energy);
  EXPECT_LE(distance(one.node_momentum, all.node_momentum), tolerance * momentum) << name;
  EXPECT_NEAR(one.power, all.power, 10 * tolerance * (energy + std::abs(one.power))) << name;
  const State<D> gathered = parts.gather();
  const auto moved = world().sum(parts.traffic().migrated);
  if (some_change && world().size() > 1) {
    EXPECT_GT(moved, 0) << name;
  }
  if (world().rank() != 0) return;
  const Particles<D>&a = whole.particles(), &b = gathered.particles;
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.body, b.body);
  EXPECT_LE(off(a.x, b.x), tolerance) << name;
  EXPECT_LE(off(a.X, b.X), tolerance) << name;
  EXPECT_LE(off(a.v, b.v), tolerance) << name;
  EXPECT_LE(off(a.F, b.F), tolerance) << name;
  EXPECT_LE(off(a.L, b.L), tolerance) << name;
  EXPECT_LE(off(a.stress, b.stress), tolerance) << name;
  EXPECT_EQ(a.history.size(), b.history.size());
}

// Two bodies that are thrown through a grid of 16 cells, one of them turning, in all of space.
template <int D>
Problem<D> thrown(const Method& method) {
  Problem<D> problem;
  constexpr double h = 1.0 / 16;
  problem.grid = Grid<D>(Vector<D>::Zero(), Vector<D>::Ones(), h);
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}, NeoHookean{Lame::from(3000, 0.2)}};
  problem.densities = {1000, 500};
  problem.method = method;
  for (int body = 0; body < 2; ++body) {
    constexpr int rows = D == 3 ? 8 : 12;
    int all = 1;
    for (int d = 0; d < D; ++d) all *= rows;
    for (int i = 0; i < all; ++i) {
      Vector<D> X;
      for (int d = 0, rest = i; d < D; ++d, rest /= rows)
        X[d] = ((d == 0 ? 2 : 4) + (rest % rows + 0.5) / 2) * h;
      X[0] += (D == 3 ? 4.3 : 6.3) * body * h;  // not on the lattice of the first one
      problem.particles.add(X, Matrix<D>::Identity() * (h / 4),
                            problem.densities[static_cast<std::size_t>(body)], body);
      Vector<D>& v = problem.particles.v.back();
      v[0] = body == 0 ? 1.5 : -0.5;
      if (D > 1) v[D - 1] += (body == 0 ? 3 : -2) * (X[0] - 0.4);
      if (D > 1) v[0] -= (body == 0 ? 3 : -2) * (X[D - 1] - 0.4);
    }
  }
  problem.gravity[D - 1] = -3;
  return problem;
}

// Elements with negative functions break in this problem, on one rank as well; parts_test.cpp of
// mpm/ has them.
bool goes(const Method& method) {
  return !has_negative_functions(method.name);
}

TEST(OnRanks, BodiesThatMeetMoveAsOnOne) {
  for (const Method& method : methods()) {
    if (!goes(method)) continue;
    // When bodies meet, fits of degree 3 make 1e-9 of a change of 1e-16, on one rank as well.
    const int steps = method.degree == 3 ? 10 : 20;
    expect_motion_of_one_rank(thrown<2>(method), steps, true);
  }
}

// A long bar between walls, which waves: ranks have the nodes around their own particles alone, whose
// numbers, held velocities and borders are not those of the whole grid.
TEST(OnRanks, AWideGridMovesAsOnOne) {
  const int ranks = world().size();
  for (const Method& method : methods()) {
    if (!goes(method)) continue;
    Problem<2> problem;
    constexpr double h = 1.0 / 16;
    problem.grid = Grid<2>({-1, 0.5}, {11, 2}, h);
    problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
    problem.densities = {1000};
    problem.method = method;
    for (int i = 0; i < 320 * 8; ++i) {
      const Vector<2> X((i % 320 + 0.5) * h / 2, 1 + (i / 320 + 0.5) * h / 2);
      problem.particles.add(X, Matrix<2>::Identity() * (h / 4), 1000, 0);
      problem.particles.v.back() = Vector<2>(0.5 * std::cos(2 * X[0]), std::sin(3 * X[0]));
    }
    for (const double at : {0.0, 9.5}) {
      Boundary<2> wall;
      wall.axis = 0;
      wall.at = at;
      wall.velocity[0] = HeldVelocity<2>(
          [](const Vector<2>& x, double t) { return 0.1 * std::sin(t + x[1]) * (x[0] - 3); });
      problem.boundaries.push_back(wall);
    }
    // Places in cells are rounded to 2e-14 here. Of a change of positions by their last bit polypic
    // makes 7e-12 in 20 steps, on one rank as well, and others less than 4e-13.
    const int steps = method.degree == 3 || method.name == "polypic" ? 10 : 20;
    expect_motion_of_one_rank(problem, steps, false, method.name == "polypic" ? 7e-12 : 1e-12);
    if (method.name != "mpm") continue;
    DistributedSimulation<2> parts(world(), problem);
    parts.map();
    // A bar of 160 cells in a grid of 192: its part, and 3 cells of copies, 1 of functions and 4.
    const auto nodes = static_cast<double>(parts.stepper().nodes().mass.size());
    EXPECT_LE(nodes, ranks == 1 ? 193 * 25 : (160.0 / ranks + 2 * 8 + 4) * 25);
    EXPECT_EQ(parts.stepper().nodes().held.empty(),
              ranks > 2 && world().rank() > 0 && world().rank() < ranks - 1);
  }
}

TEST(OnRanks, ABarMovesAsOnOne) {
  for (const char* name : {"mpm", "cpdi2", "impm", "cpls", "bspline3"})
    expect_motion_of_one_rank(thrown<1>(method_named(name)), 20, true);
}

TEST(OnRanks, BodiesIn3DMoveAsOnOne) {
  for (const char* name : {"mpm", "cpdi1"})
    expect_motion_of_one_rank(thrown<3>(method_named(name)), 20);
}

TEST(OnRanks, StressesFirstAndMuslAreThoseOfOne) {
  for (const char* text : {"ugimp+stress=first", "cpdi2+stress=musl", "mpm+stress=musl",
                           "cpls+momentum_correction=true"})
    expect_motion_of_one_rank(thrown<2>(composed(text)), 20, true);
}

// A vortex in a square that repeats itself along x, between rollers: particles change ranks.
Problem<2> vortex(const Method& method) {
  Problem<2> problem;
  constexpr double h = 1.0 / 16;
  problem.periodic = {true, false};
  problem.grid = periodic_grid<2>({0, 0}, {1, 1}, h, problem.periodic);
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = method;
  for (int i = 0; i < 32 * 32; ++i) {
    const Vector<2> X((i % 32 + 0.5) * h / 2, (i / 32 + 0.5) * h / 2);
    problem.particles.add(X, Matrix<2>::Identity() * (h / 4), 1000, 0);
    problem.particles.v.back() =
        Vector<2>(1 + 0.2 * std::sin(2 * M_PI * X[0]) * std::cos(M_PI * X[1]),
                  -0.4 * std::cos(2 * M_PI * X[0]) * std::sin(M_PI * X[1]));
  }
  for (const double at : {0.0, 1.0}) {
    Boundary<2> wall;
    wall.axis = 1;
    wall.at = at;
    wall.velocity[1] = 0.0;
    problem.boundaries.push_back(wall);
  }
  return problem;
}

TEST(OnRanks, AVortexInAPeriodMovesAsOnOne) {
  for (const char* name : {"mpm", "ugimp", "cpdi1", "bspline2", "apic", "cpls", "impm", "xpic"})
    expect_motion_of_one_rank(vortex(method_named(name)), 20, true);
}

// A column on a wall whose images give, with loads on its end, a body force and damping.
Problem<2> column(const Method& method) {
  Problem<2> problem;
  problem.grid = Grid<2>({0, 0}, {3, 1.6}, 0.1);
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = method;
  for (int i = 0; i < 40 * 8; ++i) {
    const Vector<2> X(0.437 + (i % 40 + 0.5) * 0.05, 0.4 + (i / 40 + 0.5) * 0.05);
    problem.particles.add(X, Matrix<2>::Identity() * 0.025, 1000, 0);
  }
  Boundary<2> wall;
  wall.axis = 0;
  wall.at = 0.437;
  wall.images = true;
  wall.velocity[0] = 0.0;
  problem.boundaries = {wall};
  problem.damping = {0.1, 0};
  problem.body_force = [](const Particles<2>& particles, double t, int,
                          std::vector<Vector<2>>& out) {
    for (std::size_t p = 0; p < particles.size(); ++p)
      out[p] += Vector<2>(std::sin(particles.X[p][1] + t), particles.X[p][0]);
  };
  for (std::size_t row = 0; row < 8; ++row)
    for (const std::size_t column : {3, 19, 20, 39}) {
      Load<2> load;
      load.particle = row * 40 + column;
      load.offset = {0.025, 0};
      load.area = {0.05, 0};
      load.force = [](const LoadedPlace<2>& place, double t) {
        return Vector<2>(-(20 + t) * place.area);
      };
      problem.loads.push_back(load);
    }
  return problem;
}

TEST(OnRanks, WallsAndLoadsActAsOnOne) {
  for (const char* name : {"mpm", "cpdi1", "cpls", "affine_cpdi"})
    expect_motion_of_one_rank(column(method_named(name)), 20);
}

// Frames in pieces have what that of one process has: all particles once, by their ids, nodes and cells
// at every place, in pieces that share points; fits where material is.
struct Place {
  std::vector<double> values;
  int pieces = 0;
};
using Places = std::map<std::array<long, 3>, Place>;
template <int D>
void add_places(const fs::path& path, const Grid<D>& grid, Places& places) {
  const ParticleTable table = read_particles(path);
  const std::vector<std::string> names = table.all_names();
  const auto x = table.positions(D);
  for (std::size_t i = 0; i < table.size(); ++i) {
    std::array<long, 3> at{};
    for (int d = 0; d < D; ++d)
      at[static_cast<std::size_t>(d)] = std::lround(2 * (x(i, d) - grid.lower()[d]) / grid.h());
    Place& place = places[at];
    std::vector<double> values;
    for (const std::string& name : names)
      if (!axis_of_coordinate(name)) values.push_back(table.raw_column(name)[i]);
    if (place.pieces++ > 0) {
      EXPECT_THAT(values, ::testing::Pointwise(::testing::NanSensitiveDoubleEq(), place.values));
    }
    place.values = values;
  }
}

template <int D>
void expect_frame_of_one_rank(const Problem<D>& problem, int steps) {
  const std::string& name = problem.method.name;
  const Folder folder;
  Simulation<D> whole(problem);
  DistributedSimulation<D> parts(world(), problem);
  for (int i = 0; i < steps; ++i) {
    whole.step(whole.choose_step().dt);
    parts.step(parts.choose_step().dt);
  }
  whole.map();
  parts.map();
  std::vector<double> times, times_of_one;
  parts.write_frame(folder.path, "a", times);
  MPI_Barrier(world().get());
  EXPECT_EQ(times, (std::vector<double>{parts.time()}));
  if (world().rank() != 0) return;
  fs::create_directory(folder.path / "one");
  write_frame(folder.path / "one", "a", whole, times_of_one);
  const auto near = [&](double a, double b, double largest) {
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
    return std::abs(a - b) <= 1e-12 * std::max(largest, 1e-3);
  };
  const auto largest_of = [](const std::vector<double>& values) {
    double largest = 0;
    for (const double value : values)
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
    return largest;
  };
  {
    const ParticleTable one = read_particles(folder.path / "one" / "a_particles_0000.vtp"),
                        all = read_particles(folder.path / "a_particles_0000.pvtp");
    ASSERT_EQ(all.size(), one.size()) << name;
    EXPECT_EQ(all.time, parts.time());
    EXPECT_EQ(all.step, parts.steps());
    const auto& ids = all.column("id");
    for (const std::string& column : one.all_names()) {
      const auto &a = one.raw_column(column), &b = all.raw_column(column);
      const double largest = largest_of(a);
      for (std::size_t p = 0; p < ids.size(); ++p)
        ASSERT_TRUE(near(a.at(static_cast<std::size_t>(ids[p])), b[p], largest))
            << name << " " << column << " " << p;
    }
  }
  for (const std::string kind : {"nodes", "cells"}) {
    const fs::path file = folder.path / "one" / ("a_" + kind + "_0000.vti");
    ASSERT_EQ(fs::exists(file), fs::exists(folder.path / ("a_" + kind + "_0000.pvti")));
    if (!fs::exists(file)) continue;
    Places one, all;
    add_places<D>(file, problem.grid, one);
    std::size_t listed = 0;
    const std::string list = [&] {
      std::ifstream in(folder.path / ("a_" + kind + "_0000.pvti"));
      return std::string(std::istreambuf_iterator<char>(in), {});
    }();
    for (int r = 0; r < world().size(); ++r) {
      const std::string piece = "a_" + kind + "_0000_" + std::to_string(r) + ".vti";
      if (list.find(piece) == std::string::npos) continue;
      ++listed;
      add_places<D>(folder.path / piece, problem.grid, all);
    }
    EXPECT_GT(listed, 0u);
    ASSERT_EQ(all.size(), one.size()) << name << " " << kind;
    const ParticleTable table = read_particles(file);
    std::vector<std::string> names;
    std::vector<double> largest;
    for (const std::string& column : table.all_names())
      if (!axis_of_coordinate(column)) {
        names.push_back(column);
        largest.push_back(largest_of(table.raw_column(column)));
      }
    const auto at_material =
        std::find(names.begin(), names.end(), kind == "nodes" ? "mass" : "fill");
    ASSERT_NE(at_material, names.end());
    const auto material = static_cast<std::size_t>(at_material - names.begin());
    std::size_t compared = 0;
    for (const auto& [at, place] : one) {
      const Place& other = all.at(at);
      for (std::size_t c = 0; c < names.size(); ++c) {
        const bool of_fit = names[c].starts_with("fit_") || names[c].starts_with("stress_") ||
                            names[c] == "density";
        if (of_fit && place.values[material] == 0) continue;
        ++compared;
        ASSERT_TRUE(near(place.values[c], other.values[c], largest[c]))
            << name << " " << kind << " " << names[c] << ": " << place.values[c] << ", "
            << other.values[c] << " at " << at[0] << ", " << at[1];
      }
    }
    EXPECT_GE(compared, one.size());
  }
}

TEST(OnRanks, FramesInPiecesAreThoseOfOne) {
  for (const char* name : {"mpm", "cpdi2", "bspline3", "cpls", "impm", "imls_mpm", "improved_cpdi",
                           "impm_adjoint", "tls", "wls"})
    expect_frame_of_one_rank(thrown<2>(method_named(name)), 4);
  expect_frame_of_one_rank(thrown<1>(method_named("impm")), 4);
  expect_frame_of_one_rank(thrown<3>(method_named("impm")), 2);
  for (const char* name : {"cpdi1", "cpls", "impm"}) {
    expect_frame_of_one_rank(vortex(method_named(name)), 4);
    expect_frame_of_one_rank(column(method_named(name)), 4);
  }
}

// A body that flies out of the boxes of some ranks, which have no particles then.
// Not fast: L is made of differences of velocities, whose rounding is that of the velocities.
TEST(OnRanks, ARankMayRunOutOfParticles) {
  for (const char* name : {"mpm", "cpls", "impm", "imls_mpm", "impm_adjoint"}) {
    Problem<2> problem = thrown<2>(method_named(name));
    keep_first(144, {}, problem.particles);
    problem.gravity.setZero();
    problem.time.rule = StepRule::fixed;
    problem.time.step = 0.012;
    constexpr int steps = 22;  // through more than the width of the body
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      problem.particles.x[p][0] -= 0.1;
      problem.particles.v[p] = Vector<2>(1.5, 0.1 * std::sin(20 * problem.particles.x[p][1]));
    }
    problem.particles.X = problem.particles.x;
    DistributedSimulation<2> parts(world(), problem);
    for (int i = 0; i < steps; ++i) parts.step(problem.time.step);
    const double fewest = -world().largest(-static_cast<double>(parts.part().own()));
    if (world().size() > 1) {
      EXPECT_EQ(fewest, 0) << name;
    }
    expect_motion_of_one_rank(problem, steps);
  }
}

// Elements give negative masses where particles are few, and those of few that fly change their
// signs: at the same node and step, whichever ranks know it.
TEST(OnRanks, SignsOfMassesAreThoseOfOne) {
  std::size_t changes = 0;
  for (const double speed : {2.0, 5.0, 11.0, -3.0}) {
    Problem<2> problem = thrown<2>(method_named("q8"));
    problem.particles = {};
    problem.gravity.setZero();
    for (int i = 0; i < 40; ++i) {
      const Vector<2> X(0.3 + 0.4 * (i + 0.5) / 40, 0.3 + 0.4 * std::fmod(0.618034 * i, 1.0));
      problem.particles.add(X, Matrix<2>::Identity() * 0.01, 1000, 0);
      problem.particles.v.back() = Vector<2>(speed, speed / 3);
    }
    Simulation<2> whole(problem);
    DistributedSimulation<2> parts(world(), problem);
    const auto expect_same = [&](const std::optional<NegativeMass>& one,
                                 const std::optional<NegativeMass>& all) {
      ASSERT_EQ(one.has_value(), all.has_value()) << speed;
      if (!one) return;
      EXPECT_EQ(one->step, all->step) << speed;
      EXPECT_EQ(one->node, all->node) << speed;
      EXPECT_NEAR(one->mass, all->mass, 1e-12 * problem.particles.mass[0]) << speed;
    };
    for (int i = 0; i < 20; ++i) {
      whole.step(1e-3);
      parts.step(1e-3);
      expect_same(whole.negative_mass(), parts.signs().negative);
      expect_same(whole.sign_change(), parts.signs().change);
    }
    changes += whole.sign_change() ? 1 : 0;
  }
  EXPECT_GT(changes, 1u);
}

// From a state that was gathered, the same bits follow as without.
TEST(OnRanks, AGatheredStateGoesOnToTheBit) {
  Problem<2> problem = thrown<2>(method_named("cpdi2"));
  DistributedSimulation<2> through(world(), problem), again(world(), problem);
  for (int i = 0; i < 10; ++i) through.step(1e-3);
  const State<2> middle = through.gather();
  // Each rank is given all.
  Simulation<2> whole(problem);
  State<2> everywhere = whole.state();
  if (world().rank() == 0) everywhere = middle;
  everywhere.time = through.time();
  everywhere.last_dt = 1e-3;
  everywhere.steps = through.steps();
  everywhere.particles.arrays(problem.kept(), [&](const ParticleArray&, auto& values) {
    using T = typename std::decay_t<decltype(values)>::value_type;
    MPI_Bcast(values.data(), static_cast<int>(values.size() * sizeof(T)), MPI_BYTE, 0,
              world().get());
  });
  again.restore(everywhere);
  for (int i = 0; i < 10; ++i) {
    through.step(1e-3);
    again.step(1e-3);
  }
  const State<2> a = through.gather(), b = again.gather();
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.steps, b.steps);
  ASSERT_EQ(a.particles.size(), b.particles.size());
  for (std::size_t p = 0; p < a.particles.size(); ++p) {
    ASSERT_EQ(a.particles.x[p], b.particles.x[p]) << p;
    ASSERT_EQ(a.particles.v[p], b.particles.v[p]) << p;
    ASSERT_EQ(a.particles.stress[p], b.particles.stress[p]) << p;
  }
}

// What happens on one rank stops all of them, with the number of the particle in the problem.
TEST(OnRanks, AFailureOfOneIsThatOfAll) {
  Problem<2> problem = thrown<2>(method_named("mpm"));
  const std::size_t fast = problem.particles.size();  // far from all others
  problem.particles.add({0.9, 0.9}, Matrix<2>::Identity() * 0.01, 500, 1);
  problem.particles.v[fast] = Vector<2>(100, 0);
  problem.time.rule = StepRule::fixed;
  problem.time.step = 1e-2;
  DistributedSimulation<2> parts(world(), problem);
  std::string said;
  try {
    for (int i = 0; i < 5; ++i) parts.step(1e-2);
  } catch (const Failure& e) {
    said = e.what();
    EXPECT_EQ(e.number(), fast);
  }
  EXPECT_THAT(said, HasSubstr("particle 288: rank "));
  EXPECT_THAT(said, HasSubstr("it left the grid"));
  EXPECT_THROW(parts.step(1e-3), InvalidArgument);
  parts.restore(start(problem));
  EXPECT_NO_THROW(parts.map());
}

TEST(OnRanks, WhatIsWrongIsRefusedOnAll) {
  Problem<2> problem = thrown<2>(method_named("mpm"));
  problem.method.mass = MassMatrix::consistent;
  EXPECT_THAT(recon::testing::refusal([&] { DistributedSimulation<2>(world(), problem); }),
              HasSubstr("must be lumped in a state of several parts"));
  problem = thrown<2>(method_named("mpm"));
  DistributedSimulation<2> parts(world(), problem);
  EXPECT_THAT(recon::testing::refusal([&] { parts.step(-1); }), HasSubstr("time step = -1"));
  if (world().size() > 1) {
    EXPECT_THAT(recon::testing::refusal([&] { parts.step(1e-3 + 1e-4 * world().rank()); }),
                HasSubstr("different on some ranks"));
  }
  EXPECT_THROW(parts.account(), InvalidArgument);
  State<2> few = start(problem);
  keep_first(3, problem.kept(), few.particles);
  EXPECT_THAT(recon::testing::refusal([&] { parts.restore(few); }),
              HasSubstr("must be as many as the problem has"));
}

// A copy in 3-D is 3 vectors, 4 matrices, 3 numbers, and the numbers of its body and of itself. A step
// of mpm fetches copies once; one with the stresses first twice, the second time what has changed.
TEST(OnRanks, SendCopiesAndNothingElse) {
  constexpr std::int64_t vector = 24, matrix = 72, whole = 3 * vector + 4 * matrix + 3 * 8 + 2 * 4;
  for (const bool first : {false, true}) {
    Problem<3> problem = thrown<3>(composed(first ? "mpm+stress=first" : "mpm"));
    for (Vector<3>& v : problem.particles.v) v.setZero();
    DistributedSimulation<3> parts(world(), problem);
    constexpr std::int64_t changed = 2 * vector + 3 * matrix;
    parts.step(1e-4);
    const Traffic sent = parts.traffic();
    const auto copies = world().sum(static_cast<long long>(sent.copies));
    EXPECT_EQ(copies > 0, world().size() > 1);
    EXPECT_EQ(world().sum(sent.bytes), copies * (whole + (first ? changed : 0)));
    EXPECT_EQ(sent.migrated, 0);
    EXPECT_LE(sent.messages, (world().size() - 1) * (first ? 2 : 1));
  }
}

// Boxes have equal parts of what there is at the start, to a row for each of two cuts.
TEST(OnRanks, HaveAsManyParticlesAsOthers) {
  const Problem<2> problem = thrown<2>(method_named("mpm"));
  const DistributedSimulation<2> parts(world(), problem);
  const double fair = static_cast<double>(problem.particles.size()) / world().size();
  EXPECT_LE(std::abs(static_cast<double>(parts.part().own()) - fair), 24);
}

}  // namespace
}  // namespace recon::mpm::test
