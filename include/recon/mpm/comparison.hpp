// All methods side by side on one problem: what each gets right, and what it costs.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "recon/mpm/convergence.hpp"

namespace recon::mpm {

struct ComparisonStudy {
  std::vector<std::string> methods;
  std::vector<double> cells;  // per unit length, ascending; the last is what the rows are about
  bool stable_steps = true;   // also look for the largest stable step
};

// One method. NaN stands for what a problem or a method does not have; after a failure there are no
// errors, and the rest is about the time before it.
struct ComparisonRow {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::string method;
  std::string refusal;  // why the method cannot run the problem; empty: it can
  std::string failure;  // why the run stopped; empty: it reached the end
  // l2 errors at the end against the exact solution (errors.hpp); orders against the grid before.
  double displacement_error = none, velocity_error = none;
  double displacement_order = none, velocity_order = none;
  // Largest displacement of a particle at the end, and on the grid before: what a problem without
  // an exact solution shows of convergence.
  double displacement = none, displacement_before = none;
  // The largest over all times of |sum_i p_i - sum_p p_p| over sum_p |p_p|, and of the same of
  // angular momenta: what the velocity map misses.
  double momentum_defect = none, angular_defect = none;
  // The angular momentum at the end less what it should be, over its largest size; without an exact
  // solution only where nothing acts on the bodies.
  double angular_error = none;
  // Kinetic and strain energy less the work of all loads, at the end less at the start, over the
  // largest energy on the way.
  double energy_error = none;
  double nanoseconds = none;  // per particle and step, of the fastest tenth of the steps
  double stable =
      none;  // largest stable c_p dt / h (stability.hpp), two particles per cell and axis
  std::size_t negative_nodes = 0;  // most nodes of negative mass in a step
  bool sign_change = false;        // a node's mass changed its sign
};

// load(settings) reads the problem with "method.name=..." and "grid.cells=..." set; what it throws
// is the refusal. Told before every method.
std::vector<ComparisonRow> compare(const LoadProblem& load, const ComparisonStudy& study,
                                   const std::function<void(const std::string&)>& progress = {});

}  // namespace recon::mpm
