#include "recon/studies/comparison.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "recon/runs/compose.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"
#include "recon/studies/stability.hpp"

namespace recon::mpm {
namespace {

// Seconds that pass, or that the processor worked for this program.
double seconds_now(bool of_processor) {
  if (of_processor) return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

// What a run shows, also where it fails.
template <int D>
void watch(const ProblemFile<D>& file, Simulation<D>& simulation, ComparisonRow& row) {
  const Problem<D>& problem = simulation.problem();
  const Particles<D>& particles = simulation.particles();
  const bool one_thread = problem.threads == 1;
  std::vector<double> seconds;
  std::optional<Ledger> start, before;
  std::optional<double> left;
  Ledger now;
  double most_energy = 0, most_momentum = 0, most_angular = 0;
  double momentum_defect = 0, angular_defect = 0;
  try {
    const auto observe = [&] {
      if (left) seconds.push_back(seconds_now(one_thread) - *left);
      now = account(simulation, start, before);
      before = now;
      if (!start) start = now;
      most_energy = std::max(most_energy, now.total());
      double momentum = 0, angular = 0;
      for (std::size_t p = 0; p < particles.size(); ++p) {
        const double size = particles.mass[p] * particles.v[p].norm();
        momentum += size;
        angular += size * particles.x[p].norm();
      }
      most_momentum = std::max(most_momentum, momentum);
      most_angular = std::max(most_angular, angular);
      momentum_defect = std::max(momentum_defect, distance(now.momentum, now.node_momentum));
      angular_defect = std::max(angular_defect, distance(now.angular, now.node_angular));
      row.negative_nodes = std::max(row.negative_nodes, now.negative_nodes);
      left = seconds_now(one_thread);
    };
    run_until<D>(simulation, problem.time.end, observe, file.limits);
  } catch (const Failure& failure) {
    row.failure = failure.what();
  }
  row.sign_change = simulation.sign_change().has_value();
  row.momentum_defect = momentum_defect / most_momentum;
  if (D > 1) row.angular_defect = angular_defect / most_angular;
  if (!seconds.empty()) {
    const auto tenth = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 10);
    std::nth_element(seconds.begin(), tenth, seconds.end());
    row.nanoseconds = *tenth * 1e9 / static_cast<double>(particles.size());
  }
  if (!row.failure.empty()) return;
  row.energy_error = (now.balance() - start->balance()) / most_energy;
  const bool free = problem.boundaries.empty() && problem.loads.empty() && !problem.body_force &&
                    problem.gravity.isZero();
  if (D > 1 && (file.exact || free))
    row.angular_error =
        distance(now.angular,
                 file.exact ? exact_angular_momentum(simulation, *file.exact) : start->angular) /
        most_angular;
}

template <int D>
ComparisonRow run_one(const ProblemFile<D>& file) {
  ComparisonRow row;
  row.method = file.problem.method.name;
  Simulation<D> simulation(file.problem);
  watch(file, simulation, row);
  if (!row.failure.empty()) return row;
  const Particles<D>& particles = simulation.particles();
  row.displacement = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    row.displacement = std::max(row.displacement, (particles.x[p] - particles.X[p]).norm());
  if (!file.exact) return row;
  for (const FieldError& error : errors(simulation, *file.exact)) {
    if (error.field == "displacement") row.displacement_error = error.l2;
    if (error.field == "velocity") row.velocity_error = error.l2;
  }
  return row;
}

// One method at one step on all grids: the row of the finest, its orders from the one before. A
// courant number that is NaN leaves the problem's own.
ComparisonRow refined(const LoadProblem& load, const std::vector<double>& cells,
                      const std::string& method, double courant) {
  using recon::detail::to_text;
  ComparisonRow row, before;
  for (std::size_t g = 0; g < cells.size(); ++g) {
    std::vector<std::string> settings = {"method.name=" + method,
                                         "grid.cells=" + to_text(cells[g])};
    if (!std::isnan(courant)) settings.push_back("time.courant=" + to_text(courant));
    try {
      const AnyProblem any = load(settings);
      before = row;
      row = std::visit([](const auto& file) { return run_one(file); }, any);
    } catch (const std::exception& refusal) {
      row = {};
      row.refusal = refusal.what();
      break;
    }
    if (g == 0) continue;
    const double ratio = std::log(cells[g] / cells[g - 1]);
    row.displacement_before = before.displacement;
    row.displacement_order = std::log(before.displacement_error / row.displacement_error) / ratio;
    row.velocity_order = std::log(before.velocity_error / row.velocity_error) / ratio;
  }
  row.method = method;
  row.courant = courant;
  return row;
}

}  // namespace

std::vector<ComparisonRow> compare(const LoadProblem& load, const ComparisonStudy& study,
                                   const std::function<void(const std::string&)>& progress) {
  constexpr int per_cell = 2;
  recon::detail::require(!study.cells.empty(), "grids of the comparison", 0,
                         "must be at least one");
  std::vector<double> courants = study.courants;
  if (courants.empty()) courants = {ComparisonRow::none};
  std::vector<ComparisonRow> rows;
  for (const std::string& method : study.methods) {
    if (progress) progress(method);
    double stable = ComparisonRow::none;
    for (const double courant : courants) {
      ComparisonRow row = refined(load, study.cells, method, courant);
      if (study.stable_steps && row.refusal.empty() && std::isnan(stable))
        stable = stability_limit(composed(method), per_cell).measured;
      row.stable = stable;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace recon::mpm
