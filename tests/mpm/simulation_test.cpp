// Steps: rigid motion, conservation, threads, failures.
#include "recon/runs/simulation.hpp"

#include <cstring>

#include "mpm/support.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"

namespace recon::mpm::test {
namespace {

std::vector<std::string> all_methods() {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.push_back(method.name);
  return names;
}

class EveryMethod : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Mpm, EveryMethod, testing::ValuesIn(all_methods()),
                         [](const auto& each) { return each.param; });

template <int D>
void run_steps(Simulation<D>& simulation, int steps, double dt) {
  for (int s = 0; s < steps; ++s) simulation.step(dt);
}

// A block that flies through the grid stays as it is: crossing cells, particles exactly on
// edges and 1e-18 off them change nothing.
template <int D>
Problem<D> flight(const std::string& method) {
  Problem<D> problem = block<D>(8, 0.25, 0.5, method);
  Particles<D>& particles = problem.particles;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    for (int d = 0; d < D; ++d) {
      particles.v[p][d] = 0.1 + 0.05 * d;
      if (p % 3 == 0) particles.x[p][d] = std::round(particles.x[p][d] * 8) / 8;  // on an edge
      if (p % 3 == 1) particles.x[p][d] -= 1e-18;
    }
  }
  return problem;
}
template <int D>
void expect_rigid_flight(const std::string& method) {
  if (method == "q8" && D != 2) {
    EXPECT_THROW(method_named(method).validate(D), InvalidArgument);
    return;
  }
  Problem<D> problem = flight<D>(method);
  // Elements: masses pass through zero, so that is the motion without stress; see below.
  if (has_negative_functions(method)) problem.materials = {NeoHookean{Lame::from(1e-20, 0.3)}};
  const auto before = problem.particles;
  Simulation<D> simulation(problem);
  // The same way in steps that are longer where each of them takes four maps.
  const int steps = problem.method.update == Update::runge_kutta ? 40 : 200;
  const double dt = 2.0 / steps;
  run_steps(simulation, steps, dt);
  EXPECT_EQ(simulation.sign_change().has_value(), has_negative_functions(method));
  for (std::size_t p = 0; p < before.size(); ++p) {
    const auto& now = simulation.particles();
    EXPECT_LE((now.v[p] - before.v[p]).norm(), 1e-12) << method;
    EXPECT_LE((now.x[p] - before.x[p] - 2.0 * before.v[p]).norm(), 1e-11) << method;
    EXPECT_LE((now.F[p] - Matrix<D>::Identity()).norm(), 1e-10) << method;
  }
}
TEST_P(EveryMethod, RigidFlight) {
  expect_rigid_flight<1>(GetParam());
  expect_rigid_flight<2>(GetParam());
}
TEST_P(EveryMethod, RigidFlightIn3D) {
  expect_rigid_flight<3>(GetParam());
}

// With stress the rounding of momentum and force is divided by masses near zero, the strain that
// follows has a stress, and so on: until the first change of sign the flight is exact, and some
// steps later it is not, or particles are turned inside out (Andersen, Andersen 2007, appendix,
// where translation is said to fail at once).
TEST(Elements, WithStressBreakWhenAMassChangesItsSign) {
  for (const char* method : {"q8", "q9"}) {
    const Problem<2> problem = flight<2>(method);
    const auto error = [&](const Simulation<2>& simulation) {
      double most = 0;
      for (std::size_t p = 0; p < problem.particles.size(); ++p)
        most = std::max(most, (simulation.particles().v[p] - problem.particles.v[p]).norm());
      return most;
    };
    Simulation<2> simulation(problem);
    try {
      for (int s = 0; s < 200; ++s) {
        simulation.map();
        if (!simulation.sign_change()) {
          EXPECT_LE(error(simulation), 1e-12) << method << " step " << s;
        }
        simulation.step(0.01);
      }
    } catch (const Failure&) {
    }
    ASSERT_TRUE(simulation.sign_change()) << method;
    EXPECT_GT(simulation.sign_change()->step, 20) << method;
    EXPECT_GE(error(simulation), 1e-6) << method;
  }
}

