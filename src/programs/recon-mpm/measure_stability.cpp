// Stable steps, dispersion and damping in one dimension; what a step costs.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <vector>

#include "measure.hpp"
#include "programs/common/text.hpp"
#include "recon/runs/compose.hpp"
#include "recon/runs/simulation.hpp"
#include "recon/studies/stability.hpp"
#include "recon/studies/step_waves.hpp"

namespace recon::program {
namespace {

constexpr double pi = std::numbers::pi;

// The linearised scheme of Gong 2015, eqs. 7.13, 7.14, on a grid that stays, with h = 1 and c = 1:
//     v_I += C (mean of the strains of cell I + 1 - that of cell I)
//     e_p += C (v_I - v_I-1) for every particle p of cell I
// in a periodic bar. Velocities stay at the nodes: nothing is mapped.
class GridOnly {
 public:
  GridOnly(int cells, int per_cell, double courant)
      : cells_(cells),
        per_cell_(per_cell),
        courant_(courant),
        v_(static_cast<std::size_t>(cells)),
        e_(static_cast<std::size_t>(cells * per_cell)) {}

  std::vector<double>& v() { return v_; }
  void step() {
    const auto mean = [&](int cell) {
      double sum = 0;
      for (int p = 0; p < per_cell_; ++p)
        sum += e_[static_cast<std::size_t>((cell % cells_) * per_cell_ + p)];
      return sum / per_cell_;
    };
    for (int i = 0; i < cells_; ++i)
      v_[static_cast<std::size_t>(i)] += courant_ * (mean(i + 1) - mean(i));
    for (int i = 0; i < cells_; ++i)
      for (int p = 0; p < per_cell_; ++p)
        e_[static_cast<std::size_t>(i * per_cell_ + p)] +=
            courant_ * (v_[static_cast<std::size_t>(i)] -
                        v_[static_cast<std::size_t>((i + cells_ - 1) % cells_)]);
  }

