// The step of a GPU against Step.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "gpu/support.hpp"
#include "recon/gpu/run.hpp"

namespace recon::mpm::test {
namespace {

// A block that moves, turns and is pressed, between walls and above a floor that shakes.
template <int D>
Problem<D> lively(const std::string& method, const Material& material) {
  Problem<D> problem = block<D>(8, 0.25, 0.75, method);
  problem.materials = {material};
  problem.gravity[D - 1] = -3;
  Particles<D>& all = problem.particles;
  for (std::size_t p = 0; p < all.size(); ++p) {
    const Vector<D> from = all.x[p] - Vector<D>::Constant(0.5);
    for (int d = 0; d < D; ++d) {
      all.v[p][d] = 0.3 * std::sin(5 * all.x[p][(d + 1) % D] + d) - 0.2 * from[d];
      all.x[p][d] += 0.012 + 0.01 * std::sin(40 * all.X[p].sum() + d);
    }
    all.F[p] += 0.02 * Matrix<D>::Constant(std::sin(7 * all.x[p][0]));
  }
  for (int axis = 0; axis < D; ++axis) {
    Boundary<D> low, high;
    low.axis = high.axis = axis;
    low.at = 0.25;
    high.at = 1;
    low.velocity[static_cast<std::size_t>(axis)] = 0.0;
    high.velocity[static_cast<std::size_t>(axis)] = 0.0;
    if (axis == D - 1)
      low.velocity[0] = HeldVelocity<D>(typename HeldVelocity<D>::Function(
          [](const Vector<D>& x, double t) { return 0.1 * std::sin(50 * t + x[0]); }));
    problem.boundaries.push_back(low);
    problem.boundaries.push_back(high);
  }
  return problem;
}

template <int D>
double off_after(const Problem<D>& problem, int steps, std::string* of = nullptr) {
  State<D> cpu = start(problem), gpu = cpu;
  Step<D> step(problem);
  const auto there = make_on_host<D>(Plan<D>(problem));
  there->put(gpu);
  for (int s = 0; s < steps; ++s) {
    const TimeStep a = choose_step(problem, cpu.particles), b = there->choose_step();
    EXPECT_NEAR(a.dt, b.dt, 1e-12 * a.dt);
    step(cpu, a.dt);
    EXPECT_FALSE(there->step(a.dt));
  }
  there->bring(gpu);
  EXPECT_EQ(cpu.time, gpu.time);
  EXPECT_EQ(cpu.last_dt, gpu.last_dt);
  EXPECT_EQ(cpu.steps, gpu.steps);
  return difference(problem, cpu, gpu, of);
}

template <class Work>
void for_dimensions(const Work& work) {
  work(std::integral_constant<int, 1>{});
  work(std::integral_constant<int, 2>{});
  work(std::integral_constant<int, 3>{});
}

std::vector<Material> all_materials() {
  const Lame elastic = Lame::from(1000, 0.3);
  return {NeoHookean{elastic}, LinearElastic{elastic}, VonMises{elastic, 5, 100},
          SmallStrain{elastic}};
}

// Differences as a part of the largest number of an array (support.hpp), after 20 steps.
template <int D>
void expect_the_same(const Problem<D>& problem, const std::string& what, double bound = 1e-12) {
  std::string of;
  const double off = off_after(problem, 20, &of);
  EXPECT_LT(off, bound) << D << "-D, " << what << ": " << of;
  if (std::getenv("RECON_PRINT_DIFFERENCES"))
    std::printf("%d-D %s: %.1e of %s\n", D, what.c_str(), off, of.c_str());
}

TEST(GpuStep, IsThatOfTheProcessorForAllMaterials) {
  ASSERT_EQ(all_materials().size(), std::variant_size_v<Material>);
  for_dimensions([](auto d) {
    for (const char* method : {"mpm", "affine_cpdi2", "impm"})
      for (const Material& material : all_materials()) {
        auto problem = lively<decltype(d)::value>(method, material);
        problem.time.courant = 0.2;
        expect_the_same(problem, std::string(method) + " " + std::string(name_of(material)));
      }
  });
}

TEST(GpuStep, IsThatOfTheProcessorForAllMethods) {
  const std::vector<std::string> methods = methods_on_gpu();
  for (const char* name : {"mpm", "impm", "cpdi2", "affine_cpdi2", "improved_cpdi", "bspline2",
                           "bspline3", "apic", "mls_mpm"})
    EXPECT_NE(std::find(methods.begin(), methods.end(), name), methods.end()) << name;
  for_dimensions([&](auto d) {
    for (const std::string& method : methods)
      expect_the_same(lively<decltype(d)::value>(method, all_materials()[0]), method);
  });
}

TEST(GpuStep, IsThatOfTheProcessorForAllChoices) {
  for_dimensions([](auto d) {
    constexpr int D = decltype(d)::value;
    const auto expect = [](const std::string& method, const std::string& what, const auto& choose,
                           double bound = 1e-12) {
      Problem<D> problem = lively<D>(method, all_materials()[0]);
      problem.time.courant = 0.1;  // stress first is not stable with all steps here
      choose(problem);
      problem.method.validate(D);
      expect_the_same(problem, method + " " + what, bound);
    };
    for (const std::string method : {"mpm", "bspline2", "affine_cpdi2", "impm"}) {
      expect(method, "first", [](auto& p) { p.method.stress = StressUpdate::first; });
      expect(method, "musl", [](auto& p) { p.method.stress = StressUpdate::musl; });
      expect(method, "symplectic_euler",
             [](auto& p) { p.method.scheme = Scheme::symplectic_euler; });
      expect(method, "blend", [](auto& p) { p.method.blend = 0.3; });
      expect(method, "blend_rate", [](auto& p) { p.method.blend_rate = 20; });
      expect(method, "pic", [](auto& p) {
        p.method.blend = 0;
        p.method.update = Update::pic;
      });
      expect(method, "damping", [](auto& p) { p.damping = {0.3, 4}; });
      expect(method, "fixed step", [](auto& p) {
        p.time.rule = StepRule::fixed;
        p.time.step = 0.004;
      });
      expect(method, "p_wave", [](auto& p) { p.time.rule = StepRule::p_wave; });
      expect(method, "bar_wave", [](auto& p) { p.time.rule = StepRule::bar_wave; });
    }
    // Slopes along an axis on which a particle sees one node alone are not shown.
    for (const char* method : {"mpm", "bspline2", "cpdi2"})
      expect(
          method, "affine, on nodes",
          [](auto& p) {
            p.method.velocity = VelocityMap::affine;
            const double h = p.grid.h();
            for (std::size_t i = 0; i < p.particles.size(); ++i) {
              p.particles.L[i] = Matrix<D>::Constant(0.3) + Matrix<D>::Identity() * 0.1;
              if (i % 3 == 0) p.particles.x[i][0] = std::round(p.particles.x[i][0] / h) * h;
              if (i % 5 == 0) p.particles.half_edges[i] *= 1e-3;
            }
          },
          1e-10);  // rounding grows with gradients over so small domains
    for (const SplineBorder border :
         {SplineBorder::corrected, SplineBorder::extra_column, SplineBorder::linear_cells})
      for (const char* method : {"bspline2", "bspline3", "mls_mpm"})
        expect(method, std::string(name_of(border)), [&](auto& p) {
          p.method.border = border;
          // Into the outermost cells of the grid.
          for (Vector<D>& x : p.particles.x) x = 1.7 * x - Vector<D>::Constant(0.35);
          for (Boundary<D>& each : p.boundaries)
            if (each.at == 0.25) each.at = 0;
        });
  });
}

// Two bodies of different materials, one alone in its cells, none in most of them; one of the
// particles beyond a wall by less than is noticed.
TEST(GpuStep, FewParticlesAndWalls) {
  for_dimensions([](auto d) {
    constexpr int D = decltype(d)::value;
    for (const char* method :
         {"mpm", "bspline2", "mls_mpm", "cpdi2", "affine_cpdi2", "impm", "improved_cpdi"}) {
      Problem<D> problem = block<D>(10, 0.5, 0.5, method);
      problem.materials = {all_materials()[0], all_materials()[2]};
      problem.densities = {1000, 500};
      const Matrix<D> half = Matrix<D>::Identity() * 0.02;
      const double h = problem.grid.h();
      for (const double at : {-0.5e-6 * h, 0.3, 0.33, 0.5, 0.99}) {
        Vector<D> x = Vector<D>::Constant(0.4);
        x[0] = at;
        problem.particles.add(x, half, 1000, at < 0.4 ? 0 : 1);
        problem.particles.v.back()[0] = at < 0.1 ? 0 : 0.2;
      }
      Boundary<D> wall, beyond;
      wall.velocity[0] = beyond.velocity[0] = 0.0;
      beyond.at = 1;
      problem.boundaries = {wall, beyond};
      // Few particles resist nothing, so that rounding grows.
      expect_the_same(problem, std::string(method) + ", few particles", 1e-10);
      State<D> s = start(problem);
      const auto there = make_on_host<D>(Plan<D>(problem));
      there->put(s);
      EXPECT_FALSE(there->step(1e-4));
      there->bring(s);
      if (problem.method.domain == Domain::point) {
        EXPECT_EQ(s.particles.x[0][0], 0) << method;
      }
    }
  });
}

// Densities that differ so much that fits of them are negative at the centres of cells, and too few
// particles for a fit at some nodes.
TEST(GpuStep, WatchesMassesAndFits) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    Problem<2> problem = block<2>(8, 0.25, 0.75, "impm");
    problem.materials = {NeoHookean{Lame::from(1e-6, 0.3)}};
    std::mt19937 random(seed);
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      double& x = problem.particles.x[p][0];
      if (x > 0.375 && x < 0.5) problem.particles.mass[p] *= 1000;
      if (x < 0.375) x = 0.35 + 0.1 * (x - 0.25);  // so the slope is negative at the cells' centres
      problem.particles.v[p] = {uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
    }
    for (const Vector<2>& x : {Vector<2>(0.03, 0.9), Vector<2>(0.9, 0.03), Vector<2>(0.92, 0.04)})
      problem.particles.add(x, Matrix<2>::Identity() * 0.02, 1000, 0);
    State<2> s = start(problem);
    Step<2> step(problem);
    const auto there = make_on_host<2>(Plan<2>(problem));
    there->put(s);
    for (int k = 0; k < 3; ++k) {
      step.to_nodes(s);
      there->map();
      EXPECT_EQ(there->unfitted(), step.nodes().unfitted);
      const MassSigns mine = step.signs(), its = there->signs();
      ASSERT_EQ(mine.negative.has_value(), its.negative.has_value());
      ASSERT_TRUE(mine.negative);
      EXPECT_EQ(mine.negative->node, its.negative->node);
      EXPECT_EQ(mine.negative->step, its.negative->step);
      EXPECT_NEAR(mine.negative->mass, its.negative->mass, 1e-10 * step.nodes().heaviest());
      ASSERT_EQ(mine.change.has_value(), its.change.has_value());
      if (mine.change) {
        EXPECT_EQ(mine.change->node, its.change->node);
        EXPECT_EQ(mine.change->step, its.change->step);
      }
      step.to_particles(s, 1e-6);
      EXPECT_FALSE(there->step(1e-6));
    }
  }
}