// Two blocks collide in free flight.
Problem<2> collision(const std::string& method, int per_cell = 2) {
  Problem<2> problem = block<2>(10, 0.2, 0.4, method, per_cell);
  const Problem<2> other = block<2>(10, 0.5, 0.7, method, per_cell);
  for (std::size_t p = 0; p < problem.particles.size(); ++p) problem.particles.v[p] << 0.1, 0.07;
  problem.materials.push_back(LinearElastic{Lame::from(500, 0.2)});
  problem.densities.push_back(1000);
  for (std::size_t p = 0; p < other.particles.size(); ++p) {
    problem.particles.add(other.particles.X[p], other.particles.half_edges[p], 1000, 1);
    problem.particles.v.back() << -0.2, -0.1;
  }
  return problem;
}

// Mass always; momentum with the mass-weighted map, whose nodes have the particles' momentum. For
// fitted maps, and momentum that is fitted at Gauss points, the defect is what the ledger says, and
// the correction takes it away. With elements until a mass changes its sign.
TEST_P(EveryMethod, MassAndMomentum) {
  for (const bool corrected : {false, true}) {
    Problem<2> problem = collision(GetParam());
    problem.method.momentum_correction = corrected;
    const VelocityMap map = problem.method.velocity;
    const bool fitted = map == VelocityMap::mls || map == VelocityMap::imls ||
                        map == VelocityMap::cpls ||
                        problem.method.quadrature == Quadrature::gauss_cells;
    Simulation<2> simulation(problem);
    simulation.map();
    const Ledger start = account(simulation);
    double defect = 0;
    for (int s = 0; s < 60; ++s) {
      simulation.map();
      if (simulation.sign_change()) break;
      const Ledger now = account(simulation, start);
      EXPECT_NEAR(now.mass, start.mass, 1e-12 * start.mass);
      if (problem.method.quadrature == Quadrature::particles) {
        EXPECT_NEAR(now.node_mass, now.mass, 1e-9 * now.mass);
      }
      defect = std::max(defect, distance(now.momentum, now.node_momentum));
      EXPECT_NEAR(now.total() - start.total(), -now.interpolation_error - now.algorithmic_error,
                  1e-10 * start.total());
      simulation.step(0.01);
    }
    const double size = start.mass * 0.2;
    EXPECT_LE(defect, (!fitted || corrected ? 1e-9 : 0.2) * size) << GetParam();
    EXPECT_EQ(simulation.sign_change().has_value(), has_negative_functions(GetParam()));
    simulation.map();
    const Ledger end = account(simulation, start);
    // Internal forces add up to zero in either quadrature.
    if (problem.method.quadrature == Quadrature::particles) {
      EXPECT_LE(distance(end.momentum, start.momentum), 1e-9 * size) << GetParam();
    }
  }
}

// The same bits for any number of threads; enough particles for threads to be used.
TEST_P(EveryMethod, ThreadsChangeNothing) {
  std::vector<std::vector<Vector<2>>> results;
  for (const int threads : {1, 2, 3}) {
    Problem<2> problem = collision(GetParam(), 16);
    problem.threads = threads;
    Simulation<2> simulation(problem);
    ASSERT_GE(problem.particles.size(), 2000u);
    run_steps(simulation, 12, 0.01);
    results.push_back(simulation.particles().x);
    results.push_back(simulation.particles().v);
  }
  for (std::size_t i = 2; i < results.size(); ++i)
    EXPECT_EQ(0, std::memcmp(results[i].data(), results[i % 2].data(),
                             results[i].size() * sizeof(Vector<2>)))
        << GetParam();
}

TEST(Steps, RulesAndTheParticleThatLimits) {
  Problem<2> problem = block<2>(10, 0.2, 0.6);
  problem.particles.v[7] << 3, 4;
  const Lame elastic = lame(problem.materials[0]);
  const double c_p = elastic.p_wave_speed(1000), h = problem.grid.h();
  problem.time.courant = 0.5;
  const TimeStep adaptive = Simulation<2>(problem).choose_step();
  EXPECT_EQ(adaptive.particle, 7u);
  EXPECT_NEAR(adaptive.dt, 0.5 * h / (c_p + 5), 1e-15);
  problem.time.rule = StepRule::p_wave;
  EXPECT_NEAR(Simulation<2>(problem).choose_step().dt, 0.5 * h / c_p, 1e-15);
  problem.time.rule = StepRule::bar_wave;
  EXPECT_NEAR(Simulation<2>(problem).choose_step().dt, 0.5 * h / 1, 1e-15);  // sqrt(1000 / 1000)
  problem.time.rule = StepRule::fixed;
  problem.time.step = 0.0123;
  EXPECT_EQ(Simulation<2>(problem).choose_step().dt, 0.0123);
}

