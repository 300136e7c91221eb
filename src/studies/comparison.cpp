#include "recon/studies/comparison.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "recon/runs/compose.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"
#include "recon/studies/stability.hpp"

namespace recon::mpm {
namespace {

// What a run shows, also where it fails.
template <int D>
void watch(const ProblemFile<D>& file, Simulation<D>& simulation, ComparisonRow& row) {
  using Clock = std::chrono::steady_clock;
  const Problem<D>& problem = simulation.problem();
  const Particles<D>& particles = simulation.particles();
  std::vector<double> seconds;
  std::optional<Ledger> start, before;
  std::optional<Clock::time_point> left;
  Ledger now;
  double most_energy = 0, most_momentum = 0, most_angular = 0;
  double momentum_defect = 0, angular_defect = 0;
  try {
    const auto observe = [&] {
      if (left) seconds.push_back(std::chrono::duration<double>(Clock::now() - *left).count());
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
      left = Clock::now();
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

}  // namespace

std::vector<ComparisonRow> compare(const LoadProblem& load, const ComparisonStudy& study,
                                   const std::function<void(const std::string&)>& progress) {
  constexpr int per_cell = 2;
  recon::detail::require(!study.cells.empty(), "grids of the comparison", 0,
                         "must be at least one");
  std::vector<ComparisonRow> rows;
  for (const std::string& method : study.methods) {
    if (progress) progress(method);
    ComparisonRow row, before;
    for (std::size_t g = 0; g < study.cells.size(); ++g) {
      const std::string settings[] = {"method.name=" + method,
                                      "grid.cells=" + recon::detail::to_text(study.cells[g])};
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
      const double ratio = std::log(study.cells[g] / study.cells[g - 1]);
      row.displacement_before = before.displacement;
      row.displacement_order = std::log(before.displacement_error / row.displacement_error) / ratio;
      row.velocity_order = std::log(before.velocity_error / row.velocity_error) / ratio;
    }
    row.method = method;
    if (study.stable_steps && row.refusal.empty())
      row.stable = stability_limit(composed(method), per_cell).measured;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace recon::mpm