TEST(GpuStep, NamesTheFirstParticleThatLimitsTheStep) {
  Problem<2> problem = block<2>(8, 0.25, 0.75, "mpm");
  for (const std::size_t p : {11u, 30u, 45u}) problem.particles.v[p] = {3, 0};
  for (const StepRule rule : {StepRule::adaptive, StepRule::p_wave, StepRule::bar_wave}) {
    problem.time.rule = rule;
    const auto there = make_on_host<2>(Plan<2>(problem));
    there->put(start(problem));
    const TimeStep here = choose_step(problem, problem.particles), step = there->choose_step();
    EXPECT_EQ(step.particle, here.particle);
    EXPECT_EQ(step.particle, rule == StepRule::adaptive ? 11u : 0u);
    EXPECT_NEAR(step.dt, here.dt, 1e-15);
  }
}

// Of boundaries that hold one component the last counts, and their order is that of the problem.
TEST(GpuStep, TheLastOfSeveralBoundariesHolds) {
  Problem<2> problem = lively<2>("mpm", all_materials()[0]);
  Boundary<2> first, last;
  first.axis = last.axis = 1;
  first.at = last.at = 0.5;
  first.velocity[0] = 0.2;
  last.velocity[0] = HeldVelocity<2>([](const Vector<2>& x, double t) { return x[0] * t; });
  last.from = Vector<2>(0.4, 0);
  problem.boundaries.push_back(first);
  problem.boundaries.push_back(last);
  expect_the_same(problem, "two boundaries");
  std::swap(problem.boundaries[4], problem.boundaries[5]);
  expect_the_same(problem, "two boundaries, swapped");
}

