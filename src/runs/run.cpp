#include "recon/runs/run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "recon/runs/frames.hpp"
#include "runs/frame_fields.hpp"
#include "runs/rows_file.hpp"
#include "runs/stepping.hpp"

namespace recon::mpm {
namespace {

// The step, shortened so that `end` is met by steps of nearly equal length. Throws Failure where
// speeds have grown so much that no end is in sight.
template <class Stepped>
TimeStep step_towards(double end, Stepped& simulation, const Limits& limits) {
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

// A simulation of this process alone.
template <int D>
class Alone final : public Stepping<D> {
 public:
  explicit Alone(Problem<D>&& problem) : simulation_(std::move(problem)) {}

  TimeStep choose_step() override { return simulation_.choose_step(); }
  void map() override { simulation_.map(); }
  void step(double dt) override { simulation_.step(dt); }
  View<D> view() const override { return simulation_; }
  bool writes() const override { return true; }
  typename Stepping<D>::Restart read_checkpoint(const std::filesystem::path& path,
                                                const Formulas& formulas) override {
    RunState state = mpm::read_checkpoint(path, simulation_, formulas);
    return {std::move(state), forecast(simulation_.problem(), simulation_.state())};
  }
  void write_checkpoint(const std::filesystem::path& path, const Formulas& formulas,
                        const RunState& state) override {
    mpm::write_checkpoint(path, simulation_, formulas, state);
  }
  void write_frame(const std::filesystem::path& folder, const std::string& name,
                   std::vector<double>& times, const FrameOptions& options) override {
    mpm::write_frame(folder, name, simulation_, times, options);
  }
  MassSigns signs() const override { return simulation_.stepper().signs(); }

 private:
  Simulation<D> simulation_;
};

}  // namespace

template <int D>
double Stepping<D>::unfitted() const {
  const View<D> all = view();
  const Nodes<D>& nodes = all.nodes();
  if (all.is_whole() || nodes.unfitted == 0) return static_cast<double>(nodes.unfitted);
  double sum = 0;
  for (std::size_t t = 0; t < nodes.fit_nodes.size(); ++t)
    if (const std::uint32_t i = nodes.fit_nodes[t];
        nodes.mass[i] > 0 && nodes.fit[t].status == FitStatus::no_support)
      sum += nodes.share_of(i);
  return sum;
}

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
void require_on_processor(const ProblemFile<D>& file) {
  recon::detail::require(file.device == RunDevice::cpu, "device", "gpu",
                         "must be cpu here: run_on_gpu() of recon/gpu/run.hpp runs on a GPU, "
                         "alone, not on several ranks");
}

template <int D>
RunResult run(ProblemFile<D> file, const RunOptions& options) {
  require_on_processor(file);
  return run<D>(std::move(file), options, {[](Problem<D>&& problem) {
                  return std::make_unique<Alone<D>>(std::move(problem));
                }});
}

template <int D>
RunResult run(ProblemFile<D>&& file, const RunOptions& options, const Place<D>& place) {
  const double end = file.problem.time.end;
  recon::detail::require(std::isfinite(end), "end", end, "must be finite");
  file.problem.validate();
  file.limits.validate();
  RunResult result;
  const auto expect = [&](const Forecast& forecast, double time) {
    result.forecast = forecast;
    if (place.memory) result.forecast.memory = place.memory(forecast.memory);
    require_possible(result.forecast, file.limits, time);
  };
  expect(forecast(file.problem), 0);
  const int frames = file.output.frames;
  const std::filesystem::path ledger_path = options.folder / "ledger.csv";
  const std::filesystem::path probes_path = options.folder / "probes.csv";
  const std::filesystem::path checkpoint = options.folder / "checkpoint.h5";
  const bool from_start = options.restart.empty();
  const bool own_folder = !from_start && same_folder(options.restart.parent_path(), options.folder);
  if (!own_folder && !options.overwrite) {
    std::vector<std::filesystem::path> others = frames_in(options.folder, options.name, 0);
    others.insert(others.begin(), {ledger_path, probes_path, checkpoint});
    for (const auto& path : others)
      if (std::filesystem::exists(path))
        throw OtherRun(path, 0,
                       "is of another run; go on from its checkpoint, overwrite it, or choose "
                       "another folder");
  }

  // The particles go there: a run has them once.
  const std::unique_ptr<Stepping<D>> simulation = place.begin(std::move(file.problem));
  const std::optional<double> rest = simulation->problem().time.rest;
  RunState state;
  if (!from_start) {
    try {
      auto restart = simulation->read_checkpoint(options.restart, file.formulas);
      state = std::move(restart.state);
      if (simulation->time() > end * (1 + 1e-12))
        throw FileError(options.restart, 0,
                        "is at the time " + recon::detail::to_text(simulation->time()) +
                            ", after the end of the problem, " + recon::detail::to_text(end));
      result.forecast = std::move(restart.forecast);
    } catch (const FileError& why) {
      throw NoRestart(why);
    }
    expect(Forecast(result.forecast), simulation->time());
  }
  simulation->agree();
  if (options.begins) options.begins(result.forecast);
  FrameOptions frame_options;
  frame_options.fields = file.output.fields;
  frame_options.first_listed = own_folder ? 0 : state.frame_times.size();
  const bool writes = simulation->writes();
  std::optional<RowsFile> ledger_file, probes_file;
  if (writes) {
    std::error_code error;
    std::filesystem::create_directories(options.folder, error);
    if (error) throw FileError(options.folder, 0, "could not be made: " + error.message());
    begin_frames(options.folder, options.name, state.frame_times, frame_options.first_listed);
    if (file.output.ledger)
      ledger_file.emplace(ledger_path, ledger_header(), own_folder, simulation->steps());
    if (!file.probes.empty())
      probes_file.emplace(probes_path, probes_header(file.probes), own_folder, simulation->steps());
  }
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
           passes(spacing, state.frame_times.back(), simulation->time());
  };
  // Rows of the probes are due by time or number of the step alone, so that a restart has the same.
  const auto probes_due = [&] {
    const auto now = simulation->clock();
    const double interval = file.output.probe_interval;
    if (interval <= 0) return now.steps % file.output.probe_every == 0;
    return now.steps == 0 || passes(interval, now.time - now.last_dt, now.time);
  };
  // Without a ledger only the ends are accounted for, and the work between them is not known.
  const bool every_step = file.output.ledger || rest;
  std::optional<Ledger> before;
  for (bool first = true;; first = false) {
    simulation->map();
    bool done = simulation->time() >= end * (1 - 1e-14);
    // What the parts of the state, if there are several, know together.
    std::array<double, 2> of_all{simulation->unfitted(),
                                 !done && options.stop && options.stop() ? 1.0 : 0.0};
    simulation->sum(of_all);
    result.unfitted = std::max(result.unfitted, static_cast<std::size_t>(std::llround(of_all[0])));
    const bool stopped = of_all[1] > 0;
    if (every_step || first || done || stopped) {
      const View<D> view = simulation->view();
      const ExternalForces<D> forces = external_forces(view);
      Ledger now = account(
          view, forces, first && from_start ? std::optional<Ledger>() : std::optional(state.start),
          before);
      if (first && !from_start) now.work = state.work;
      state.work = every_step ? now.work : std::numeric_limits<double>::quiet_NaN();
      if (every_step) before = now;
      if (first && from_start) state.start = now;
      if (first) result.first = now;
      result.last = now;
      result.largest_momentum_defect =
          std::max(result.largest_momentum_defect, distance(now.momentum, now.node_momentum));
      if (ledger_file) ledger_file->add(ledger_row(now));
      if (const auto& tolerance = rest) {
        result.rest = rest_of(view, forces, now.node_kinetic, now.strain, *tolerance);
        done = done || result.rest->reached;
      }
    }
    const bool due = frame_due() || (done && frames > 0 && result.rest && result.rest->reached &&
                                     state.frame_times.back() < simulation->time());
    if (due)
      simulation->write_frame(options.folder, options.name, state.frame_times, frame_options);
    result.stopped = stopped && !done;
    if (!file.probes.empty() && (done || probes_due())) {
      const std::string row = probes_row(file.probes, simulation->view());
      if (probes_file) probes_file->add(row);
    }
    if (due || done || result.stopped || (first && from_start)) {
      if (ledger_file) ledger_file->flush();
      if (probes_file) probes_file->flush();
      simulation->write_checkpoint(checkpoint, file.formulas, state);
      if (options.saved) options.saved(simulation->time(), simulation->steps());
    }
    if (done || result.stopped) break;
    const TimeStep step = step_towards(end, *simulation, file.limits);
    simulation->step(step.dt);
    if (step.dt < result.shortest_step) {
      result.shortest_step = step.dt;
      result.limiting_particle = step.particle;
    }
    result.longest_step = std::max(result.longest_step, step.dt);
    if (options.progress) options.progress(simulation->time(), simulation->steps(), step);
  }
  result.steps = simulation->steps();
  result.time = simulation->time();
  const MassSigns signs = simulation->signs();
  result.negative_mass = signs.negative;
  result.sign_change = signs.change;
  result.frames = state.frame_times.size();
  result.spread = simulation->spread();
  return result;
}

#define RECON_INSTANTIATE(D)                                                    \
  template class Stepping<D>;                                                   \
  template void require_on_processor(const ProblemFile<D>&);                    \
  template RunResult run(ProblemFile<D>, const RunOptions&);                    \
  template RunResult run(ProblemFile<D>&&, const RunOptions&, const Place<D>&); \
  template void run_until(Simulation<D>&, double, const std::function<void()>&, const Limits&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
