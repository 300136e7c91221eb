// What every method must get right, whatever it is made of: free fall, uniform forces, walls, the
// work of a material, steps that are stable by default.
#include <gmock/gmock.h>

#include <cmath>

#include "mpm/support.hpp"
#include "recon/runs/forecast.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"
#include "recon/studies/stability.hpp"

namespace recon::mpm::test {
namespace {

using testing::HasSubstr;

class EveryMethodsPhysics : public testing::TestWithParam<Method> {
 protected:
  // Calls work(Dimension<D>) with the dimensions that the method is for.
  template <class Work>
  void in_its_dimensions(const Work& work) {
    if (GetParam().basis != Basis::q8) work(Dimension<1>{});
    work(Dimension<2>{});
    if (GetParam().basis != Basis::q8) work(Dimension<3>{});
  }
};
INSTANTIATE_TEST_SUITE_P(Mpm, EveryMethodsPhysics, testing::ValuesIn(methods()),
                         [](const auto& each) { return each.param.name; });

template <int D>
Vector<D> some_acceleration() {
  Vector<D> a;
  for (int d = 0; d < D; ++d) a[d] = 0.5 - 0.9 * d;
  return a;
}

// The block of the tests below. Domains do not end on the edges of cells: nodes that see next to
// nothing of them would feel gravity alone.
template <int D>
Problem<D> floating(const Method& method) {
  Problem<D> problem = block<D>(8, 0.25, 0.5, method.name);
  if (method.domain != Domain::point)
    for (auto& x : problem.particles.x) x += Vector<D>::Constant(0.013);
  return problem;
}

// x = x_0 + a t^2 / 2 from a start at rest, in steps of different length; velocities are half a
// step behind. Nothing is strained.
template <int D>
void expect_free_fall(const Problem<D>& problem, const Vector<D>& a, double tolerance) {
  Simulation<D> simulation(problem);
  for (const double dt : {0.01, 0.02, 0.005, 0.01, 0.015}) simulation.step(dt);
  const double t = simulation.time(), of_velocity = t - simulation.velocity_lag();
  const Particles<D>&now = simulation.particles(), &start = problem.particles;
  double place = 0, velocity = 0, strain = 0;
  for (std::size_t p = 0; p < now.size(); ++p) {
    place = std::max(place, (now.x[p] - start.x[p] - a * (t * t / 2)).norm());
    velocity = std::max(velocity, (now.v[p] - a * of_velocity).norm());
    strain = std::max(strain, (now.F[p] - Matrix<D>::Identity()).norm());
  }
  const std::string what = problem.method.name + " in " + std::to_string(D) + "-D";
  EXPECT_LE(place, tolerance) << what;
  EXPECT_LE(velocity, 10 * tolerance) << what;
  EXPECT_LE(strain, 10 * tolerance) << what;
}

TEST_P(EveryMethodsPhysics, GravityIsExactForFreeFall) {
  in_its_dimensions([&](auto dimension) {
    constexpr int D = decltype(dimension)::value;
    Problem<D> problem = block<D>(8, 0.25, 0.5, GetParam().name);
    problem.gravity = some_acceleration<D>();
    expect_free_fall<D>(problem, problem.gravity, 1e-13);
  });
}

// A force per mass that is the same everywhere is gravity.
TEST_P(EveryMethodsPhysics, UniformBodyForceIsGravity) {
  in_its_dimensions([&](auto dimension) {
    constexpr int D = decltype(dimension)::value;
    Problem<D> problem = floating<D>(GetParam());
    const Vector<D> a = some_acceleration<D>();
    problem.body_force = [a](const Particles<D>&, double, int, std::vector<Vector<D>>& out) {
      for (Vector<D>& each : out) each += a;
    };
    expect_free_fall<D>(problem, a, 1e-11);
  });
}

// Forces on single particles that are all m a move the body as gravity does, where mass and forces
// are sums over the same particles.
TEST_P(EveryMethodsPhysics, UniformLoadIsGravity) {
  if (GetParam().quadrature != Quadrature::particles) return;
  in_its_dimensions([&](auto dimension) {
    constexpr int D = decltype(dimension)::value;
    Problem<D> problem = floating<D>(GetParam());
    const Vector<D> a = some_acceleration<D>();
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      problem.loads.push_back(
          point_load<D>(p, problem.particles.mass[p] * a, [](double) { return 1.0; }));
    expect_free_fall<D>(problem, a, 1e-11);
  });
}

// The same forces as a whole: after the first kick, half a step, the momentum is force dt / 2. Also
// where masses come from cells, whose sum of forces is that of the particles.
TEST_P(EveryMethodsPhysics, AccelerationsFollowTheLoad) {
  Problem<2> problem = block<2>(8, 0.25, 0.5, GetParam().name);
  problem.loads.push_back(point_load<2>(3, Vector<2>(2.0, -1.0), [](double t) { return 1 + t; }));
  Simulation<2> simulation(problem);
  simulation.map();
  Vector<2> force = Vector<2>::Zero();
  for (const auto& each : simulation.nodes().force) force += each;
  EXPECT_LE((force - Vector<2>(2, -1)).norm(), 1e-12) << GetParam().name;
}

// Nodes of a boundary have its velocity, before the step and after, and the others their own.
TEST_P(EveryMethodsPhysics, BoundariesHoldWhatTheySay) {
  Problem<2> problem = block<2>(8, 0, 1, GetParam().name);
  for (auto& v : problem.particles.v) v << 1, 2;
  problem.gravity << 3, -4;
  Boundary<2> fixed, roller, driven;
  fixed.velocity = {0.0, 0.0};
  roller.axis = 1;
  roller.at = 1;
  roller.velocity[1] = 0.0;
  driven.at = 1;
  driven.velocity[0] = 0.25;
  problem.boundaries = {fixed, roller, driven};
  Simulation<2> simulation(problem);
  const auto expect_held = [&](const char* when) {
    const auto& nodes = simulation.nodes();
    for (std::size_t i = 0; i < problem.grid.size(); ++i) {
      const Vector<2> x = problem.grid.position(i), v = nodes.velocity[i];
      if (nodes.mass[i] == 0) continue;
      if (x[0] == 0) {
        EXPECT_EQ(v, Vector<2>(0, 0)) << GetParam().name << when;
      } else if (x[0] == 1) {
        EXPECT_EQ(v[0], 0.25) << GetParam().name << when;
      } else if (x[1] == 1) {
        EXPECT_EQ(v[1], 0) << GetParam().name << when;
      }
    }
  };
  simulation.map();
  expect_held(" before");
  for (std::size_t i = 0; i < problem.grid.size(); ++i)
    if (simulation.nodes().mass[i] != 0) {
      EXPECT_LE((simulation.nodes().mapped[i] - Vector<2>(1, 2)).norm(), 1e-11) << GetParam().name;
    }
  if (GetParam().update == Update::fmpm || GetParam().update == Update::runge_kutta) return;
  simulation.step(1e-3);
  expect_held(" after");
}

// Particles on the walls themselves, so with half of their domains beyond: gravity pulls the body
// into the corner of two rollers, and it stays there, or the run has a warning.
TEST_P(EveryMethodsPhysics, ParticlesOnAWall) {
  Problem<2> problem;
  problem.grid = Grid<2>({0, 0}, {1, 1}, 0.1);
  problem.materials = {NeoHookean{Lame::from(2e5, 0.3)}};
  problem.densities = {1000};
  problem.method = GetParam();
  const double edge = 0.05;
  for (int j = 0; j <= 6; ++j)
    for (int i = 0; i <= 6; ++i)
      problem.particles.add({i * edge, j * edge}, Matrix<2>::Identity() * (edge / 2), 1000, 0);
  problem.gravity << -5, -9.81;
  for (const int axis : {0, 1}) {
    Boundary<2> roller{axis, 0, {}};
    roller.velocity[static_cast<std::size_t>(axis)] = 0.0;
    problem.boundaries.push_back(roller);
  }
  problem.time.end = 0.1;
  if (!forecast(problem).warnings.empty()) {
    EXPECT_FALSE(caveat(GetParam()).empty()) << GetParam().name;
    return;
  }
  Simulation<2> simulation(problem);
  double most = 0;
  EXPECT_NO_THROW(run_until(simulation, problem.time.end, [&] {
    most = std::max(most, account(simulation).total());
  })) << GetParam().name;
  // The work of gravity in the fall to twice the sag is about 2; bodies that break have hundreds.
  EXPECT_LE(most, 6.0) << GetParam().name;
  for (const auto& x : simulation.particles().x) EXPECT_GE(x.minCoeff(), -1e-7) << GetParam().name;
}

// What comes close to a face without a wall leaves.
TEST(Walls, OnlyWallsHold) {
  for (const bool wall : {true, false}) {
    Problem<1> problem = block<1>(10, 0.0, 0.2);
    for (auto& v : problem.particles.v) v[0] = -0.01;
    if (wall) problem.boundaries = {{0, 0, {0.0}}};
    Simulation<1> simulation(problem);
    bool left = false;
    try {
      for (int s = 0; s < 400; ++s) simulation.step(0.01);
    } catch (const Failure& failure) {
      left = std::string(failure.what()).find("left the grid") != std::string::npos;
    }
    EXPECT_EQ(left, !wall);
  }
}

// By default noise does not grow, in a body that fills its grid and in one that floats in it.
template <int D>
void expect_default_is_stable(const Method& method) {
  for (const bool free : {false, true}) {
    if (free && !caveat(method).empty()) continue;
    if (method.basis == Basis::q8) continue;  // no step is: stable_courant() is 0, so the run warns
    ASSERT_LE(method.default_courant(D), stable_courant(method, D)) << method.name;
    EXPECT_TRUE(is_stable(method, D, 2, method.default_courant(D), free))
        << method.name << " in " << D << "-D at " << method.default_courant(D)
        << (free ? ", free" : "");
  }
}
TEST_P(EveryMethodsPhysics, DefaultStepIsStable) {
  if (GetParam().basis != Basis::q8) expect_default_is_stable<1>(GetParam());
}
class SlowEveryMethodsPhysics : public EveryMethodsPhysics {};
INSTANTIATE_TEST_SUITE_P(Mpm, SlowEveryMethodsPhysics, testing::ValuesIn(methods()),
                         [](const auto& each) { return each.param.name; });
TEST_P(SlowEveryMethodsPhysics, DefaultStepIsStable) {
  expect_default_is_stable<2>(GetParam());
  if (GetParam().basis != Basis::q8) expect_default_is_stable<3>(GetParam());
}

// The stretched box is the box of the stretched edges, in S, in G and in the nodes that it touches;
// shear does not change it.
template <class T>
class StretchedBoxes : public testing::Test {};
TYPED_TEST_SUITE(StretchedBoxes, AllDimensions);
TYPED_TEST(StretchedBoxes, AreBoxesOfStretchedEdges) {
  constexpr int D = TypeParam::value;
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Constant(8), 1);
  std::mt19937 random(61);
  for (int round = 0; round < 30; ++round) {
    Vector<D> x, stretch;
    for (int d = 0; d < D; ++d) {
      x[d] = uniform(random, 3, 5);
      stretch[d] = uniform(random, 0.3, 3);
    }
    Particles<D> stretched, plain;
    stretched.add(x, Matrix<D>::Identity() * 0.3, 1, 0);
    stretched.F[0] = random_deformation<D>(random, 0.2);
    stretched.F[0].diagonal() = stretch;
    plain.add(x, Matrix<D>(0.3 * stretch.asDiagonal()), 1, 0);
    NodeFunctions<D> a, b;
    StretchedGimp{}.shape(grid, stretched, 0, a);
    UniformGimp{}.shape(grid, plain, 0, b);
    ASSERT_EQ(a.node, b.node);
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_NEAR(a.S[k], b.S[k], 1e-14);
      EXPECT_LE((a.G[k] - b.G[k]).norm(), 1e-14);
    }
    for (int d = 0; d < D; ++d)
      EXPECT_EQ(StretchedGimp{}.nodes_along(grid, stretched, 0, d),
                UniformGimp{}.nodes_along(grid, plain, 0, d));
  }
}