TEST(GpuStep, HasTheSameBitsInEveryRun) {
  for (const char* method : {"mpm", "apic", "affine_cpdi2", "impm"}) {
    const Problem<2> problem = lively<2>(method, all_materials()[2]);
    std::vector<State<2>> ends;
    for (int run = 0; run < 2; ++run) {
      State<2> s = start(problem);
      const auto there = make_on_host<2>(Plan<2>(problem));
      there->put(s);
      for (int step = 0; step < 10; ++step) there->step(there->choose_step().dt);
      there->bring(s);
      ends.push_back(s);
    }
    EXPECT_EQ(difference(problem, ends[0], ends[1]), 0) << method;
  }
}

TEST(GpuStep, SaysWhichParticleCannotGoOn) {
  const auto expect = [](const Problem<2>& problem, double dt, bool turned) {
    State<2> cpu = start(problem);
    Step<2> step(problem);
    std::optional<std::size_t> particle;
    try {
      step(cpu, dt);
    } catch (const Failure& failure) {
      particle = failure.number();
    }
    ASSERT_TRUE(particle);
    const auto there = make_on_host<2>(Plan<2>(problem));
    there->put(start(problem));
    const auto stopped = there->step(dt);
    ASSERT_TRUE(stopped);
    EXPECT_EQ(stopped->particle, *particle);
    EXPECT_EQ(stopped->turned, turned);
  };
  for (const char* method : {"mpm", "cpdi2"})
    for (const StressUpdate stress :
         {StressUpdate::last, StressUpdate::first, StressUpdate::musl}) {
      Problem<2> problem = block<2>(8, 0.25, 0.75, method);
      problem.method.stress = stress;
      for (Vector<2>& v : problem.particles.v) v = {20, 1};
      expect(problem, 0.1, false);
      for (std::size_t p = 0; p < problem.particles.size(); ++p)
        problem.particles.v[p] = -20 * (problem.particles.x[p] - Vector<2>(0.5, 0.5));
      if (stress != StressUpdate::first) expect(problem, 0.06, true);
    }
  // The first row leaves the grid and the last one is turned inside out, in one block of the loop
  // over particles, where all are strained first, or in two; and the other way round.
  for (const int cells : {16, 40})
    for (const double speed : {-100.0, 100.0}) {
      Problem<2> problem = block<2>(cells, 0.25, 0.75, "mpm");
      const std::size_t count = problem.particles.size(), row = static_cast<std::size_t>(cells);
      for (std::size_t p = 0; p < count; ++p)
        if (p < row || p >= count - row) problem.particles.v[p] = {0, speed};
      expect(problem, 0.01, cells == 16 || speed > 0);
    }
}

