// The runs of the studies (docs/claims): one method in one variant on one grid, and the numbers
// that it shows.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "judge.hpp"
#include "recon/io/picture.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/read_problem.hpp"
#include "recon/runs/run.hpp"

namespace recon::program {

struct Request {
  const Study& study;
  const Variant& variant;
  std::string method;
  int grid = 0;
  int threads = 1;
  std::string folder, name;  // where pictures go, and how they begin; no folder: no pictures

  // The settings of study and variant, method, grid and threads; without those words of the study
  // that are no settings of a problem ("free", "raise=..."), which word() finds.
  std::vector<std::string> settings() const;
  bool has_word(const std::string& word) const;
  std::optional<double> word_value(const std::string& word) const;
  mpm::AnyProblem load(std::vector<std::string> more = {}) const;
  // Draws NAME.png or NAME, TITLE.png. A picture that cannot be drawn is none.
  void draw(const LinePlot& plot, const std::string& title = "") const;
  void draw(const HeatMap& map, const std::string& title = "") const;
};

using Measure = Measured (*)(const Request& request);
// Throws InvalidArgument for a kind of study that is unknown.
Measure measure_of(const std::string& kind);

// What belongs to each file of measures.
struct NamedMeasure {
  const char* kind;
  Measure measure;
};
std::span<const NamedMeasure> convergence_measures();
std::span<const NamedMeasure> account_measures();
std::span<const NamedMeasure> bending_measures();
std::span<const NamedMeasure> fit_measures();
std::span<const NamedMeasure> stability_measures();
std::span<const NamedMeasure> probe_measures();

// The step that the rule of the problem gives, divided by a factor.
template <int D>
void shorten_step(mpm::Problem<D>& problem, double by) {
  problem.time.step /= by;
  problem.time.courant = problem.time.courant.value_or(problem.method.default_courant(D)) / by;
}

// Runs to the end, with observe() after every map(); why it stopped, nothing where it did not.
template <int D>
std::string run_to_end(mpm::Simulation<D>& simulation, const mpm::ProblemFile<D>& file,
                       const std::function<void()>& observe = {}) {
  try {
    mpm::run_until<D>(simulation, file.problem.time.end, observe, file.limits);
  } catch (const mpm::Failure& stop) {
    return stop.what();
  }
  return "";
}

// Why the same run stops with half the step.
template <int D>
std::string run_with_half_step(mpm::ProblemFile<D> file) {
  shorten_step(file.problem, 2);
  mpm::Simulation<D> simulation(file.problem);
  return run_to_end(simulation, file);
}

// How far a run comes: "part of the time", and "stops", which is 1 where it stops because a volume
// is no longer positive, and so with half the step.
template <class Run>
void add_fate(Measured& measured, double reached, Run half_step) {
  measured.add("part of the time", reached);
  const auto inverted = [](const std::string& note) {
    return note.find("volume is no longer positive") != std::string::npos;
  };
  const bool breaks = reached < 1 && inverted(measured.note) && inverted(half_step());
  measured.add("stops", breaks ? 1 : 0);
}

// The same of a run_to_end() whose outcome is noted.
template <int D>
void add_fate(Measured& measured, const mpm::Simulation<D>& simulation,
              const mpm::ProblemFile<D>& file) {
  add_fate(measured, measured.note.empty() ? 1 : simulation.time() / file.problem.time.end,
           [&] { return run_with_half_step(file); });
}

}  // namespace recon::program
