// A step as a function of a state, and the choices that every method may make: blends of flip and
// pic, the order of stress, the kick, affine velocities over domains.
#include "recon/mpm/step.hpp"

#include <Eigen/Geometry>
#include <cstring>
#include <fstream>
#include <sstream>

#include "recon/runs/compose.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"
#include "recon/runs/simulation.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

// A block that moves, turns and strains, with particles off the middle of their places.
template <int D>
Problem<D> moving_block(const std::string& method, std::uint32_t seed = 3) {
  Problem<D> problem = block<D>(8, 0.25, 0.75, "mpm");
  problem.method = composed(method);
  std::mt19937 random(seed);
  Particles<D>& particles = problem.particles;
  for (std::size_t p = 0; p < particles.size(); ++p)
    for (int d = 0; d < D; ++d) {
      particles.x[p][d] += uniform(random, -0.01, 0.01);
      particles.v[p][d] = uniform(random, -0.1, 0.1) + particles.x[p][(d + 1) % D];
    }
  return problem;
}

template <int D>
Particles<D> after(const Problem<D>& problem, int steps, double dt = 0.005) {
  Simulation<D> simulation(problem);
  for (int s = 0; s < steps; ++s) simulation.step(dt);
  return simulation.particles();
}

template <class T>
void expect_same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  ASSERT_EQ(a.size(), b.size());
  if (a.empty()) return;  // there is no memory to compare
  EXPECT_EQ(0, std::memcmp(a.data(), b.data(), a.size() * sizeof(T)));
}

// All that is in a state decides what comes next: a step of a copy, made by another object, is the
// same step.
TEST(StepFunction, OfTheStateAlone) {
  for (const Method& method : methods()) {
    Problem<2> problem = moving_block<2>(method.name);
    if (has_negative_functions(method.name)) continue;  // broken by the jitter
    State<2> a = start(problem);
    Step<2> one(problem);
    for (int s = 0; s < 3; ++s) one(a, 0.002);
    State<2> b = a;
    Step<2> other(problem);
    one(a, 0.003);
    other.to_nodes(b);
    other(b, 0.003);
    EXPECT_EQ(a.steps, 4);
    EXPECT_EQ(a.time, b.time);
    a.particles.arrays(problem.kept(), [&](const ParticleArray& array, const auto& values) {
      b.particles.arrays(problem.kept(), [&](const ParticleArray& of, const auto& others) {
        if constexpr (std::is_same_v<decltype(values), decltype(others)>) {
          if (std::string(array.name) == of.name) expect_same_bits(values, others);
        }
      });
    });
    Simulation<2> simulation(problem);
    for (int s = 0; s < 3; ++s) simulation.step(0.002);
    simulation.step(0.003);
    expect_same_bits(simulation.particles().x, a.particles.x);
  }
}

TEST(StepFunction, EveryArrayIsInTheList) {
  Particles<2> particles;
  particles.add({0, 0}, Matrix<2>::Identity(), 1, 0);
  std::size_t bytes = 0, arrays = 0;
  particles.arrays({1, 1, 1}, [&](const ParticleArray&, auto& values) {
    ++arrays;
    bytes += sizeof(values);
    values.resize(7);
  });
  EXPECT_EQ(bytes, sizeof(particles));  // all members are arrays of the list
  EXPECT_EQ(arrays, 14u);
}

// What docs/mpm.md prints as the step is the code.
TEST(StepFunction, IsWhatTheDocumentationPrints) {
  const auto contents = [](const std::string& name) {
    std::ifstream file(std::filesystem::path(RECON_SOURCE_DIR) / name);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  };
  const std::string code = contents("src/mpm/step.cpp") + contents("src/mpm/update.cpp");
  const std::string page = contents("docs/mpm.md");
  const std::size_t section = page.find("\n## One step\n");
  ASSERT_NE(section, std::string::npos);
  const std::string text = page.substr(section, page.find("\n## ", section + 1) - section);
  const std::string fence = "```cpp\n";
  int blocks = 0;
  for (std::size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at + 1)) {
    const std::size_t begin = at + fence.size();
    const std::string block = text.substr(begin, text.find("```", begin) - begin);
    if (block.find("int main()") != std::string::npos) continue;  // compiled and run elsewhere
    ++blocks;
    EXPECT_NE(code.find(block), std::string::npos) << block;
  }
  EXPECT_EQ(blocks, 2);
}

TEST(Blends, AreFlipAndPicAtTheirEnds) {
  for (const char* domain : {"mpm", "cpdi1", "bspline2", "cpls"}) {
    const std::string name = domain;
    const auto flip = after(moving_block<2>(name), 5),
               pic = after(moving_block<2>(name + "+pic"), 5);
    const auto none = after(moving_block<2>(name + "+blend=0"), 5),
               whole = after(moving_block<2>(name + "+flip+blend=1"), 5);
    expect_same_bits(none.v, flip.v);
    expect_same_bits(none.x, flip.x);
    expect_same_bits(none.stress, flip.stress);
    expect_same_bits(whole.v, pic.v);
    expect_same_bits(whole.x, pic.x);
    expect_same_bits(whole.stress, pic.stress);
    EXPECT_NE(flip.v[0], pic.v[0]);
  }
}
TEST(Blends, AreMeansBetween) {
  const auto flip = after(moving_block<2>("cpdi1"), 1),
             pic = after(moving_block<2>("cpdi1+pic"), 1);
  for (const double part : {0.05, 0.5, 0.9}) {
    const auto mixed = after(moving_block<2>("cpdi1+blend=" + std::to_string(part)), 1);
    for (std::size_t p = 0; p < mixed.size(); ++p)
      EXPECT_LE((mixed.v[p] - (1 - part) * flip.v[p] - part * pic.v[p]).norm(), 1e-15);
  }
}