 private:
  int cells_, per_cell_;
  double courant_;
  std::vector<double> v_, e_;
};

bool grid_only_is_stable(int cells, int per_cell, double courant) {
  GridOnly bar(cells, per_cell, courant);
  for (int i = 0; i < cells; ++i)
    bar.v()[static_cast<std::size_t>(i)] = std::sin(1.7 * i * i);  // all waves
  for (int s = 0; s < 2000; ++s) {
    bar.step();
    for (const double v : bar.v())
      if (!(std::abs(v) < 1000)) return false;
  }
  return true;
}

// omega dt of the wave exp(i theta x / h): cos(omega dt) = (q+ + q-) / (2 q) for each of its values.
double grid_only_frequency(int cells, int per_cell, double courant, int mode) {
  GridOnly bar(cells, per_cell, courant);
  const double theta = 2 * pi * mode / cells;
  for (int i = 0; i < cells; ++i) bar.v()[static_cast<std::size_t>(i)] = std::cos(theta * i);
  const double before = bar.v()[0];
  bar.step();
  const double now = bar.v()[0];
  bar.step();
  return std::acos(std::clamp((bar.v()[0] + before) / (2 * now), -1.0, 1.0));
}

int particles_of(const Variant& variant) {
  return static_cast<int>(to_number(variant.name.substr(0, variant.name.find(' '))).value_or(1));
}

// The largest stable steps, c_p dt / h.
Measured stability(const Request& request) {
  const int per_cell = particles_of(request.variant), cells = request.grid;
  Measured measured;
  if (request.method == "grid only") {
    double low = 0, high = 4;
    while (high - low > 0.001) {
      const double middle = (low + high) / 2;
      (grid_only_is_stable(cells, per_cell, middle) ? low : high) = middle;
    }
    measured.add("largest stable step", low);
    return measured;
  }
  const mpm::Method method = mpm::composed(request.method);
  const mpm::StabilityLimit limit = mpm::stability_limit(method, per_cell);
  measured.add("largest stable step", limit.measured);
  measured.add("1 / sqrt(Q (2 - W))", limit.analytic);
  return measured;
}

// Standing waves of k h = pi n / 32 in steps of 0.4 h / c_p; the "grid" is n, which is odd.
// Frequencies are parts of k c_p, damping is the part of the amplitude that a period takes away.
Measured dispersion(const Request& request) {
  constexpr int cells = 32;
  constexpr double courant = 0.4;
  const int per_cell = particles_of(request.variant), mode = request.grid;
  const double theta = pi * mode / cells, half = theta / 2;
  const double linearised = 2 * std::asin(courant * std::sin(half)) / (courant * theta);
  Measured measured;
  if (request.method == "grid only") {
    const double printed =
        2 *
        std::asin(courant / per_cell * std::pow(std::sin(half), 2) / std::sin(half / per_cell)) /
        (courant * theta);
    const double frequency = grid_only_frequency(2 * cells, per_cell, courant, mode);
    measured.add("frequency, measured", frequency / (courant * theta));
    measured.add("frequency by (7.29)", printed);
    measured.add("frequency of a grid that stays", linearised);
    return measured;
  }
  const mpm::Method method = mpm::composed(request.method);
  for (const mpm::DispersionPoint& point : mpm::dispersion(method, per_cell, courant)) {
    if (std::abs(point.kh - theta) > 1e-9) continue;
    measured.add("frequency, measured", point.measured);
    measured.add("damping, measured", point.damping);
  }
  const mpm::StepWave wave = mpm::step_wave(method, per_cell, courant, theta);
  measured.add("frequency by eigenvalues", wave.frequency);
  measured.add("damping by eigenvalues", wave.damping);
  measured.add("frequency of a grid that stays", linearised);
  return measured;
}

int dimension_of(const Request& request) {
  return request.variant.name.starts_with("2-D") ? 2 : 1;
}

// What crossing a cell makes of small disturbances, 2 particles per cell and axis, in steps of
// 0.4 h / c_p. The "grid" is the number of steps in which the body crosses a cell.
Measured motion(const Request& request) {
  const mpm::Method method = mpm::composed(request.method);
  const int dimension = dimension_of(request);
  Measured measured;
  measured.add("growth without end", mpm::spectral_radius(method, dimension, 2, 0.4, request.grid));
  measured.add(
      "growth of a free body",
      mpm::spectral_radius(method, dimension, 2, 0.4, request.grid, true, dimension == 1 ? 10 : 4));
  return measured;
}

// The largest stable steps of every method; the "grid" is the number of particles per cell and axis.
Measured steps(const Request& request) {
  const mpm::Method method = mpm::composed(request.method);
  const int dimension = dimension_of(request);
  Measured measured;
  measured.add("by eigenvalues", mpm::largest_step_by_eigenvalues(method, dimension, request.grid));
  if (request.grid == 2)  // noise takes its time
    measured.add("measured", mpm::stability_limit(method, request.grid, dimension).measured);
  measured.add("of a free body, by eigenvalues",
               mpm::largest_step_by_eigenvalues(method, dimension, request.grid, true));
  measured.add("default", method.default_courant(dimension));
  return measured;
}

// Of a step and a cell that is filled at first, on one thread: the quickest of 200. The processor's
// time, which does not count what other programs take.
Measured processor_time(const Request& request) {
  const auto file = std::get<mpm::ProblemFile<2>>(request.load({"threads=1"}));
  mpm::Simulation<2> simulation(file.problem);
  double area = 0;
  for (std::size_t p = 0; p < simulation.particles().size(); ++p)
    area += simulation.particles().volume0[p];
  std::clock_t best = std::numeric_limits<std::clock_t>::max();
  for (int s = 0; s < 200; ++s) {
    const double dt = simulation.choose_step().dt;
    const std::clock_t start = std::clock();
    simulation.step(dt);
    best = std::min(best, std::clock() - start);
  }
  Measured measured;
  const double h = file.problem.grid.h(), cells = area / (h * h);
  measured.add("time of a step", static_cast<double>(best) / CLOCKS_PER_SEC * 1e9 / cells);
  return measured;
}

}  // namespace

std::span<const NamedMeasure> stability_measures() {
  static constexpr NamedMeasure all[] = {{"stability", stability},
                                         {"dispersion", dispersion},
                                         {"motion", motion},
                                         {"largest steps", steps},
                                         {"processor time", processor_time}};
  return all;
}

}  // namespace recon::program
