#include "recon/studies/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "recon/runs/simulation.hpp"

namespace recon::mpm {
namespace {

constexpr int bar_cells = 32;  // per unit length: h = 1 / bar_cells, c_p = 1

// A bar that fills the grid, held at its ends and between rollers; `free`: the same with a cell
// around it, and nothing that holds it.
template <int D>
Problem<D> bar(const Method& method, int per_cell, int length = bar_cells, bool free = false) {
  constexpr int across = 4;
  const int around = free ? 2 : 0;  // an even number of cells, for elements of 2 x 2
  Problem<D> problem;
  Vector<D> lower = Vector<D>::Constant(-static_cast<double>(around) / bar_cells), upper;
  upper.setConstant(static_cast<double>(across + around) / bar_cells);
  upper[0] = static_cast<double>(length + around) / bar_cells;
  problem.grid = Grid<D>(lower, upper, 1.0 / bar_cells);
  problem.materials = {LinearElastic{Lame{0, 0.5}}};
  problem.densities = {1};
  problem.method = method;
  problem.threads = 1;
  const double half = problem.grid.h() / (2 * per_cell);
  const int along = length * per_cell;
  int count = along;
  for (int d = 1; d < D; ++d) count *= across * per_cell;
  for (int p = 0; p < count; ++p) {
    Vector<D> X;
    X[0] = (2 * (p % along) + 1) * half;
    for (int d = 1, rest = p / along; d < D; ++d, rest /= across * per_cell)
      X[d] = (2 * (rest % (across * per_cell)) + 1) * half;
    problem.particles.add(X, Matrix<D>::Identity() * half, 1, 0);
  }
  for (int d = 0; d < D && !free; ++d)
    for (const double at : {0.0, upper[d]}) {
      Boundary<D> held{d, at, {}};
      held.velocity[static_cast<std::size_t>(d)] = 0.0;
      problem.boundaries.push_back(held);
    }
  return problem;
}

template <int D>
double energy(const Particles<D>& particles) {
  double sum = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    sum += particles.mass[p] * particles.v[p].squaredNorm();
  return sum;
}

// Does small noise stay small?
template <int D>
bool stable(const Method& method, int per_cell, double courant, bool free = false) {
  constexpr int steps = D == 1 ? 2000 : 1000, length = D == 1 ? bar_cells : D == 2 ? 16 : 6;
  constexpr double growth = 100;
  Problem<D> problem = bar<D>(method, per_cell, length, free);
  std::mt19937 random(1);
  for (auto& v : problem.particles.v)
    for (double& each : v)
      each =
          1e-9 * (static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5);
  const double start = energy(problem.particles);
  Simulation<D> simulation(std::move(problem));
  try {
    for (int s = 0; s < steps; ++s) {
      simulation.step(courant / bar_cells);
      if (!(energy(simulation.particles()) <= growth * start)) return false;
    }
  } catch (const Failure&) {
    return false;
  }
  return true;
}

double largest_stable(const Method& method, int dimension, int per_cell, double tolerance) {
  double low = 0, high = 4;
  while (high - low > tolerance) {
    const double middle = (low + high) / 2;
    (is_stable(method, dimension, per_cell, middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

bool is_stable(const Method& method, int dimension, int per_cell, double courant, bool free) {
  recon::detail::require(dimension >= 1 && dimension <= 3, "dimension", dimension,
                         "must be 1, 2 or 3");
  if (dimension == 1) return stable<1>(method, per_cell, courant, free);
  if (dimension == 2) return stable<2>(method, per_cell, courant, free);
  return stable<3>(method, per_cell, courant, free);
}

StabilityLimit stability_limit(const Method& method, int per_cell, int dimension) {
  StabilityLimit limit{method.name, per_cell};
  if (dimension > 1 || method.basis == Basis::q8) {
    limit.measured = largest_stable(method, std::max(dimension, 2), per_cell, 0.02);
    limit.W = limit.Q = limit.analytic = std::numeric_limits<double>::quiet_NaN();
    return limit;
  }
  Problem<1> problem = bar<1>(method, per_cell);
  // Alternating values at the nodes, seen by the particles; alternating stresses of the cells.
  for (std::size_t p = 0; p < problem.particles.size(); ++p) {
    const double x = problem.particles.x[p][0] * bar_cells;
    const int cell = static_cast<int>(x);
    const double sign = cell % 2 == 0 ? 1 : -1;
    problem.particles.v[p][0] = sign * (1 - 2 * (x - cell));
    problem.particles.stress[p](0, 0) = sign;
  }
  Simulation<1> simulation(problem);
  simulation.map();
  limit.W = simulation.nodes().mapped[bar_cells / 2][0];
  if (method.quadrature == Quadrature::cells) limit.Q = simulation.cells().values(bar_cells / 2, 1);
  limit.analytic = 1 / std::sqrt(limit.Q * (2 - limit.W));

  limit.measured = largest_stable(method, 1, per_cell, 0.002);
  return limit;
}

std::vector<DispersionPoint> dispersion(const Method& method, int per_cell, double courant) {
  std::vector<DispersionPoint> curve;
  const double dt = courant / bar_cells, none = std::numeric_limits<double>::quiet_NaN();
  for (int mode = 1; mode < bar_cells; mode += 2) {
    const double k = mode * std::numbers::pi, kh = k / bar_cells;
    Problem<1> problem = bar<1>(method, per_cell);
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      problem.particles.v[p][0] = 1e-6 * std::sin(k * problem.particles.x[p][0]);
    Simulation<1> simulation(std::move(problem));
    // Velocities may have a part that no node sees, which stays; displacements have none.
    const auto amplitude = [&] {
      const Particles<1>& at = simulation.particles();
      double sum = 0;
      for (std::size_t p = 0; p < at.size(); ++p)
        sum += (at.x[p][0] - at.X[p][0]) * std::sin(k * at.X[p][0]);
      return sum;
    };
    // Extremes, which are those of parabolas. What other parts of the start have moved particles by
    // before they died out stays, so that only differences of extremes tell of the wave.
    struct Extreme {
      double time, value;
    };
    std::vector<Extreme> extremes;
    double before = 0, now = 0;
    while (extremes.size() < 4 && simulation.steps() < 200 * bar_cells) {
      const double time = simulation.time();
      simulation.step(dt);
      const double next = amplitude();
      if ((now - before) * (next - now) < 0) {
        const double bend = before - 2 * now + next, slope = (next - before) / 2;
        extremes.push_back({time - dt * slope / bend, now - slope * slope / (2 * bend)});
      }
      before = now;
      now = next;
    }
    DispersionPoint point{kh, none, 2 * std::asin(courant * std::sin(kh / 2)) / (courant * kh),
                          none};
    if (extremes.size() == 4) {  // from the second on, when all else is gone
      point.measured = 2 * std::numbers::pi / (extremes[3].time - extremes[1].time) / k;
      const double left =
          (extremes[3].value - extremes[2].value) / (extremes[2].value - extremes[1].value);
      point.damping = 1 - left * left;
    }
    curve.push_back(point);
  }
  return curve;
}

}  // namespace recon::mpm
