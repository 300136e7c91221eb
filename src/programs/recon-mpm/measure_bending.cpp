// Bending (Andersen, Andersen 2007): a vibrating bar, a cantilever, a box that falls on a beam, and a
// block that flies through nodes of negative mass.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "measure.hpp"
#include "programs/common/text.hpp"

namespace recon::program {
namespace {

using BendingProblem = mpm::Problem<2>;
using BendingParticles = mpm::Particles<2>;

struct BendingRun {
  std::vector<mpm::Ledger> ledger;  // of every step; times alone without an account
  std::vector<double> watched;      // the same steps
  BendingParticles particles;       // at the end
  double end = 0;
  std::string failure;

  double first_energy() const { return ledger.front().total(); }
  double reached() const { return failure.empty() ? 1 : ledger.back().time / end; }
  // The largest |value| over time, over the first energy.
  template <class Value>
  double largest(Value value) const {
    double most = 0;
    for (const auto& row : ledger) most = std::max(most, std::abs(value(row)));
    return most / first_energy();
  }
};

struct Watch {
  std::function<double(const mpm::Simulation<2>&)> value{};  // asked after every map()
  std::function<void(BendingProblem&)> change{};             // of the problem, before
  bool accounts = false;
};

BendingRun simulate(const Request& request, const std::vector<std::string>& settings,
                    const Watch& watch) {
  auto file = std::get<mpm::ProblemFile<2>>(request.load(settings));
  if (watch.change) watch.change(file.problem);
  mpm::Simulation<2> simulation(file.problem);
  BendingRun run;
  run.end = file.problem.time.end;
  std::optional<mpm::Ledger> start;
  run.failure = run_to_end(simulation, file, [&] {
    run.ledger.emplace_back();
    run.ledger.back().time = simulation.time();
    if (watch.accounts) run.ledger.back() = mpm::account(simulation, start);
    if (!start) start = run.ledger.front();
    if (watch.value) run.watched.push_back(watch.value(simulation));
  });
  run.particles = simulation.particles();
  return run;
}

// Why the same run stops with half the step; empty: it does not.
std::string with_half_step(const Request& request, const std::vector<std::string>& settings,
                           const Watch& watch) {
  auto file = std::get<mpm::ProblemFile<2>>(request.load(settings));
  if (watch.change) watch.change(file.problem);
  return run_with_half_step(std::move(file));
}

Curve over_time(const std::string& name, const BendingRun& run,
                const std::function<double(std::size_t k)>& value) {
  Curve curve{name, {}, {}, CurveStyle::line};
  const std::size_t every = run.ledger.size() / 600 + 1;
  for (std::size_t k = 0; k < run.ledger.size(); k += every) {
    curve.x.push_back(run.ledger[k].time);
    curve.y.push_back(value(k));
  }
  return curve;
}

// All energies as parts of the first total (figures 4-7, 14-16).
void draw_energies(const Request& request, const BendingRun& run) {
  LinePlot plot;
  plot.title = request.method + (request.variant.name.empty() ? "" : ", " + request.variant.name);
  plot.x_label = "time";
  plot.y_label = "part of the energy at the start";
  const auto add = [&](const char* name, auto value) {
    plot.curves.push_back(over_time(
        name, run, [&](std::size_t k) { return value(run.ledger[k]) / run.first_energy(); }));
  };
  add("kinetic, particles", [](const auto& row) { return row.kinetic; });
  add("kinetic, nodes", [](const auto& row) { return row.node_kinetic; });
  add("strain", [](const auto& row) { return row.strain; });
  add("total", [](const auto& row) { return row.total(); });
  add("interpolation error", [](const auto& row) { return row.interpolation_error; });
  add("algorithmic error", [](const auto& row) { return row.algorithmic_error; });
  request.draw(plot, "energy");
}

// ---------------------------------------------------------------------------------------------- bar

Measured bar(const Request& request) {
  const Watch watch{.accounts = true};
  const BendingRun run = simulate(request, {}, watch);
  Measured measured;
  measured.note = run.failure;
  measured.add("interpolation error",
               run.largest([](const auto& row) { return row.interpolation_error; }));
  measured.add("algorithmic error",
               run.largest([](const auto& row) { return row.algorithmic_error; }));
  measured.add("change of the total energy",
               run.largest([&](const auto& row) { return row.total() - run.first_energy(); }));
  add_fate(measured, run.reached(), [&] { return with_half_step(request, {}, watch); });
  draw_energies(request, run);
  return measured;
}

// ---------------------------------------------------------------------------------------------- cantilever

// The cantilever: 8 x 1, clamped at x = 0, by beam theory with its origin at the free end, x to the
// clamp and y down (eq. 33, 34; nu = 0, so E = 2 G, c = 1/2, I = 1/12).
struct Beam {
  static constexpr double length = 8, young = 3e5, inertia = 1.0 / 12, c = 0.5, density = 1000;
  double load = 0;
  double horizontal(double x, double y) const {
    const double EI = young * inertia, GI = EI / 2;
    return -load * x * x * y / (2 * EI) + load * y * y * y / (6 * GI) +
           (load * length * length / (2 * EI) - load * c * c / (2 * GI)) * y;
  }
  double down(double x) const {
    const double EI = young * inertia, L = length;
    return load * (x * x * x - 3 * L * L * x + 2 * L * L * L) / (6 * EI);
  }
  double stress(double X, double Y) const { return load * (length - X) * (Y - c) / inertia; }
  // Of the first mode.
  static double frequency() {
    return 3.5160 / (length * length) * std::sqrt(young * inertia / density);
  }
  // Deflection under a load that grows with time, over that under the same load at rest.
  static double ramp(double t) { return 1 - std::sin(frequency() * t) / (frequency() * t); }
};

constexpr double corner = 1.0 / 12;   // of the last particle from the end
constexpr double weak = 100.0 / 288;  // F = 100 by eq. 35 as printed
constexpr double near_axis = 0.5 - corner - 1e-6, far_axis = 0.5 + corner + 1e-6;

// Mean deflection of the two particles next to the axis at the free end.
double tip(const BendingParticles& particles) {
  double sum = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    if (particles.X[p][0] > Beam::length - 1.1 * corner && particles.X[p][1] > near_axis &&
        particles.X[p][1] < far_axis)
      sum += (particles.X[p][1] - particles.x[p][1]) / 2;
  return sum;
}

// Mean deflection of the tip over the last period, as part of that by beam theory for the mean load
// at the place of its particle.
double slow_deflection(const BendingRun& run, double load, double end) {
  const double from = end - 2 * std::numbers::pi / Beam::frequency(), a = Beam::length - corner;
  double sum = 0, loads = 0;
  for (std::size_t k = 0; k < run.ledger.size(); ++k)
    if (run.ledger[k].time > from) {
      sum += run.watched[k];
      loads += load * run.ledger[k].time / end;
    }
  return sum / (loads * a * a * a / (3 * Beam::young * Beam::inertia));
}

// How the horizontal stress departs from k (L - x)(y - c), with k fitted, as a part of its size.
struct StressFit {
  double inside = 0;    // 1 < x < 7
  double at_clamp = 0;  // x < 1
  // The part of it that varies over the height, and over the length of a cell, 1 < x < 7.
  double in_height = 0, in_length = 0;
};

// Sum of (stress - its mean over the particles of the same cell and the same place on `axis`)^2,
// for particle p.
double variation(const BendingParticles& particles, std::size_t p, int axis) {
  const auto cell = [&](std::size_t q, int d) { return std::floor(2 * particles.X[q][d]); };
  double mean = 0;
  int count = 0;
  for (std::size_t q = 0; q < particles.size(); ++q)
    if (std::abs(particles.X[q][axis] - particles.X[p][axis]) < 1e-6 && cell(q, 0) == cell(p, 0) &&
        cell(q, 1) == cell(p, 1)) {
      mean += particles.stress[q](0, 0);
      ++count;
    }
  return std::pow(particles.stress[p](0, 0) - mean / count, 2);
}

StressFit fit_stress(const BendingParticles& particles) {
  const Beam beam{1};
  const auto inside = [&](std::size_t p) { return particles.X[p][0] > 1 && particles.X[p][0] < 7; };
  const auto formula = [&](std::size_t p) {
    return beam.stress(particles.X[p][0], particles.X[p][1]);
  };
  double top = 0, bottom = 0;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    if (!inside(p)) continue;
    top += particles.stress[p](0, 0) * formula(p);
    bottom += std::pow(formula(p), 2);
  }
  double off = 0, clamp = 0, of_clamp = 0, height = 0, length = 0, size = 0;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const double expected = top / bottom * formula(p), stress = particles.stress[p](0, 0);
    if (particles.X[p][0] < 1) {
      clamp += std::pow(stress - expected, 2);
      of_clamp += expected * expected;
    }
    if (!inside(p)) continue;
    off += std::pow(stress - expected, 2);
    height += variation(particles, p, 0);
    length += variation(particles, p, 1);
    size += stress * stress;
  }
  return {std::sqrt(off / size), std::sqrt(clamp / of_clamp), std::sqrt(height / size),
          std::sqrt(length / size)};
}