// The momentum after the first half kick is force times half a step.
TEST(Forces, PointLoadPushesTheMass) {
  Problem<1> problem = block<1>(10, 0.2, 0.6);
  problem.loads.push_back(point_load<1>(3, Vector<1>(2.0), [](double t) { return 1 + t; }));
  Simulation<1> simulation(problem);
  simulation.map();
  const double mass = account(simulation).mass;
  simulation.step(0.001);
  simulation.map();
  EXPECT_NEAR(account(simulation).momentum[0], 2.0 * 0.001 / 2, 1e-12 * mass);
}

TEST(Failures, NameTheParticleAndTheStep) {
  Problem<2> problem = block<2>(10, 0.2, 0.6);
  for (auto& v : problem.particles.v) v << 1, 0;
  Simulation<2> leaving(problem);
  try {
    run_steps(leaving, 1000, 0.01);
    FAIL() << "it must leave the grid";
  } catch (const Failure& failure) {
    EXPECT_NE(std::string(failure.what()).find("left the grid"), std::string::npos);
    EXPECT_GE(failure.step(), 40);
    EXPECT_STREQ(failure.place(), "particle");
    EXPECT_EQ(failure.what(), "step " + std::to_string(failure.step()) + ", particle " +
                                  std::to_string(failure.number()) + ": " + failure.reason());
    EXPECT_EQ(failure.reason().rfind("it left the grid at ", 0), 0u);
    EXPECT_GT(leaving.particles().x[failure.number()][0], 0.98);
  }
  // Opposite velocities in one cell: turned inside out by one long step.
  problem = block<2>(10, 0.2, 0.6);
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    problem.particles.v[p][0] = problem.particles.x[p][0] < 0.4 ? 1 : -1;
  Simulation<2> crushed(problem);
  crushed.map();
  EXPECT_THROW(crushed.step(0.3), Failure);
  // A velocity that is not a number.
  problem = block<2>(10, 0.2, 0.6);
  Simulation<2> poisoned(problem);
  poisoned.map();
  EXPECT_THROW(poisoned.step(std::nan("")), InvalidArgument);
  problem.particles.v[5][0] = std::nan("");
  EXPECT_THROW(Simulation<2>{problem}, InvalidArgument);
}

// A step is a step, whether its nodes were looked at before or not, and however often.
TEST_P(EveryMethod, LookingAtTheNodesChangesNothing) {
  const auto go = [&](int looks) {
    Simulation<2> simulation(collision(GetParam()));
    for (int s = 0; s < 5; ++s) {
      for (int look = 0; look < looks; ++look) simulation.map();
      simulation.step(0.01);
    }
    return simulation.particles();
  };
  const Particles<2> never = go(0), once = go(1), often = go(3);
  EXPECT_EQ(never.x, once.x);
  EXPECT_EQ(never.v, once.v);
  EXPECT_EQ(never.stress, once.stress);
  EXPECT_EQ(once.x, often.x);
}

