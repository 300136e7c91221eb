#include "bending.hpp"

#include <algorithm>
#include <cmath>

#include "bending_runs.hpp"
#include "programs/common/text.hpp"
#include "recon/runs/run.hpp"

namespace recon::program {
namespace {

// Largest |value| over time, as part of the first energy.
template <class Value>
double largest(const BendingRun& run, Value value) {
  double most = 0;
  for (const auto& row : run.ledger) most = std::max(most, std::abs(value(row)));
  return most / run.first_energy();
}

}  // namespace

std::span<const BendingPart> bending_parts() {
  static const std::vector<BendingPart> parts{{bar_figure, 35, measure_bar},
                                              {beam_figure, 20, measure_cantilever},
                                              {box_figure, 13, measure_box}};
  return parts;
}

std::string plain_name(const std::string& method) {
  if (method == "mpm") return "linear";
  if (method == "q8") return "8-node elements";
  if (method == "q9") return "9-node elements";
  if (method == "bspline2") return "quadratic splines";
  if (method == "bspline3") return "cubic splines";
  return method;
}

std::string percent(double part, int digits) {
  if (!std::isfinite(part)) return "-";
  double value = 100 * part;
  if (std::abs(value) >= std::pow(10.0, digits)) {  // no exponent: zeros at the end
    const double last = std::pow(10.0, std::floor(std::log10(std::abs(value))) + 1 - digits);
    value = std::round(value / last) * last;
    digits = 15;
  }
  return number(value, digits) + " %";
}

Words joined(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

double BendingRun::interpolation_error() const {
  return largest(*this, [](const auto& row) { return row.interpolation_error; });
}
double BendingRun::algorithmic_error() const {
  return largest(*this, [](const auto& row) { return row.algorithmic_error; });
}
double BendingRun::total_error() const {
  return largest(*this, [&](const auto& row) { return row.total() - first_energy(); });
}
std::string BendingRun::outcome() const {
  if (failure.empty()) return "runs";
  return "stops at t = " + number(ledger.back().time, 3) + ": " + failure;
}

BendingRun simulate(const std::string& problem, const Words& settings,
                    const std::function<double(const mpm::Simulation<2>&)>& watch,
                    const std::function<void(BendingProblem&)>& change, bool accounts) {
  auto file = std::get<mpm::ProblemFile<2>>(load(problem, settings));
  if (change) change(file.problem);
  mpm::Simulation<2> simulation(file.problem);
  BendingRun run;
  std::optional<mpm::Ledger> start;
  try {
    mpm::run_until<2>(simulation, file.problem.time.end, [&] {
      run.ledger.emplace_back();
      run.ledger.back().time = simulation.time();
      if (accounts) run.ledger.back() = mpm::account(simulation, start);
      if (!start) start = run.ledger.front();
      if (watch) run.watched.push_back(watch(simulation));
    });
  } catch (const mpm::Failure& stop) {
    run.failure = stop.what();
  }
  run.particles = simulation.particles();
  run.negative = simulation.negative_mass();
  run.sign = simulation.sign_change();
  if (run.negative) {
    const auto at = file.problem.grid.position(run.negative->node);
    run.where = "node " + std::to_string(run.negative->node) + " at (" + number(at[0], 4) + ", " +
                number(at[1], 4) + ") in step " + std::to_string(run.negative->step);
  }
  return run;
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

std::string energy_picture(const VerifyOptions& options, const std::string& figure,
                           const std::string& method, const BendingRun& run) {
  LinePlot plot;
  plot.title = figure + ", " + plain_name(method);
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
  return picture(options, figure, plot);
}

Conclusions::Conclusions(const std::string& figure) : figure_(figure) {
  found_.text = "## " + figure + "\n\n";
}

void Conclusions::add(const std::string& statement,
                      const std::vector<std::pair<bool, std::string>>& parts) {
  int kept = 0;
  std::string lines;
  for (const auto& [holds, measured] : parts) {
    kept += holds;
    lines += std::string("- ") + (holds ? "as claimed: " : "not as claimed: ") + measured + "\n";
  }
  const std::string verdict = verdict_of(kept, static_cast<int>(parts.size()));
  found_.verdicts.push_back({figure_, statement, verdict});
  found_.text += "### " + statement + "\n\nVerdict: " + verdict + ".\n\n" + lines + "\n";
}

}  // namespace recon::program