// Held at x = 0, unless the study has the word "free".
Watch watch_tip(const Request& request) {
  return {.value = [](const auto& simulation) { return tip(simulation.particles()); },
          .change =
              [free = request.has_word("free")](BendingProblem& problem) {
                if (free) problem.boundaries.clear();
              },
          .accounts = false};
}

std::vector<std::string> ramp_of(double end, double step) {
  return {"constants.T=" + number(end), "end=" + number(end), "step=" + number(step)};
}

// Horizontal stress at the particles' first places, over that by beam theory at the clamp.
HeatMap stress_map(const std::string& title, const BendingParticles& particles, double load) {
  HeatMap map;
  HeatMapPanel panel;
  panel.title = title;
  panel.grid.dimension = 2;
  panel.grid.origin = {corner, corner};
  panel.grid.spacing = {2 * corner, 2 * corner};
  panel.grid.counts = {48, 6};
  panel.values.assign(panel.grid.size(), std::nan(""));
  const double most = load * Beam::length * Beam::c / Beam::inertia;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto i = static_cast<std::size_t>(particles.X[p][0] / (2 * corner));
    const auto j = static_cast<std::size_t>(particles.X[p][1] / (2 * corner));
    panel.values[j * 48 + i] = particles.stress[p](0, 0) / most;
  }
  map.panels.push_back(std::move(panel));
  map.colour_label = "stress / (F L c / I)";
  map.colour_range = Range{-1.2, 1.2};
  return map;
}