std::string complaint(const auto& work) {
  try {
    work();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

TEST(States, AreOfOneTime) {
  Simulation<2> simulation(block<2>(10, 0.2, 0.6));
  EXPECT_NE(complaint([&] { simulation.nodes(); }), "");
  EXPECT_NE(complaint([&] { simulation.cells(); }), "");
  EXPECT_NE(complaint([&] { account(simulation); }), "");
  simulation.map();
  EXPECT_EQ(complaint([&] { account(simulation); }), "");
  simulation.step(0.001);
  simulation.nodes();                                      // of the step
  EXPECT_NE(complaint([&] { account(simulation); }), "");  // energies of two times
  for (const double dt : {0.0, -1.0, double(INFINITY), double(NAN)})
    EXPECT_NE(complaint([&] { simulation.step(dt); }), "") << dt;
  // 0.001 + 1e-30 is 0.001.
  EXPECT_NE(complaint([&] { simulation.step(1e-30); }).find("clock"), std::string::npos);
  simulation.step(0.001);  // a refused step has changed nothing
  EXPECT_EQ(simulation.steps(), 2);
}

TEST(States, EndWithAFailure) {
  Problem<2> problem = block<2>(10, 0.2, 0.6);
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    problem.particles.v[p][0] = problem.particles.x[p][0] < 0.4 ? 1 : -1;
  Simulation<2> simulation(problem);
  EXPECT_THROW(simulation.step(0.3), Failure);
  EXPECT_NE(complaint([&] { simulation.step(0.001); }), "");
  EXPECT_NE(complaint([&] { simulation.map(); }), "");
  EXPECT_NE(complaint([&] { account(simulation); }), "");
  simulation.restore(problem.particles, 0, 0, 0);
  simulation.step(0.001);
  Simulation<2> fresh(problem);
  fresh.step(0.001);
  EXPECT_EQ(simulation.particles().x, fresh.particles().x);
  EXPECT_EQ(simulation.steps(), 1);
}

// Every array of a restart, too short, too long, and with a value that is none; the simulation
// stays as it was.
TEST(States, RestoreChecksEveryArray) {
  for (const char* method : {"mpm", "cpdi2", "polypic"}) {
    Simulation<2> simulation(block<2>(10, 0.2, 0.4, method));
    simulation.step(0.001);
    const Particles<2> good = simulation.particles();
    int arrays = 0;
    const auto refused = [&](const auto& member) {
      ++arrays;
      for (const int how : {0, 1, 2}) {
        Particles<2> bad = good;
        auto& array = bad.*member;
        if (how == 0) array.pop_back();
        if (how == 1) array.push_back(array.back());
        if (how == 2) {
          using Value = std::decay_t<decltype(array[0])>;
          if constexpr (std::is_same_v<Value, double>)
            array[3] = NAN;
          else if constexpr (std::is_same_v<Value, std::int32_t>)
            array[3] = -1;
          else if constexpr (requires { array[3].setConstant(NAN); })
            array[3].setConstant(NAN);
          else
            array[3][1][0] = NAN;
        }
        EXPECT_NE(complaint([&] { simulation.restore(bad, 1, 1, 0.1); }), "")
            << method << " array " << arrays << " case " << how;
      }
    };
    refused(&Particles<2>::X);
    refused(&Particles<2>::x);
    refused(&Particles<2>::v);
    refused(&Particles<2>::F);
    refused(&Particles<2>::L);
    refused(&Particles<2>::stress);
    refused(&Particles<2>::half_edges);
    refused(&Particles<2>::mass);
    refused(&Particles<2>::volume0);
    refused(&Particles<2>::energy);
    refused(&Particles<2>::body);
    if (!good.corners.empty()) refused(&Particles<2>::corners);
    if (!good.modes.empty()) refused(&Particles<2>::modes);
    for (const double time : {-1.0, double(NAN), double(INFINITY)}) {
      EXPECT_NE(complaint([&] { simulation.restore(good, time, 1, 0.1); }), "");
      EXPECT_NE(complaint([&] { simulation.restore(good, 1, 1, time); }), "");
    }
    EXPECT_NE(complaint([&] { simulation.restore(good, 1, -1, 0.1); }), "");
    EXPECT_EQ(simulation.steps(), 1);
    simulation.restore(good, 1, 7, 0.1);
    EXPECT_EQ(simulation.steps(), 7);
  }
}

TEST(Problems, AreChecked) {
  const auto blamed = [](auto change) -> std::string {
    Problem<2> problem = block<2>(10, 0.2, 0.6);
    change(problem);
    try {
      Simulation<2> simulation(problem);
    } catch (const InvalidArgument& error) {
      return error.argument();
    }
    return "";
  };
  EXPECT_EQ(blamed([](auto&) {}), "");
  EXPECT_EQ(blamed([](auto& p) { p.particles = {}; }), "particles");
  EXPECT_EQ(blamed([](auto& p) { p.particles.x[3][0] = 2; }), "position of particle 3");
  EXPECT_EQ(blamed([](auto& p) { p.particles.mass[3] = 0; }), "mass of particle 3");
  EXPECT_EQ(blamed([](auto& p) { p.particles.body[3] = 1; }), "body of particle 3");
  EXPECT_EQ(blamed([](auto& p) { p.boundaries.push_back({0, 0.123, {}}); }), "place of a boundary");
  EXPECT_EQ(blamed([](auto& p) { p.method.degree = 3; }), "degree of the method");
  EXPECT_EQ(blamed([](auto& p) { p.time.courant = 0; }), "courant");
  EXPECT_EQ(blamed([](auto& p) { p.time.end = NAN; }), "end");
  EXPECT_EQ(blamed([](auto& p) { p.time.rule = StepRule::fixed; }), "step");
  EXPECT_EQ(blamed([](auto& p) { p.threads = -1; }), "threads");
  EXPECT_EQ(blamed([](auto& p) { p.grid = {}; }), "cells of the grid along an axis");
  EXPECT_EQ(blamed([](auto& p) { p.gravity[1] = NAN; }), "gravity");
  EXPECT_EQ(blamed([](auto& p) { p.materials[0] = NeoHookean{{1, 0}}; }), "mu");
  EXPECT_EQ(blamed([](auto& p) { p.materials[0] = LinearElastic{{-1, 1}}; }), "lambda");
  EXPECT_EQ(blamed([](auto& p) { p.materials[0] = LinearElastic{{NAN, 1}}; }), "lambda");
  EXPECT_EQ(blamed([](auto& p) { p.materials.clear(); }), "densities");
  EXPECT_EQ(blamed([](auto& p) { p.densities[0] = INFINITY; }), "density");
  EXPECT_EQ(blamed([](auto& p) { p.boundaries.push_back({2, 0, {}}); }), "axis of a boundary");
  EXPECT_EQ(blamed([](auto& p) {
              p.boundaries.push_back({0, 0, {NAN}});
            }),
            "velocity of a boundary");
  EXPECT_EQ(blamed([](auto& p) { p.loads.push_back({}); }), "particle of a load");
  const auto one = [](const auto&, double) { return Vector<2>(1, 1); };
  EXPECT_EQ(blamed([&](auto& p) {
              p.loads.push_back({9999, {0, 1}, {0, 0}, one});
            }),
            "particle of a load");
  EXPECT_EQ(blamed([&](auto& p) {
              p.loads.push_back({0, {0, NAN}, {0, 0}, one});
            }),
            "offset of a load");
  EXPECT_EQ(blamed([&](auto& p) {
              p.loads.push_back({0, {0, 1}, {NAN, 0}, one});
            }),
            "area of a load");
  EXPECT_EQ(blamed([&](auto& p) {
              p.boundaries.push_back({0, 0, {}, {0, 2}, {1, 3}});
            }),
            "from of a boundary");
  const auto symmetry = [&](int axis, double at, std::array<std::optional<HeldVelocity<2>>, 2> v) {
    return blamed([&](auto& p) {
      p.boundaries.push_back({axis, at, v});
      p.boundaries.back().symmetry = true;
    });
  };
  EXPECT_EQ(symmetry(0, 0.5, {0.0, {}}), "place of a plane of symmetry");
  EXPECT_EQ(symmetry(0, 0, {1.0, {}}), "velocity of a plane of symmetry");
  EXPECT_EQ(symmetry(0, 0, {0.0, 0.0}), "velocity of a plane of symmetry");
  EXPECT_EQ(symmetry(0, 0, {0.0, {}}), "");
  EXPECT_EQ(blamed([](auto& p) {
              p.boundaries.push_back({0, 0, {0.0, {}}, {0, 0}, {0, 0.5}, true});
            }),
            "from of a plane of symmetry");
  EXPECT_EQ(blamed([](auto& p) { p.particles.v.pop_back(); }), "v of the particles");
  EXPECT_EQ(blamed([](auto& p) { p.particles.L[2](0, 1) = NAN; }), "L of particle 2");
  EXPECT_EQ(blamed([](auto& p) { p.particles.F[2](0, 0) = -1; }), "det F of particle 2");
  EXPECT_EQ(blamed([](auto& p) { p.particles.half_edges[2].setZero(); }),
            "half_edges of particle 2");
  EXPECT_EQ(blamed([](auto& p) { p.particles.corners.resize(1); }), "corners of the particles");
  EXPECT_EQ(blamed([](auto& p) { p.particles.modes.resize(1); }), "modes of the particles");
}

}  // namespace
}  // namespace recon::mpm::test
