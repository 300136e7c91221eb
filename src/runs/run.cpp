#include "recon/runs/run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "recon/runs/frames.hpp"
#include "runs/rows_file.hpp"

namespace recon::mpm {
namespace {

// The step, shortened so that `end` is met by steps of nearly equal length. Throws Failure where
// speeds have grown so much that no end is in sight.
template <int D>
TimeStep step_towards(double end, const Simulation<D>& simulation, const Limits& limits) {
  TimeStep step = simulation.choose_step();
  const double time = simulation.time(), left = end - time;
  const double steps = std::ceil(left / step.dt * (1 - 1e-12));
  step.dt = left / steps;
  if (!(time + step.dt > time) ||
      !(static_cast<double>(simulation.steps()) + steps <= limits.steps))
    throw Failure(simulation.steps(), "particle", step.particle,
                  "it asks for a step of " + recon::detail::to_text(step.dt) + " at " +
                      recon::detail::to_text(time) + ", so for " + recon::detail::to_text(steps) +
                      " more steps");
  return step;
}

bool same_folder(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code none;
  const auto or_here = [](const std::filesystem::path& path) {
    return path.empty() ? std::filesystem::path(".") : path;
  };
  return std::filesystem::equivalent(or_here(a), or_here(b), none);
}

}  // namespace

template <int D>
void run_until(Simulation<D>& simulation, double end, const std::function<void()>& observe,
               const Limits& limits) {
  for (;;) {
    const bool done = simulation.time() >= end * (1 - 1e-14);
    if (done && !observe) return;
    simulation.map();
    if (observe) observe();
    if (done) return;
    simulation.step(step_towards(end, simulation, limits).dt);
  }
}

template <int D>
RunResult run(const ProblemFile<D>& file, const RunOptions& options) {
  const double end = file.problem.time.end;
  recon::detail::require(std::isfinite(end), "end", end, "must be finite");
  file.problem.validate();
  file.limits.validate();
  RunResult result;
  result.forecast = forecast(file.problem);
  require_possible(result.forecast, file.limits);
  const int frames = file.output.frames;
  const std::filesystem::path ledger_path = options.folder / "ledger.csv";
  const std::filesystem::path probes_path = options.folder / "probes.csv";
  const std::filesystem::path checkpoint = options.folder / "checkpoint.h5";
  const bool from_start = options.restart.empty();
  const bool own_folder = !from_start && same_folder(options.restart.parent_path(), options.folder);
  if (!own_folder && !options.overwrite)
    for (const auto& path : {ledger_path, probes_path, checkpoint})
      if (std::filesystem::exists(path))
        throw OtherRun(path, 0,
                       "is of another run; go on from its checkpoint, overwrite it, or choose "
                       "another folder");

  Simulation<D> simulation(file.problem);
  RunState state;
  if (!from_start) {
    try {
      state = read_checkpoint(options.restart, simulation, file.formulas);
      if (simulation.time() > end * (1 + 1e-12))
        throw FileError(options.restart, 0,
                        "is at the time " + recon::detail::to_text(simulation.time()) +
                            ", after the end of the problem, " + recon::detail::to_text(end));
    } catch (const FileError& why) {
      throw NoRestart(why);
    }
    result.forecast = forecast(simulation.problem(), simulation.state());
    require_possible(result.forecast, file.limits, simulation.time());
  }
  if (options.begins) options.begins(result.forecast);
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) throw FileError(options.folder, 0, "could not be made: " + error.message());

