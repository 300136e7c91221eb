#include "recon/mpm/stability.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {
namespace {

constexpr int cells = 32;

// A bar that fills the grid, held at both ends; c_p = 1, h = 1 / cells. In 2-D a strip between
// rollers.
template <int D>
Problem<D> bar(const Method& method, int per_cell) {
  constexpr int across = 4;
  Problem<D> problem;
  Vector<D> upper = Vector<D>::Constant(static_cast<double>(across) / cells);
  upper[0] = 1;
  problem.grid = Grid<D>(Vector<D>::Zero(), upper, 1.0 / cells);
  problem.materials = {LinearElastic{Lame{0, 0.5}}};
  problem.densities = {1};
  problem.method = method;
  problem.threads = 1;
  const double half = problem.grid.h() / (2 * per_cell);
  const int along = cells * per_cell, count = D == 1 ? along : along * across * per_cell;
  for (int p = 0; p < count; ++p) {
    Vector<D> X = Vector<D>::Constant((2 * (p / along) + 1) * half);
    X[0] = (2 * (p % along) + 1) * half;
    problem.particles.add(X, Matrix<D>::Identity() * half, 1, 0);
  }
  for (int d = 0; d < D; ++d)
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
bool stable(const Method& method, int per_cell, double courant) {
  constexpr int steps = 2000;
  constexpr double growth = 100;
  Problem<D> problem = bar<D>(method, per_cell);
  std::mt19937 random(1);
  for (auto& v : problem.particles.v)
    for (double& each : v)
      each =
          1e-9 * (static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5);
  const double start = energy(problem.particles);
  Simulation<D> simulation(std::move(problem));
  try {
    for (int s = 0; s < steps; ++s) {
      simulation.map();
      simulation.advance(courant / cells);
      if (energy(simulation.particles()) > growth * start) return false;
    }
  } catch (const Failure&) {
    return false;
  }
  return true;
}

template <int D>
double largest_stable(const Method& method, int per_cell) {
  double low = 0, high = 4;
  while (high - low > 0.002) {
    const double middle = (low + high) / 2;
    (stable<D>(method, per_cell, middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

StabilityLimit stability_limit(const Method& method, int per_cell) {
  StabilityLimit limit{method.name, per_cell};
  if (method.basis == Basis::q8) {
    limit.measured = largest_stable<2>(method, per_cell);
    limit.W = limit.Q = limit.analytic = std::numeric_limits<double>::quiet_NaN();
    return limit;
  }
  Problem<1> problem = bar<1>(method, per_cell);
  // Alternating values at the nodes, seen by the particles; alternating stresses of the cells.
  for (std::size_t p = 0; p < problem.particles.size(); ++p) {
    const double x = problem.particles.x[p][0] * cells;
    const int cell = static_cast<int>(x);
    const double sign = cell % 2 == 0 ? 1 : -1;
    problem.particles.v[p][0] = sign * (1 - 2 * (x - cell));
    problem.particles.stress[p](0, 0) = sign;
  }
  Simulation<1> simulation(problem);
  simulation.map();
  limit.W = simulation.nodes().mapped[cells / 2][0];
  if (method.quadrature == Quadrature::cells) limit.Q = simulation.cells().values(cells / 2, 1);
  limit.analytic = 1 / std::sqrt(limit.Q * (2 - limit.W));

  limit.measured = largest_stable<1>(method, per_cell);
  return limit;
}

std::vector<DispersionPoint> dispersion(const Method& method, int per_cell, double courant) {
  std::vector<DispersionPoint> curve;
  const double dt = courant / cells;
  for (int mode = 1; mode < cells; mode += 2) {
    const double k = mode * std::numbers::pi;
    Problem<1> problem = bar<1>(method, per_cell);
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      problem.particles.v[p][0] = 1e-6 * std::sin(k * problem.particles.x[p][0]);
    Simulation<1> simulation(std::move(problem));
    // The displacement of the mode returns to zero after half a period.
    const auto amplitude = [&] {
      const Particles<1>& at = simulation.particles();
      double sum = 0;
      for (std::size_t p = 0; p < at.size(); ++p)
        sum += (at.x[p][0] - at.X[p][0]) * std::sin(k * at.X[p][0]);
      return sum;
    };
    double before = 0;
    for (double now = 0;; before = now) {
      simulation.map();
      simulation.advance(dt);
      now = amplitude();
      if (now > 0 && simulation.steps() < 100 * cells) continue;
      const double half_period = simulation.time() - dt * now / (now - before);
      const double kh = k / cells;
      curve.push_back({kh, std::numbers::pi / half_period / k,
                       2 * std::asin(courant * std::sin(kh / 2)) / (courant * kh)});
      break;
    }
  }
  return curve;
}

}  // namespace recon::mpm