// The axis, the mean of the two rows of particles next to it, and that of beam theory (figure 11).
LinePlot axis_plot(const std::string& title, const BendingParticles& particles, double load) {
  LinePlot plot;
  plot.title = title;
  plot.x_label = "x";
  plot.y_label = "deflection";
  Curve axis{"particles", {}, {}, CurveStyle::line};
  for (int i = 0; i < 48; ++i) {
    double sum = 0;
    for (std::size_t p = 0; p < particles.size(); ++p)
      if (static_cast<int>(particles.X[p][0] / (2 * corner)) == i &&
          particles.X[p][1] > near_axis && particles.X[p][1] < far_axis)
        sum += (particles.x[p][1] - particles.X[p][1]) / 2;
    axis.x.push_back((2 * i + 1) * corner);
    axis.y.push_back(sum);
  }
  plot.curves.push_back(axis);
  for (const double factor : {1.0, Beam::ramp(20)}) {
    Curve line{factor == 1 ? "eq. 34" : "eq. 34 times the ramp's factor", {}, {}, CurveStyle::line};
    for (double X = 0; X < Beam::length + 0.05; X += 0.1) {
      line.x.push_back(X);
      line.y.push_back(-factor * Beam{load}.down(Beam::length - X));
    }
    plot.curves.push_back(line);
  }
  return plot;
}

std::string title_of(const Request& request) {
  return request.method + ", " + request.variant.name;
}

Measured cantilever(const Request& request) {
  constexpr double slow_end = 400;
  const Watch watch = watch_tip(request);
  Measured measured;
  const BendingRun quick = simulate(request, ramp_of(20, 0.003), watch);
  measured.note = quick.failure;
  if (!quick.failure.empty()) return measured;
  const BendingRun slow = simulate(request, ramp_of(slow_end, 0.0125), watch);
  measured.note = slow.failure;
  if (!slow.failure.empty()) return measured;
  const StressFit fit = fit_stress(quick.particles);
  measured.add("deflection, slow", slow_deflection(slow, weak, slow_end));
  measured.add("deflection, t = 20", quick.watched.back() / Beam{weak}.down(corner));
  measured.add("stress off beam theory, inside", fit.inside);
  measured.add("stress off beam theory, at the clamp", fit.at_clamp);
  measured.add("stress that varies over the height of a cell", fit.in_height);
  measured.add("stress that varies over the length of a cell", fit.in_length);
  request.draw(stress_map(title_of(request), quick.particles, weak), "stress");
  request.draw(axis_plot(title_of(request), quick.particles, weak), "axis");
  return measured;
}

