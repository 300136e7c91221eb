// What the problems of the bending paper share: runs with an account, claims about them, pictures.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bending.hpp"
#include "recon/runs/ledger.hpp"

namespace recon::program {

using Words = std::vector<std::string>;
using BendingProblem = mpm::Problem<2>;
using BendingParticles = mpm::Particles<2>;

inline const std::string paper = "Andersen, Andersen 2007";
inline const std::string bar_figure = paper + ", section 4, figures 4-8";
inline const std::string beam_figure = paper + ", section 4.1, figures 10-12";
inline const std::string box_figure = paper + ", section 4.2, figures 14-17";

// The four of the paper, as methods of the driver.
inline const Words interpolations{"mpm", "q8", "q9", "bspline3"};

Findings measure_bar(const VerifyOptions& options, Progress& progress);
Findings measure_cantilever(const VerifyOptions& options, Progress& progress);
Findings measure_box(const VerifyOptions& options, Progress& progress);

// "cubic splines" for the method "bspline3".
std::string plain_name(const std::string& method);
std::string percent(double part, int digits = 2);
Words joined(Words a, const Words& b);

struct BendingRun {
  std::vector<mpm::Ledger> ledger;  // of every step
  std::vector<double> watched;      // the same steps
  BendingParticles particles;       // at the end
  std::optional<mpm::NegativeMass> negative, sign;
  std::string failure;
  std::string where;  // of the first negative mass

  double first_energy() const { return ledger.front().total(); }
  // Largest |value| over time, as parts of the first energy.
  double interpolation_error() const;
  double algorithmic_error() const;
  double total_error() const;
  // "runs", or when and why it stops.
  std::string outcome() const;
};

// An example problem, changed by settings and by `change`; `watch` is asked after every map().
// Without accounts the ledger has the times only.
BendingRun simulate(const std::string& problem, const Words& settings,
                    const std::function<double(const mpm::Simulation<2>&)>& watch = {},
                    const std::function<void(BendingProblem&)>& change = {}, bool accounts = true);

// A curve over time of at most 600 points; value(k) is that of step k.
Curve over_time(const std::string& name, const BendingRun& run,
                const std::function<double(std::size_t k)>& value);

// All energies as parts of the first total (figures 4-7, 14-16).
std::string energy_picture(const VerifyOptions& options, const std::string& figure,
                           const std::string& method, const BendingRun& run);

// Collects claims about one problem.
class Conclusions {
 public:
  explicit Conclusions(const std::string& figure);
  // A claim of several parts: whether each holds, and what is measured.
  void add(const std::string& statement, const std::vector<std::pair<bool, std::string>>& parts);
  void say(const std::string& text) { found_.text += text; }
  Findings finish() { return std::move(found_); }

 private:
  std::string figure_;
  Findings found_;
};

}  // namespace recon::program