  std::optional<RowsFile> ledger_file, probes_file;
  if (file.output.ledger)
    ledger_file.emplace(ledger_path, ledger_header(), own_folder, simulation.steps());
  if (!file.probes.empty())
    probes_file.emplace(probes_path, probes_header(file.probes), own_folder, simulation.steps());
  FrameOptions frame_options;
  frame_options.fields = file.output.fields;
  frame_options.first_listed = own_folder ? 0 : state.frame_times.size();
  result.shortest_step = std::numeric_limits<double>::infinity();
  // Whether a multiple of an interval lies between two times.
  const auto passes = [](double interval, double from, double to) {
    const auto multiple = [&](double time) { return std::floor(time / interval * (1 + 1e-9)); };
    return multiple(to) > multiple(from);
  };
  // Frames are due at the multiples of this; the one at which a restart begins has been written.
  const double spacing = frames > 0 ? end / frames : 0;
  const auto frame_due = [&] {
    if (frames == 0) return false;
    return state.frame_times.empty() ||
           passes(spacing, state.frame_times.back(), simulation.time());
  };
  // Rows of the probes are due by time or number of the step alone, so that a restart has the same.
  const auto probes_due = [&] {
    const double interval = file.output.probe_interval, time = simulation.time();
    if (interval <= 0) return simulation.steps() % file.output.probe_every == 0;
    return simulation.steps() == 0 || passes(interval, time - simulation.last_step(), time);
  };
  // Without a ledger only the ends are accounted for, and the work between them is not known.
  const bool every_step = ledger_file || file.problem.time.rest;
  std::optional<Ledger> before;
  for (bool first = true;; first = false) {
    simulation.map();
    bool done = simulation.time() >= end * (1 - 1e-14);
    result.unfitted = std::max(result.unfitted, simulation.nodes().unfitted);
    const bool stopped = !done && options.stop && options.stop();
    if (every_step || first || done || stopped) {
      const ExternalForces<D> forces = external_forces(simulation);
      Ledger now = account(
          simulation, forces,
          first && from_start ? std::optional<Ledger>() : std::optional(state.start), before);
      if (first && !from_start) now.work = state.work;
      state.work = every_step ? now.work : std::numeric_limits<double>::quiet_NaN();
      if (every_step) before = now;
      if (first && from_start) state.start = now;
      if (first) result.first = now;
      result.last = now;
      result.largest_momentum_defect =
          std::max(result.largest_momentum_defect, distance(now.momentum, now.node_momentum));
      if (ledger_file) ledger_file->add(ledger_row(now));
      if (const auto& tolerance = file.problem.time.rest) {
        result.rest = rest_of(simulation, forces, now.node_kinetic, now.strain, *tolerance);
        done = done || result.rest->reached;
      }
    }
    const bool due = frame_due() || (done && frames > 0 && result.rest && result.rest->reached &&
                                     state.frame_times.back() < simulation.time());
    if (due)
      write_frame(options.folder, options.name, simulation, state.frame_times, frame_options);
    result.stopped = stopped && !done;
    if (probes_file && (done || probes_due()))
      probes_file->add(probes_row(file.probes, simulation));
    if (due || done || result.stopped || (first && from_start)) {
      if (ledger_file) ledger_file->flush();
      if (probes_file) probes_file->flush();
      write_checkpoint(checkpoint, simulation, file.formulas, state);
      if (options.saved) options.saved(simulation.time(), simulation.steps());
    }
    if (done || result.stopped) break;
    const TimeStep step = step_towards(end, simulation, file.limits);
    simulation.step(step.dt);
    if (step.dt < result.shortest_step) {
      result.shortest_step = step.dt;
      result.limiting_particle = step.particle;
    }
    result.longest_step = std::max(result.longest_step, step.dt);
    if (options.progress) options.progress(simulation.time(), simulation.steps(), step);
  }
  result.steps = simulation.steps();
  result.time = simulation.time();
  result.negative_mass = simulation.negative_mass();
  result.sign_change = simulation.sign_change();
  result.frames = state.frame_times.size();
  return result;
}

#define RECON_INSTANTIATE(D)                                        \
  template RunResult run(const ProblemFile<D>&, const RunOptions&); \
  template void run_until(Simulation<D>&, double, const std::function<void()>&, const Limits&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
