#include "recon/mpm/run.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "recon/io/atomic_file.hpp"
#include "recon/mpm/frames.hpp"

namespace recon::mpm {
namespace {

// The step, shortened so that `end` is met by steps of nearly equal length. Throws Failure where
// speeds have grown so much that no end is in sight.
template <int D>
Step step_towards(double end, const Simulation<D>& simulation) {
  Step step = simulation.choose_step();
  const double time = simulation.time(), left = end - time;
  const double steps = std::ceil(left / step.dt * (1 - 1e-12));
  const double most = simulation.problem().limits.steps;
  step.dt = left / steps;
  if (!(time + step.dt > time) || !(static_cast<double>(simulation.steps()) + steps <= most))
    throw Failure(simulation.steps(), "particle", step.particle,
                  "it asks for a step of " + recon::detail::to_text(step.dt) + " at " +
                      recon::detail::to_text(time) + ", so for " + recon::detail::to_text(steps) +
                      " more steps");
  return step;
}

// ledger.csv, complete also where a run ends by an exception; a run that goes on keeps the rows
// before `first_step`.
class LedgerFile {
 public:
  LedgerFile(const std::filesystem::path& path, bool goes_on, std::int64_t first_step)
      : path_(path) {
    std::string kept = ledger_header() + "\n";
    if (goes_on && std::filesystem::exists(path)) {
      std::ifstream before(path);
      std::string line;
      std::getline(before, line);
      while (std::getline(before, line) && std::atoll(line.c_str()) < first_step)
        kept += line + "\n";
    }
    AtomicFile file(path);
    file.write(kept);
    file.commit();
    out_.open(path, std::ios::app);
  }
  void add(const Ledger& ledger) {
    out_ << ledger_row(ledger) << '\n';
    if (!out_) throw FileError(path_, 0, "could not be written");
  }
  void flush() {
    if (!out_.flush()) throw FileError(path_, 0, "could not be written");
  }

 private:
  std::filesystem::path path_;
  std::ofstream out_;
};

}  // namespace

template <int D>
void run_until(Simulation<D>& simulation, double end, const std::function<void()>& observe) {
  for (;;) {
    const bool done = simulation.time() >= end * (1 - 1e-14);
    if (done && !observe) return;
    simulation.map();
    if (observe) observe();
    if (done) return;
    simulation.step(step_towards(end, simulation).dt);
  }
}

template <int D>
RunResult run(const ProblemFile<D>& file, const RunOptions& options) {
  const double end = file.problem.time.end;
  require(std::isfinite(end), "end", end, "must be finite");
  file.problem.validate();
  RunResult result;
  result.forecast = forecast(file.problem);
  require_possible(file.problem, result.forecast);
  const int frames = file.output.frames;
  const std::filesystem::path ledger_path = options.folder / "ledger.csv";
  const std::filesystem::path checkpoint = options.folder / "checkpoint.h5";
  const bool goes_on = !options.restart.empty();
  if (!goes_on && !options.overwrite)
    for (const auto& path : {ledger_path, checkpoint})
      if (std::filesystem::exists(path))
        throw FileError(path, 0,
                        "is of another run; go on with it, overwrite it, or choose another folder");

  Simulation<D> simulation(file.problem);
  RunState state;
  if (goes_on) {
    state = read_checkpoint(options.restart, simulation);
    result.forecast = forecast(simulation.problem(), simulation.time());
    require_possible(simulation.problem(), result.forecast, simulation.time());
  }
  if (options.begins) options.begins(result.forecast);
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) throw FileError(options.folder, 0, "could not be made: " + error.message());

  std::optional<LedgerFile> ledger_file;
  if (file.output.ledger) ledger_file.emplace(ledger_path, goes_on, simulation.steps());
  result.shortest_step = std::numeric_limits<double>::infinity();
  // The frame at which a restart begins has been written.
  const auto frame_due = [&] {
    if (frames == 0) return false;
    const auto written = static_cast<double>(state.frame_times.size());
    return simulation.time() >= written * end / frames * (1 - 1e-9);
  };
  const bool from_start = !goes_on;
  for (bool first = true;; first = false) {
    simulation.map();
    const bool done = simulation.time() >= end * (1 - 1e-14);
    const Ledger now =
        account(simulation,
                first && from_start ? std::optional<Ledger>() : std::optional<Ledger>(state.start));
    if (first && from_start) state.start = now;
    if (first) result.first = now;
    result.last = now;
    result.largest_momentum_defect =
        std::max(result.largest_momentum_defect, distance(now.momentum, now.node_momentum));
    result.unfitted = std::max(result.unfitted, simulation.nodes().unfitted);
    if (ledger_file) ledger_file->add(now);
    const bool due = frame_due();
    if (due) write_frame(options.folder, options.name, simulation, state.frame_times);
    if (due || done || (first && from_start)) {
      if (ledger_file) ledger_file->flush();
      write_checkpoint(checkpoint, simulation, state);
    }
    if (done) break;
    const Step step = step_towards(end, simulation);
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
  template void run_until(Simulation<D>&, double, const std::function<void()>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
