#include "recon/mpm/stability.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {
namespace {

constexpr int cells = 32;

// A bar that fills the grid, held at both ends; c_p = 1, h = 1 / cells.
Problem<1> bar(const Method& method, int per_cell) {
  Problem<1> problem;
  problem.grid = Grid<1>(Vector<1>(0), Vector<1>(1), 1.0 / cells);
  problem.materials = {LinearElastic{Lame{0, 0.5}}};
  problem.densities = {1};
  problem.method = method;
  problem.threads = 1;
  const double half = problem.grid.h() / (2 * per_cell);
  for (int p = 0; p < cells * per_cell; ++p)
    problem.particles.add(Vector<1>((2 * p + 1) * half), Matrix<1>(half), 1, 0);
  for (const double at : {0.0, 1.0}) problem.boundaries.push_back({0, at, {0.0}});
  return problem;
}

double energy(const Particles<1>& particles) {
  double sum = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    sum += particles.mass[p] * particles.v[p].squaredNorm();
  return sum;
}

// Does small noise stay small?
bool stable(const Method& method, int per_cell, double courant) {
  constexpr int steps = 2000;
  constexpr double growth = 100;
  Problem<1> problem = bar(method, per_cell);
  std::mt19937 random(1);
  for (auto& v : problem.particles.v)
    v[0] = 1e-9 * (static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5);
  const double start = energy(problem.particles);
  Simulation<1> simulation(std::move(problem));
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

}  // namespace

StabilityLimit stability_limit(const Method& method, int per_cell) {
  StabilityLimit limit{method.name, per_cell};
  Problem<1> problem = bar(method, per_cell);
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

  double low = 0.2, high = 2;
  while (high - low > 0.002) {
    const double middle = (low + high) / 2;
    (stable(method, per_cell, middle) ? low : high) = middle;
  }
  limit.measured = low;
  return limit;
}

std::vector<DispersionPoint> dispersion(const Method& method, int per_cell, double courant) {
  std::vector<DispersionPoint> curve;
  const double dt = courant / cells;
  for (int mode = 1; mode < cells; mode += 2) {
    const double k = mode * std::numbers::pi;
    Problem<1> problem = bar(method, per_cell);
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
