#include "recon/studies/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "recon/runs/run.hpp"

namespace recon::mpm {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The rows of one run, without orders.
template <int D>
void add_rows(const ProblemFile<D>& file, const std::vector<double>& times,
              const ConvergenceRow& row, std::vector<ConvergenceRow>& rows) {
  const Problem<D>& problem = file.problem;
  recon::detail::require(file.exact != nullptr, "problem", file.title,
                         "has no exact solution to compare with");
  std::string failure;
  Simulation<D> simulation(problem);
  for (const double part : times) {
    ConvergenceRow at = row;
    at.h = problem.grid.h();
    at.time = part * problem.time.end;
    std::vector<FieldError> found;
    for (const char* field : error_fields) found.push_back({field});
    if (failure.empty()) {
      try {
        run_until(simulation, at.time, {}, file.limits);
        found = errors(simulation, *file.exact);
        simulation.map();
        found.push_back(grid_velocity_error(simulation, *file.exact));
      } catch (const Failure& stop) {
        failure = stop.what();
      }
    }
    at.failure = failure;
    for (const FieldError& error : found)
      for (const char* norm : {"l2", "rms"}) {
        at.field = error.field;
        at.norm = norm;
        at.error = !failure.empty() ? nan : at.norm == "l2" ? error.l2 : error.rms;
        rows.push_back(at);
      }
  }
}

}  // namespace

std::vector<ConvergenceRow> converge(
    const LoadProblem& load, const ConvergenceStudy& study,
    const std::function<void(const std::string& method, int cells)>& progress) {
  std::vector<ConvergenceRow> rows;
  for (const std::string& method : study.methods)
    for (const int cells : study.cells) {
      if (progress) progress(method, cells);
      const std::string settings[] = {"method.name=" + method,
                                      "grid.cells=" + std::to_string(cells)};
      ConvergenceRow row;
      row.method = method;
      row.cells = cells;
      std::visit([&](const auto& file) { add_rows(file, study.times, row, rows); }, load(settings));
    }
  const auto place = [&](const ConvergenceRow& row) {
    const auto method = std::find(study.methods.begin(), study.methods.end(), row.method);
    return std::tuple(method - study.methods.begin(), row.time, row.field, row.norm, row.cells);
  };
  std::stable_sort(rows.begin(), rows.end(), [&](const ConvergenceRow& a, const ConvergenceRow& b) {
    return place(a) < place(b);
  });
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool first = i == 0 || rows[i].cells == study.cells.front();
    rows[i].order =
        first ? nan
              : std::log(rows[i - 1].error / rows[i].error) / std::log(rows[i - 1].h / rows[i].h);
  }
  return rows;
}

double slope(std::span<const ConvergenceRow> rows, const std::string& method,
             const std::string& field, const std::string& norm, double time) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const ConvergenceRow& row : rows) {
    if (row.method != method || row.field != field || row.norm != norm ||
        std::abs(row.time - time) > 1e-9 * time)
      continue;
    const double a = std::log(row.h), b = std::log(row.error);
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

}  // namespace recon::mpm
