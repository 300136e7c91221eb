// Errors and orders of convergence of methods on a problem with an exact solution.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "recon/runs/read_problem.hpp"
#include "recon/studies/errors.hpp"

namespace recon::mpm {

struct ConvergenceStudy {
  std::vector<std::string> methods;
  std::vector<int> cells;     // per unit length, ascending
  std::vector<double> times;  // ascending, as fractions of the end time
};

// The error of one field of a method, at one time on one grid. order = log(error_before / error) /
// log(h_before / h) relative to the grid before it, NaN for the first. A run that failed before
// that time has NaN, and its reason in `failure`.
struct ConvergenceRow {
  std::string method;
  int cells = 0;
  double h = 0, time = 0;
  std::string field, norm;  // one of error_fields; l2 or rms
  double error = 0, order = 0;
  std::string failure;
};

// load(settings) reads the problem with "method.name=..." and "grid.cells=..." set.
// progress() is called with method and cells before every run. Rows are sorted by method,
// time, field, norm, cells.
using LoadProblem = std::function<AnyProblem(std::span<const std::string> settings)>;
std::vector<ConvergenceRow> converge(
    const LoadProblem& load, const ConvergenceStudy& study,
    const std::function<void(const std::string& method, int cells)>& progress = {});

// The slope of log(error) over log(h) of a method, field, norm and time, by least squares over all
// grids; NaN where a run failed.
double slope(std::span<const ConvergenceRow> rows, const std::string& method,
             const std::string& field, const std::string& norm, double time);

}  // namespace recon::mpm