// A rate takes as much in a time whatever the steps: of what FLIP keeps and PIC does not see, here all
// velocities of particles in pairs that cancel, exp(-rate t) is left, after the first kick of half a
// step as well. With both the parts that are left multiply.
TEST(Blends, MayBeRates) {
  const double rate = 3, end = 0.5;
  const auto left = [&](int steps, const std::string& choices) {
    Problem<1> problem;
    problem.grid = Grid<1>(Vector<1>(0.0), Vector<1>(1.0), 0.25);
    problem.materials = {NeoHookean{Lame{0, 0.5}}};
    problem.densities = {1};
    problem.method = composed("mpm+blend_rate=3" + choices);
    for (const double sign : {-1.0, 1.0}) {  // at one place
      problem.particles.add(Vector<1>(0.4), Matrix<1>(0.05), 1, 0);
      problem.particles.v.back()[0] = sign;
    }
    Simulation<1> simulation(problem);
    for (int s = 0; s < steps; ++s) simulation.step(end / steps);
    EXPECT_NEAR(simulation.particles().v[0][0], -simulation.particles().v[1][0], 1e-14);
    return simulation.particles().v[1][0];
  };
  for (const int steps : {5, 10, 40}) {
    const double felt = end - end / steps / 2;
    EXPECT_NEAR(left(steps, ""), std::exp(-rate * felt), 1e-13);
    EXPECT_NEAR(left(steps, "+blend=0.1"), std::exp(-rate * felt) * std::pow(0.9, steps), 1e-13);
  }
  EXPECT_EQ(left(5, "+blend=1"), 0);
}

// Velocities that are half a step older make the same motion: the first kick of leapfrog after a
// step of the same length is a whole one.
TEST(Schemes, EulerIsLeapfrogFromAnotherStart) {
  const double dt = 0.004;
  for (const char* name : {"mpm", "cpls", "apic", "xpic", "impm"}) {
    const Problem<2> problem = moving_block<2>(name);
    Simulation<2> leapfrog(problem),
        euler(moving_block<2>(std::string(name) + "+symplectic_euler"));
    leapfrog.restore(leapfrog.particles(), 0, 0, dt);
    EXPECT_EQ(leapfrog.velocity_lag(), dt / 2);
    for (int s = 0; s < 6; ++s) {
      leapfrog.step(dt);
      euler.step(dt);
    }
    EXPECT_EQ(euler.velocity_lag(), 0);
    expect_same_bits(leapfrog.particles().x, euler.particles().x);
    expect_same_bits(leapfrog.particles().v, euler.particles().v);
  }
}

// The strain of MUSL is that of the updated velocities as the nodes see them from the old places.
TEST(Musl, StrainsByTheVelocitiesMappedAgain) {
  for (const char* name : {"mpm", "cpdi1", "bspline3", "cpls"}) {
    const double dt = 0.003;
    const Problem<2> problem = moving_block<2>(name);
    Simulation<2> musl(moving_block<2>(std::string(name) + "+musl")), usual(problem);
    usual.step(dt);
    musl.step(dt);
    expect_same_bits(musl.particles().v, usual.particles().v);
    expect_same_bits(musl.particles().x, usual.particles().x);
    Problem<2> again = problem;
    again.particles.v = usual.particles().v;
    Simulation<2> mapped(again);
    mapped.map();
    with_shape(problem.method, [&](auto shape_of) {
      typename decltype(shape_of)::template Nodes<2> shape;
      for (std::size_t p = 0; p < problem.particles.size(); ++p) {
        shape_of.shape(problem.grid, problem.particles, p, shape);
        EXPECT_LE((musl.particles().L[p] - shape.gradient(mapped.nodes().velocity)).norm(), 1e-12);
      }
    });
  }
}

// What the original method does not do with stress last: a disk that spins turns as a whole, a
// bar that is pulled stretches.
TEST(Musl, LetsPointsTurn) {
  const auto spin = [](const std::string& method) {
    Problem<2> problem = read_example<2>("spin.toml", {"method.name=" + method}).problem;
    Simulation<2> simulation(problem);
    simulation.map();
    const double angular = account(simulation).angular[2];
    run_until(simulation, problem.time.end / 8);
    simulation.map();
    EXPECT_NEAR(account(simulation).angular[2], angular, 0.02 * angular) << method;
    const Matrix<2> turn = Eigen::Rotation2Dd(0.5 * simulation.time()).toRotationMatrix();
    double most = 0;
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      most = std::max(most, (simulation.particles().x[p] - turn * problem.particles.X[p]).norm());
    return most;
  };
  EXPECT_LE(spin("mpm+musl"), 0.02);
}

