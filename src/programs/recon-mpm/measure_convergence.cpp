// Errors against exact solutions on one grid, at T/4, 3T/8 and T; and how runs end.
#include <algorithm>
#include <cmath>

#include "measure.hpp"
#include "recon/studies/convergence.hpp"

namespace recon::program {
namespace {

constexpr std::pair<double, const char*> times[] = {{0.25, " T/4"}, {0.375, " 3T/8"}, {1, ""}};

// "displacement T/4" and so on, in the norm of the study.
Measured convergence(const Request& request) {
  Measured measured;
  mpm::ConvergenceStudy study{{request.method}, {request.grid}, {}};
  for (const auto& [part, name] : times) study.times.push_back(part);
  const auto rows =
      mpm::converge([&](std::span<const std::string>) { return request.load(); }, study);
  double end = 0;
  for (const auto& row : rows) end = std::max(end, row.time);
  for (const auto& row : rows) {
    if (row.norm != request.study.norm) continue;
    for (const auto& [part, name] : times)
      if (std::abs(row.time - part * end) < 1e-9 * end) measured.add(row.field + name, row.error);
    if (row.time == end) measured.note = row.failure;
  }
  return measured;
}

Measured breaks(const Request& request) {
  Measured measured;
  std::visit(
      [&](const auto& file) {
        mpm::Simulation simulation(file.problem);
        measured.note = run_to_end(simulation, file);
        add_fate(measured, simulation, file);
      },
      request.load());
  return measured;
}

// Places at T/4 and T, and velocities less those of the exact motion at their own times, with steps
// that are shorter by some factor.
template <int D>
std::vector<std::vector<mpm::Vector<D>>> states(mpm::ProblemFile<D> file, double shorter) {
  shorten_step(file.problem, shorter);
  mpm::Simulation<D> simulation(file.problem);
  std::vector<std::vector<mpm::Vector<D>>> all;
  for (const double part : {0.25, 1.0}) {
    mpm::run_until(simulation, part * file.problem.time.end, {}, file.limits);
    const mpm::Particles<D>& particles = simulation.particles();
    all.push_back(particles.x);
    all.push_back(particles.v);
    const double t = simulation.time() - simulation.velocity_lag();
    for (std::size_t p = 0; p < particles.size(); ++p)
      all.back()[p] -= file.exact->at(particles.X[p], t).velocity;
  }
  return all;
}

// The error of the time integration alone, on 32 cells: the distance to a run whose steps are 32
// times as short, rms. The "grid" is the factor by which steps are shortened.
Measured time_step(const Request& request) {
  Measured measured;
  Request same = request;
  same.grid = 32;
  std::visit(
      [&](const auto& file) {
        const auto coarse = states(file, request.grid), fine = states(file, 32);
        const char* names[] = {"displacement T/4", "velocity T/4", "displacement", "velocity"};
        for (std::size_t k = 0; k < coarse.size(); ++k) {
          double sum = 0;
          for (std::size_t p = 0; p < coarse[k].size(); ++p)
            sum += (coarse[k][p] - fine[k][p]).squaredNorm();
          measured.add(names[k], std::sqrt(sum / static_cast<double>(coarse[k].size())));
        }
      },
      same.load());
  return measured;
}

}  // namespace

std::span<const NamedMeasure> convergence_measures() {
  static constexpr NamedMeasure all[] = {
      {"convergence", convergence}, {"breaks", breaks}, {"time step", time_step}};
  return all;
}

}  // namespace recon::program