// What docs/gpu.md says of a particle, with 8 of them in a cell; sorting takes 8 bytes of each key more
// than here.
TEST(GpuStep, MemoryOfAParticle) {
  const auto bytes_of = [](const std::string& method) {
    Problem<3> problem;
    problem.grid = Grid<3>(Vector<3>::Zero(), Vector<3>::Ones(), 1.0 / 16);
    problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
    problem.densities = {1};
    problem.method = method_named(method);
    const double edge = problem.grid.h() / 2;
    for (int i = 0; i < 32 * 32 * 32; ++i)
      problem.particles.add(
          edge * (Vector<3>(i % 32, i / 32 % 32, i / 1024) + Vector<3>::Constant(0.5)),
          Matrix<3>::Identity() * (edge / 2), 1, 0);
    const auto host = std::make_shared<cuda::Host>();
    StepOnHost<3> step(host, Plan<3>(problem));
    step.put(start(problem));
    step.step(step.choose_step().dt);
    return static_cast<double>(host->bytes()) / (32 * 32 * 32);
  };
  EXPECT_LE(bytes_of("mpm") + 8, 600);
  EXPECT_LE(bytes_of("impm") + 2 * 8, 850);
  EXPECT_LE(bytes_of("affine_cpdi2") + 8 * 8, 2300);
}

}  // namespace
}  // namespace recon::mpm::test