std::string pulled_bar(const std::string& method) {
  return R"toml([grid]
lower = [0.0]
upper = [1.1]
cells = 50
[material]
kind = "linear_elastic"
young = 100
poisson = 0
density = 100
[[body]]
shape = "box"
lower = [0.0]
upper = [1.0]
[[boundary]]
axis = "x"
at = 0
kind = "fixed"
[[pressure]]
side = "x_upper"
magnitude = "-sin(pi*t)*(t<1)"
[method]
name = ")toml" +
         method + R"toml("
[time]
end = 2
rule = "fixed"
step = 0.002
)toml";
}

// A half sine that runs through a bar at unit speed: u(L, 1) = integral of sin(pi t) / (rho c) =
// 0.02 / pi; at the wall the stress is twice that of the wave.
TEST(Musl, LetsABarBePulled) {
  const auto run = [](const std::string& method, double until) {
    const auto file = std::get<ProblemFile<1>>(read_problem_text(pulled_bar(method), "bar.toml"));
    Simulation<1> simulation(file.problem);
    run_until(simulation, until);
    return simulation.particles();
  };
  const auto pulled = [&](const std::string& method) {
    const Particles<1> at_one = run(method, 1);
    return (at_one.x.back()[0] - at_one.X.back()[0]) / (0.02 / std::acos(-1.0));
  };
  EXPECT_NEAR(pulled("mpm+musl"), 1, 0.05);  // points that cross cells are a poor quadrature
  EXPECT_NEAR(pulled("cpdi1+musl"), 1, 0.005);
  EXPECT_NEAR(run("mpm+musl", 1.5).stress.front()(0, 0), 2, 0.2);
  run("mpm+musl", 2);
}

// An affine velocity is kept by its map over any domain, in all its parts.
template <class T>
class AffineDomains : public testing::Test {};
TYPED_TEST_SUITE(AffineDomains, AllDimensions);
TYPED_TEST(AffineDomains, KeepLinearFieldsAndMomentum) {
  constexpr int D = TypeParam::value;
  for (const char* name : {"mpm", "ugimp", "cpgimp", "cpdi1", "cpdi2", "bspline2"})
    for (const char* update : {"pic", "flip+blend=0.1"}) {
      Problem<D> problem = moving_block<D>(std::string(name) + "+affine+" + update);
      problem.materials = {NeoHookean{Lame::from(1e-20, 0.3)}};
      std::mt19937 random(5);
      const Matrix<D> slope = random_deformation<D>(random, 0.5) - Matrix<D>::Identity();
      for (std::size_t p = 0; p < problem.particles.size(); ++p) {
        problem.particles.v[p] = slope * problem.particles.x[p];
        problem.particles.L[p] = slope;
      }
      Simulation<D> simulation(problem);
      const double dt = 0.01;
      simulation.map();
      const Ledger before = account(simulation);
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(before.momentum[d], before.node_momentum[d], 1e-9 * before.mass);
      for (std::size_t i = 0; i < simulation.nodes().mass.size(); ++i)
        if (simulation.nodes().mass[i] > 0) {
          EXPECT_LE((simulation.nodes().mapped[i] - slope * problem.grid.position(i)).norm(), 1e-12)
              << name << " " << update;
        }
      simulation.step(dt);
      const Particles<D>& now = simulation.particles();
      for (std::size_t p = 0; p < now.size(); ++p)
        for (int d = 0; d < D; ++d)
          EXPECT_LE((now.modes[p * D + d] - slope.col(d)).norm(), 1e-10) << name << " " << update;
    }
}

// What goes to the nodes is all of the particles' angular momentum, that of their own fields
// included; and it comes back, where forces are internal.
TEST(AffineOverDomains, AngularMomentumGoesToTheNodesAndBack) {
  for (const char* name : {"ugimp", "cpgimp", "cpdi1"}) {
    Problem<2> problem = moving_block<2>(std::string(name) + "+affine+pic");
    Simulation<2> simulation(problem);
    simulation.step(0.002);
    simulation.map();
    const Ledger here = account(simulation);
    const double size = here.mass * 0.5;
    EXPECT_NEAR(here.angular[2], here.node_angular[2], 1e-12 * size) << name;
    // On the way back it is kept before the particles have moved: D_p is what it was. A step of
    // next to no length moves nothing to speak of.
    simulation.step(1e-9);
    simulation.map();
    const Ledger there = account(simulation);
    EXPECT_NEAR(here.angular[2], there.angular[2], 1e-8 * size) << name;
    // Without the particles' own fields much is lost on the same way.
    Problem<2> plain = problem;
    plain.method.velocity = VelocityMap::mass_weighted;
    Simulation<2> damped(plain);
    damped.map();
    const double first = account(damped).angular[2];
    damped.step(1e-9);
    damped.map();
    EXPECT_GT(std::abs(account(damped).angular[2] - first), 1e-4 * size) << name;
  }
}

}  // namespace
}  // namespace recon::mpm::test
