#include "recon/runs/forecast.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/brief.hpp"
#include "mpm/policies.hpp"
#include "recon/local_solve/report.hpp"

namespace recon::mpm {
namespace {

std::string number(double value) {
  return recon::detail::brief(value, 3);
}

// Bytes of a node, and of what fits at nodes need.
template <int D>
double bytes_of_node(const Method& method) {
  constexpr double vectors = 5, value = sizeof(double);
  double bytes = value * (1 + vectors * D) + 1;
  if (is_fit(method.velocity) || is_cell(method.quadrature)) {
    // Moments and their right sides, results, reports.
    const int degree = method.degree;
    const double terms = D == 1   ? degree + 1.0
                         : D == 2 ? (degree + 1) * (degree + 2) / 2.0
                                  : (degree + 1) * (degree + 2) * (degree + 3) / 6.0;
    const double moments = D == 1   ? 2 * degree + 1.0
                           : D == 2 ? (2 * degree + 1) * (2 * degree + 2) / 2.0
                                    : (2 * degree + 1) * (2 * degree + 2) * (2 * degree + 3) / 6.0;
    const double columns = D + (is_cell(method.quadrature) ? 1 + D * (D + 1) / 2 : 0);
    bytes += value * (moments + columns * (terms + 1)) + sizeof(FitReport) + sizeof(std::uint32_t);
  }
  if (method.quadrature == Quadrature::adjoint_cells)  // moments, and rows of least squares
    bytes += value * (D + 1) * (D + 2);
  if (method.mass == MassMatrix::consistent)  // the matrix, and its factor with some fill-in
    bytes += std::pow(method.basis == Basis::linear ? 3 : 7, D) * 3 * (value + 4);
  return bytes;
}

// Of a particle or image that a fit sees: copies in the order of cells.
template <int D>
double bytes_in_fit(const Method& method) {
  if (!is_fit(method.velocity)) return 0;
  const double points = method.velocity == VelocityMap::cpls ? 1 + (1 << D) : 1;
  return points * D * sizeof(double) * 4;
}

// Of a particle, while a step is made: its place in the order of slabs, and copies.
template <int D>
double bytes_in_step(const Method& method, const Kept& kept) {
  constexpr double value = sizeof(double);
  double bytes = 2 * sizeof(std::uint32_t);
  bytes += bytes_in_fit<D>(method);
  // Lists of neighbours, within two cells of each node: indices and weights of 4^D cells' worth of
  // particles for each node, so of 4^D nodes for each particle.
  if (method.velocity == VelocityMap::imls) bytes += 1.3 * std::pow(4, D) * (value + 4);
  if (method.update == Update::runge_kutta)
    bytes += bytes_of_particle<D>(kept) + 2 * value * (2 * D + 2 * D * D);
  if (method.update == Update::xpic || method.update == Update::fmpm) bytes += value * D;
  if (method.mass == MassMatrix::consistent)
    bytes += std::pow(method.basis == Basis::linear ? 4 : 9, D) * 16;
  return bytes;
}

// Of all images of particles, while a step is made: those that give to the nodes, which are copies
// of the particles, and those that fits see.
template <int D>
double bytes_of_images(const Problem<D>& problem, const Particles<D>& particles) {
  const auto count = [&](bool of_fits) {
    const Images<D> images = images_of(problem, of_fits);
    return images.empty() ? 0.0 : static_cast<double>(images.of(particles.x).size());
  };
  const double forces = problem.body_force ? D * sizeof(double) : 0;
  const double slab = 2 * sizeof(std::uint32_t);
  double bytes = 0;
  if (problem.has_images())
    bytes +=
        count(false) * (sizeof(Image<D>) + bytes_of_particle<D>(problem.kept()) + forces + slab);
  if (const double fit = bytes_in_fit<D>(problem.method); fit > 0)
    bytes += count(true) * (sizeof(Image<D>) + fit);
  return bytes;
}

// Has a cell of the grid, where particles may lie, no particle? Then there is a free surface.
template <int D>
bool has_empty_cells(const Problem<D>& problem, const Particles<D>& particles) {
  const Grid<D>& grid = problem.grid;
  std::array<int, D> first, last;
  std::size_t cells = 1;
  for (int d = 0; d < D; ++d) {
    const auto [from, to] = problem.room(d);
    const double hair = 1e-6 * grid.h();
    first[d] = grid.cell(from + hair, d);
    last[d] = grid.cell(to - hair, d);
    cells *= static_cast<std::size_t>(last[d] - first[d] + 1);
  }
  if (cells > particles.size()) return true;
  std::vector<bool> filled(cells);
  for (const Vector<D>& x : particles.x) {
    std::size_t cell = 0;
    for (int d = D - 1; d >= 0; --d)
      cell = cell * static_cast<std::size_t>(last[d] - first[d] + 1) +
             static_cast<std::size_t>(std::clamp(grid.cell(x[d], d), first[d], last[d]) - first[d]);
    filled[cell] = true;
  }
  return std::find(filled.begin(), filled.end(), false) != filled.end();
}

}  // namespace

// The least of what is measured in docs/mpm.md, for groups of methods.
double stable_courant(const Method& method, int dimension) {
  const bool cells = is_cell(method.quadrature);
  if (method.basis == Basis::q8) return 0;
  if (method.basis == Basis::q9) return 0.55;
  if (method.mass == MassMatrix::consistent)
    return dimension == 1 ? 0.49 : dimension == 2 ? 0.41 : 0.35;
  if (method.update == Update::fmpm) return 0.75 / std::sqrt(method.order);
  if (cells && method.degree == 3 && dimension == 3) return 0.2;
  if (cells || (method.domain == Domain::point && method.basis != Basis::linear)) return 0.85;
  return 0.7;
}

std::string caveat(const Method& method) {
  if (is_element(method.basis))
    return "functions of " + std::string(name_of(method.basis)) +
           " are negative in parts: a body breaks where the mass of a node passes through zero";
  if (method.quadrature == Quadrature::nodal_cells && method.degree == 2)
    return "quadrature over nodal cells with fits of degree 2 gains energy on fine grids";
  if (is_cell(method.quadrature) && method.degree == 3)
    return "cubic fits at free surfaces break the body";
  if (is_cell(method.quadrature))
    return "quadrature over cells gains energy at free surfaces, the more the shorter the step";
  return "";
}

double available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string name;
  for (double kilobytes = 0; file >> name >> kilobytes; std::getline(file, name))
    if (name == "MemAvailable:") return kilobytes * 1024;
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

template <int D>
double bytes_of_particle(const Kept& kept) {
  double bytes = 0;
  Particles<D>().arrays(kept, [&](const ParticleArray& array, const auto& values) {
    bytes += static_cast<double>(array.per_particle *
                                 sizeof(typename std::decay_t<decltype(values)>::value_type));
  });
  return bytes;
}

namespace {

// Points that see through linear functions, and powers of the mass matrix: beside a mirror between
// nodes what they take is not the transpose of what they give (docs/mpm.md).
bool gains_between_nodes(const Method& method) {
  if (method.quadrature != Quadrature::particles) return false;
  return method.update == Update::fmpm ||
         (method.domain == Domain::point &&
          (method.basis == Basis::linear || method.basis == Basis::cell_linear));
}

template <int D>
Forecast forecast_from(const Problem<D>& problem, const Particles<D>& particles, double time) {
  Forecast found;
  const Kept kept = problem.kept();
  found.particles = particles.size();
  found.nodes = problem.grid.size();
  found.available_memory = available_memory();
  const double forces = problem.body_force ? D * sizeof(double) : 0;
  found.memory =
      static_cast<double>(found.particles) *
          (2 * bytes_of_particle<D>(kept) + bytes_in_step<D>(problem.method, kept) + forces) +
      static_cast<double>(found.nodes) * bytes_of_node<D>(problem.method) +
      bytes_of_images(problem, particles);
  found.step = choose_step(problem, particles);
  if (std::isfinite(problem.time.end))
    found.steps = std::ceil((problem.time.end - time) / found.step.dt * (1 - 1e-12));
  const double courant = courant_of(problem, particles, found.step.dt);
  const double stable = stable_courant(problem.method, D);
  if (courant > stable)
    found.warnings.push_back(
        "the first step, " + number(found.step.dt) + ", is " + number(courant) +
        " h / (c_p + |v|); the method " + problem.method.name + " is known to be stable up to " +
        number(stable) + " in " + std::to_string(D) + "-D: it may break, or gain energy");
  if (const double slowed = problem.damping.mass * found.step.dt; slowed > 1)
    found.warnings.push_back("damping.mass times the first step, " + number(slowed) +
                             ", is above 1: damping reverses velocities");
  if (gains_between_nodes(problem.method))
    for (const Boundary<D>& each : problem.boundaries)
      if (each.images && !each.is_on_nodes(problem.grid)) {
        found.warnings.push_back("the wall at " + std::string(1, "xyz"[each.axis]) + " = " +
                                 number(each.at) + " lies between nodes: with the method " +
                                 problem.method.name +
                                 " energy may grow there; let it lie on nodes, or take a method "
                                 "whose domains follow their material, as cpdi1");
        break;
      }
  const std::string broken = caveat(problem.method);
  if (!broken.empty() && (is_element(problem.method.basis) || has_empty_cells(problem, particles)))
    found.warnings.push_back(broken);
  return found;
}

}  // namespace

template <int D>
Forecast forecast(const Problem<D>& problem) {
  return forecast_from(problem, problem.particles, 0);
}
template <int D>
Forecast forecast(const Problem<D>& problem, const State<D>& state) {
  return forecast_from(problem, state.particles, state.time);
}

void Limits::validate() const {
  recon::detail::require(memory >= 0, "limit of memory", memory,
                         "must be bytes, or 0 for what the machine has");
  recon::detail::require(steps > 0, "limit of steps", steps, "must be positive");
}

void require_possible(const Forecast& forecast, const Limits& limits, double time) {
  const double memory = limits.memory > 0 ? limits.memory : forecast.available_memory;
  const std::string size = std::to_string(forecast.particles) + " particles and " +
                           std::to_string(forecast.nodes) + " nodes";
  if (forecast.memory > memory)
    recon::detail::throw_invalid("memory", number(forecast.memory / 1e9) + " GB",
                                 "is more than " + number(memory / 1e9) + " GB, which " +
                                     (limits.memory > 0 ? "is the limit" : "the machine has left") +
                                     ": " + size);
  if (forecast.steps > limits.steps)
    recon::detail::throw_invalid(
        "steps", number(forecast.steps),
        "of " + number(forecast.step.dt) + " are more than the limit of " + number(limits.steps));
  if (!(time + forecast.step.dt > time))
    recon::detail::throw_invalid("time step", number(forecast.step.dt),
                                 "is too short to move the clock at " + number(time));
}

#define RECON_INSTANTIATE(D)                         \
  template double bytes_of_particle<D>(const Kept&); \
  template Forecast forecast(const Problem<D>&);     \
  template Forecast forecast(const Problem<D>&, const State<D>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