// Particles under a large load, and the outer rows of them by eq. 33, 34 (figure 12).
LinePlot places_plot(const std::string& title, const BendingParticles& at, double load) {
  LinePlot plot;
  plot.title = title;
  Curve particles{"particles", {}, {}, CurveStyle::markers};
  for (const auto& x : at.x) {
    particles.x.push_back(x[0]);
    particles.y.push_back(x[1]);
  }
  plot.curves.push_back(particles);
  const Beam beam{load};
  Curve line{"eq. 33, 34", {}, {}, CurveStyle::line};
  for (const double Y : {corner, 1 - corner})
    for (double X = 0; X < Beam::length + 0.05; X += 0.1) {
      line.x.push_back(X - beam.horizontal(Beam::length - X, 0.5 - Y));
      line.y.push_back(X == 0 ? std::nan("") : Y - beam.down(Beam::length - X));  // rows apart
    }
  plot.curves.push_back(line);
  return plot;
}

// The load at time T, from the settings of the variant.
double load_of(const Request& request) {
  const std::string key = "constants.F=";
  for (const std::string& each : request.variant.settings)
    if (each.starts_with(key)) return to_number(each.substr(key.size())).value_or(0);
  return weak;
}

Measured cantilever_load(const Request& request) {
  const Watch watch = watch_tip(request);
  const double load = load_of(request);
  const BendingRun run = simulate(request, ramp_of(20, 0.003), watch);
  Measured measured;
  measured.note = run.failure;
  add_fate(measured, run.reached(),
           [&] { return with_half_step(request, ramp_of(20, 0.003), watch); });
  if (!run.failure.empty()) return measured;
  const Beam beam{load};
  measured.add("deflection, t = 20", tip(run.particles) / beam.down(corner));
  for (std::size_t p = 0; p < run.particles.size(); ++p) {
    const auto& X = run.particles.X[p];
    if (X[0] > Beam::length - 1.1 * corner && X[1] > 1 - 1.1 * corner)
      measured.add("way of the corner along x, t = 20",
                   (run.particles.x[p][0] - X[0]) / -beam.horizontal(corner, 0.5 - X[1]));
  }
  request.draw(places_plot(title_of(request), run.particles, load), "places");
  return measured;
}

// ---------------------------------------------------------------------------------------------- box

double box_height(const mpm::Simulation<2>& simulation) {
  const BendingParticles& particles = simulation.particles();
  double sum = 0, count = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    if (particles.body[p] == 1) sum += particles.x[p][1], ++count;
  return sum / count;
}

struct Impact {
  double lowest = 0, lowest_time = 0;  // of the mean height of the box
  double speed = 0;                    // upwards at the end
  double fastest = 0;                  // upwards
  double wavering = 0;  // what the velocity goes up and down, over what it has gained at the most
  int reversals = 0;    // of the acceleration of the box, beyond 2 % of the speed of impact
  double beam = 0;      // how far the middle of the beam is raised at the end
};

Impact impact_of(const BendingRun& run) {
  Impact impact;
  const std::vector<double>& y = run.watched;
  const std::size_t last = y.size() - 1, wide = 10;
  const auto lowest = std::min_element(y.begin(), y.end()) - y.begin();
  impact.lowest = y[lowest];
  impact.lowest_time = run.ledger[lowest].time;
  std::vector<double> v;  // mean of ten steps
  for (std::size_t k = wide; k <= last; ++k)
    v.push_back((y[k] - y[k - wide]) / (run.ledger[k].time - run.ledger[k - wide].time));
  impact.speed = v.back();
  impact.fastest = *std::max_element(v.begin(), v.end());
  double varied = 0, extreme = v.front();
  int direction = 0;
  for (std::size_t k = 1; k < v.size(); ++k) {
    varied += std::abs(v[k] - v[k - 1]);
    if (direction * (v[k] - extreme) >= 0 && direction != 0) extreme = v[k];
    if (std::abs(v[k] - extreme) > 0.04) {
      const int now = v[k] > extreme ? 1 : -1;
      if (direction != 0 && now != direction) ++impact.reversals;
      direction = now;
      extreme = v[k];
    }
  }
  impact.wavering = varied / (impact.fastest - *std::min_element(v.begin(), v.end()));
  double raised = 0, count = 0;
  for (std::size_t p = 0; p < run.particles.size(); ++p) {
    const auto& X = run.particles.X[p];
    if (run.particles.body[p] == 0 && std::abs(X[0] - 5) < 1)
      raised += run.particles.x[p][1] - X[1], ++count;
  }
  impact.beam = raised / count;
  return impact;
}

