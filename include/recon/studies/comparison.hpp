// All methods side by side on one problem: what each gets right, and what it costs.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "recon/studies/convergence.hpp"

namespace recon::mpm {

struct ComparisonStudy {
  std::vector<std::string> methods;
  std::vector<double> cells;          // per unit length, ascending; the rows tell about the last
  bool stable_steps = true;           // also look for the largest stable step
  std::vector<double> courants = {};  // a row of each method for each; none: the problem's own
};

// The results of one method. NaN stands for what a problem or a method does not have. After a
// failure there are no errors, and the other numbers are about the time before it.
struct ComparisonRow {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::string method;
  double courant = none;  // where the study asked for some
  std::string refusal;    // why the method cannot run the problem; empty: it can
  std::string failure;    // why the run stopped; empty: it reached the end
  // l2 errors at the end against the exact solution (errors.hpp); orders relative to
  // the coarser grid.
  double displacement_error = none, velocity_error = none;
  double displacement_order = none, velocity_order = none;
  // The largest displacement of a particle at the end, on this grid and on the coarser one: without
  // an exact solution their difference shows how far the result has converged.
  double displacement = none, displacement_before = none;
  // The largest value over time of |sum_i p_i - sum_p p_p| / sum_p |p_p|, for momenta and for
  // angular momenta: what the velocity map fails to carry over to the nodes.
  double momentum_defect = none, angular_defect = none;
  // The angular momentum at the end less its exact value, over its largest size. Without an exact
  // solution it is known only where nothing acts on the bodies.
  double angular_error = none;
  // The change from start to end of the balance of energy (ledger.hpp: kinetic and strain energy
  // less the work of external forces), over the largest energy at any time.
  double energy_error = none;
  // Per particle and step, of the fastest tenth of the steps: of the processor where the problem has
  // one thread, so that other programs matter little, else of the clock on the wall.
  double nanoseconds = none;
  double stable =
      none;  // largest stable c_p dt / h (stability.hpp), two particles per cell and axis
  std::size_t negative_nodes = 0;  // most nodes of negative mass in a step
  bool sign_change = false;        // a node's mass changed its sign
};

// load(settings) reads the problem with "method.name=...", "grid.cells=..." and, where the study has
// some, "time.courant=..." set; the text of an exception from it becomes the refusal. progress() is
// called with the name of each method before it starts.
std::vector<ComparisonRow> compare(const LoadProblem& load, const ComparisonStudy& study,
                                   const std::function<void(const std::string&)>& progress = {});

}  // namespace recon::mpm
