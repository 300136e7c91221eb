// The material point method: time per particle and step of each method, and how much of it the
// reconstructions take.
#include "lab.hpp"

#ifdef RECON_BENCH_HAS_MPM

#include <algorithm>
#include <cmath>
#include <memory>

#include "hand_step.hpp"
#include "recon/runs/simulation.hpp"

namespace recon_bench {
namespace {

using namespace recon::mpm;

constexpr double impm_goal = 3;
// The most that a step may cost, in times of another one.
struct Aim {
  const char *method, *reference;
  double most;
  bool in_2d;
};
constexpr Aim aims[] = {
    {"apic", "bspline2", 1.25, true}, {"fmpm", "ugimp", 2, true}, {"cpls", "cpdi1", 2, false}};
constexpr double hand_goal = 1.5;

// A block that fills the grid, 2 particles per cell and axis, in a linear velocity field.
template <int D>
Problem<D> full_block(std::size_t cells, const Method& method, int threads) {
  Problem<D> problem;
  problem.grid = Grid<D>(Vector<D>::Zero(), Vector<D>::Ones(), 1.0 / static_cast<double>(cells));
  problem.materials = {NeoHookean{recon::mpm::Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = method;
  problem.threads = threads;
  const std::size_t along = 2 * cells;
  const double edge = problem.grid.h() / 2;
  std::size_t count = 1;
  for (int d = 0; d < D; ++d) count *= along;
  for (std::size_t i = 0; i < count; ++i) {
    Vector<D> X;
    std::size_t rest = i;
    for (int d = 0; d < D; ++d, rest /= along)
      X[d] = (static_cast<double>(rest % along) + 0.5) * edge;
    problem.particles.add(X, Matrix<D>::Identity() * (edge / 2), 1000, 0);
    for (int d = 0; d < D; ++d) problem.particles.v.back()[d] = 0.1 * X[(d + 1) % D] - 0.05;
    problem.particles.L.back().setZero();
    for (int d = 0; d < D; ++d) problem.particles.L.back()(d, (d + 1) % D) += 0.1;
  }
  return problem;
}

// The same block, to be stepped by hand.
template <int D>
hand_written::MpmStep<D> by_hand(const Problem<D>& problem) {
  std::vector<std::array<double, D>> x(problem.particles.size()), v(x.size());
  for (std::size_t p = 0; p < x.size(); ++p)
    for (int d = 0; d < D; ++d) {
      x[p][d] = problem.particles.x[p][d];
      v[p][d] = problem.particles.v[p][d];
    }
  const Lame& elastic = lame(problem.materials[0]);
  return {problem.grid.cells(0), x,         v, problem.particles.volume0[0], problem.densities[0],
          elastic.lambda,        elastic.mu};
}

// How far both are apart after ten steps, in which particles move by up to a third of a cell: the
// greatest difference of places and velocities, of which the greatest are about 1.
template <int D>
double hand_differs(std::size_t cells, int threads) {
  constexpr int steps = 10;
  Problem<D> problem = full_block<D>(cells, method_named("mpm"), threads);
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    for (int d = 0; d < D; ++d)
      problem.particles.v[p][d] = 0.2 * std::sin(6.2831853 * problem.particles.x[p][d]);
  const double dt = 0.2 * problem.grid.h() / Lame::from(1000, 0.3).p_wave_speed(1000);
  Simulation<D> simulation(problem);
  auto hand = by_hand(problem);
  for (int i = 0; i < steps; ++i) {
    simulation.step(dt);
    hand(dt, threads);
  }
  double most = 0;
  const auto x = hand.positions(), v = hand.velocities();
  for (std::size_t p = 0; p < x.size(); ++p)
    for (int d = 0; d < D; ++d) {
      most = std::max(most, std::abs(x[p][d] - simulation.particles().x[p][d]));
      most = std::max(most, std::abs(v[p][d] - simulation.particles().v[p][d]));
    }
  return most;
}

// Mass is complete, and fitted maps reproduce the linear field.
template <int D>
double worst(const Simulation<D>& simulation) {
  const auto& nodes = simulation.nodes();
  double mass = 0, total = 0, error = 0;
  for (std::size_t p = 0; p < simulation.particles().size(); ++p)
    total += simulation.particles().mass[p];
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    mass += nodes.mass[i];
    const Vector<D> x = simulation.problem().grid.position(i);
    for (int d = 0; d < D; ++d)
      error = std::max(error, std::abs(nodes.mapped[i][d] - (0.1 * x[(d + 1) % D] - 0.05)));
  }
  const bool fitted = simulation.problem().method.velocity != VelocityMap::mass_weighted;
  return std::max(std::abs(mass / total - 1) / 1e-9, fitted ? error / 1e-9 : 0.0);
}

// q8 is for 2-D; hopic's cubic fits by lists would take longer in 3-D than all others together.
template <int D>
bool can_run(const Method& method) {
  return D == 2 || (method.basis != Basis::q8 && method.update != Update::runge_kutta);
}

template <int D>
void time_methods(Lab& lab, std::size_t cells, Table& table) {
  const std::string name = std::to_string(D) + "-D";
  progress("mpm, " + name);
  std::vector<std::unique_ptr<Simulation<D>>> simulations;
  std::vector<Contestant> all;
  std::vector<const Method*> compared;
  for (const Method& method : methods())
    if (can_run<D>(method)) compared.push_back(&method);
  for (const int threads : {lab.context.threads, 1})
    for (const Method* each : compared) {
      const Method& method = *each;
      auto& made = simulations.emplace_back(
          std::make_unique<Simulation<D>>(full_block<D>(cells, method, threads)));
      made->map();
      lab.checks.within(worst(*made), "mpm " + name + ", " + method.name);
      all.push_back({method.name + (threads == 1 ? ", one thread" : ""), [&made = *made] {
                       made.step(1e-6);  // nothing moves to speak of: every step is like the first
                     }});
    }
  const Problem<D> block = full_block<D>(cells, method_named("mpm"), lab.context.threads);
  auto hand = by_hand(block);
  lab.checks.within(hand_differs<D>(cells, lab.context.threads) / 1e-12,
                    "mpm " + name + ", the step by hand");
  all.push_back({"by hand", [&] { hand(1e-6, lab.context.threads); }});
  const auto particles = static_cast<double>(simulations.front()->particles().size());
  const auto times = lab.stopwatch.run("mpm/" + name, all, 3);
  const std::size_t count = compared.size();
  const auto time_of = [&](const auto& is_it) {
    const auto found = std::find_if(compared.begin(), compared.end(),
                                    [&](const Method* method) { return is_it(*method); });
    return times[static_cast<std::size_t>(found - compared.begin())];
  };
  const auto named = [](const char* wanted) {
    return [wanted](const Method& method) { return method.name == wanted; };
  };
  for (std::size_t m = 0; m < count; ++m) {
    const Method& method = *compared[m];
    // The same particles and functions with nothing but the mass-weighted map.
    const Times base = time_of([&](const Method& plain) {
      return plain.domain == method.domain &&
             plain.basis == (method.basis == Basis::mls_bspline2 ? Basis::bspline2 : method.basis);
    });
    const double ns = times[m].best() / particles * 1e9;
    table.add({name, number(particles), method.name, number(ns), number(1e3 / ns),
               number(times[m + count].best() / times[m].best()),
               number(100 * std::max(0.0, 1 - base.best() / times[m].best())),
               number(speedup(time_of(named("mpm")), times[m]))});
  }
  const Times mpm = time_of(named("mpm")), impm = time_of(named("impm"));
  lab.summary.at_most("mpm " + name, "ns per particle and step: impm against mpm",
                      impm.best() / particles * 1e9, mpm.best() / particles * 1e9,
                      speedup(mpm, impm), impm_goal);
  const auto at_most = [&](const std::string& method, const Times& its,
                           const std::string& reference, const Times& other, double most) {
    lab.summary.at_most(
        "mpm " + name, "ns per particle and step: " + method + " against " + reference,
        its.best() / particles * 1e9, other.best() / particles * 1e9, speedup(other, its), most);
  };
  at_most("mpm", mpm, "a step by hand", times.back(), hand_goal);
  for (const Aim& aim : aims)
    if (D == 3 || aim.in_2d)
      at_most(aim.method, time_of(named(aim.method)), aim.reference, time_of(named(aim.reference)),
              aim.most);
}

}  // namespace

Section run_mpm(Lab& lab) {
  Table table("mpm",
              {"dimension", "particles", "method", "ns per particle and step",
               "million particles per second", "2 threads / 1", "reconstruction %", "time / mpm"});
  time_methods<2>(lab, lab.choose(200, 100, 8), table);
  time_methods<3>(lab, lab.choose(40, 24, 4), table);
  return {"Material point method",
          "A full block, 2 particles per cell and axis; "
          "\"Reconstruction\": the part of the time beyond the method with the same particles and "
          "functions and the mass-weighted map.",
          {table},
          {}};
}

}  // namespace recon_bench

#endif