Measured box(const Request& request) {
  const double raised = request.word_value("raise").value_or(0);
  const Watch watch{.value = box_height,
                    .change =
                        [raised](BendingProblem& problem) {
                          for (std::size_t p = 0; p < problem.particles.size(); ++p)
                            if (problem.particles.body[p] == 1) problem.particles.x[p][1] += raised;
                        },
                    .accounts = true};
  const BendingRun run = simulate(request, {}, watch);
  Measured measured;
  measured.note = run.failure;
  add_fate(measured, run.reached(), [&] { return with_half_step(request, {}, watch); });
  if (!run.failure.empty()) return measured;
  const Impact impact = impact_of(run);
  measured.add("reversals of the acceleration", impact.reversals);
  measured.add("wavering of the velocity", impact.wavering);
  measured.add("greatest speed upwards", impact.fastest);
  measured.add("speed upwards at the end", impact.speed);
  measured.add("lowest place", impact.lowest);
  measured.add("time of the lowest place", impact.lowest_time);
  measured.add("rise of the middle of the beam", impact.beam);
  measured.add("change of the total energy",
               run.largest([&](const auto& row) { return row.total() - run.first_energy(); }));
  draw_energies(request, run);
  LinePlot height;
  height.title = title_of(request) + ": mean height of the box";
  height.x_label = "time";
  height.y_label = "y";
  height.curves.push_back(over_time("", run, [&](std::size_t k) { return run.watched[k]; }));
  request.draw(height, "height");
  return measured;
}

// ---------------------------------------------------------------------------------------------- negative mass

// N_1 of the 8-node element, (1 - xi)(1 - eta)(-xi - eta - 1) / 4, is positive in this part of it.
double positive_part() {
  constexpr int n = 1000;
  int positive = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double xi = (2 * i + 1.0) / n - 1, eta = (2 * j + 1.0) / n - 1;
      positive += (1 - xi) * (1 - eta) * (-xi - eta - 1) > 0;
    }
  return positive / static_cast<double>(n * n);
}

// The bar as a rigid body that flies over the elements; errors of places are parts of its way.
Measured negative_mass(const Request& request) {
  const bool stress = request.variant.name == "with stress";
  const Watch watch{.value = {},
                    .change =
                        [stress](BendingProblem& problem) {
                          if (!stress)
                            problem.materials = {mpm::LinearElastic{mpm::Lame{0, 1e-30}}};
                        },
                    .accounts = false};
  const std::vector<std::string> settings{"velocity=[0.5,0.3]", "end=3"};
  const BendingRun run = simulate(request, settings, watch);
  Measured measured;
  measured.note = run.failure;
  add_fate(measured, run.reached(), [&] { return with_half_step(request, settings, watch); });
  measured.add("part of the element where a corner function is positive", positive_part());
  if (!run.failure.empty()) return measured;
  const mpm::Vector<2> way(0.5 * run.end, 0.3 * run.end);
  double most = 0;
  for (std::size_t p = 0; p < run.particles.size(); ++p)
    most = std::max(most, (run.particles.x[p] - run.particles.X[p] - way).norm());
  measured.add("error of places", most / way.norm());
  return measured;
}

}  // namespace

std::span<const NamedMeasure> bending_measures() {
  static constexpr NamedMeasure all[] = {{"bar", bar},
                                         {"cantilever", cantilever},
                                         {"cantilever load", cantilever_load},
                                         {"box", box},
                                         {"negative mass", negative_mass}};
  return all;
}

}  // namespace recon::program