// A hypoelastic material stretched along one axis to J: sigma = (lambda + 2 mu) ln J, and its work
// per reference volume is (lambda + 2 mu) (J ln J - J + 1).
template <class T>
class FiniteStrain : public testing::Test {};
TYPED_TEST_SUITE(FiniteStrain, AllDimensions);
TYPED_TEST(FiniteStrain, EnergyOfLinearElasticIsItsWork) {
  constexpr int D = TypeParam::value;
  const LinearElastic material{Lame::from(100, 0.25)};
  const double stiffness = material.lambda + 2 * material.mu;
  for (const double J : {0.5, 2.0}) {
    constexpr int steps = 4000;
    const double rate = std::log(J) / steps;  // of ln J, in a step of 1
    Matrix<D> L = Matrix<D>::Zero(), F = Matrix<D>::Identity(), stress = L;
    L(D - 1, D - 1) = rate;
    double energy = 0;
    for (int s = 1; s <= steps; ++s) {
      F(D - 1, D - 1) = std::exp(rate * s);
      material.update(F, L, 1, stress, energy);
    }
    EXPECT_NEAR(stress(D - 1, D - 1), stiffness * std::log(J), 1e-9 * stiffness);
    const double work = stiffness * (J * std::log(J) - J + 1);
    EXPECT_NEAR(energy, work, 2e-3 * work) << J;  // of first order in the step
  }
}

}  // namespace
}  // namespace recon::mpm::test
