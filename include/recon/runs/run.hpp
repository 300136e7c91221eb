// A problem from beginning to end, with everything that it leaves behind.
//
// The folder of a run has
//   ledger.csv        an account of every step (ledger.hpp)
//   probes.csv        what the probes of the problem measure (probes.hpp), where it has any
//   NAME_*.vtp, ...   frames (frames.hpp)
//   checkpoint.h5     the state at the last frame (checkpoint.hpp), from which a run goes on
//
// A run that fails leaves frames and checkpoint as they were at the last frame, and the ledger up
// to the step that failed. One that is stopped leaves a checkpoint of the step at which it was.
#pragma once

#include <functional>
#include <optional>

#include "recon/runs/checkpoint.hpp"
#include "recon/runs/external.hpp"
#include "recon/runs/forecast.hpp"
#include "recon/runs/read_problem.hpp"

namespace recon::mpm {

// Thrown where the folder holds the ledger, the checkpoint or frames of another run.
class OtherRun : public FileError {
 public:
  using FileError::FileError;
  explicit OtherRun(const FileError& why) : FileError(why) {}
};

// Thrown where a run cannot be continued from the given checkpoint.
class NoRestart : public FileError {
 public:
  explicit NoRestart(const FileError& why) : FileError(why) {}
};

struct RunOptions {
  std::filesystem::path folder{};   // created if need be
  std::string name = "run";         // NAME of the frames
  std::filesystem::path restart{};  // a checkpoint to go on from; empty: from the start
  bool overwrite = false;           // whether files of another run may be
  // Called before the first step, when everything has been checked.
  std::function<void(const Forecast& forecast)> begins{};
  // Called after every step.
  std::function<void(double time, std::int64_t steps, const TimeStep& step)> progress{};
  // Called after every checkpoint.
  std::function<void(double time, std::int64_t steps)> saved{};
  // Called before every step: true ends the run there, with a checkpoint.
  std::function<bool()> stop{};
};

// How a run was spread over ranks (ranks/run.hpp), at its end.
struct Spread {
  int ranks = 1;
  std::size_t least = 0, most = 0;  // particles of a rank
  std::size_t copies = 0;           // of particles of other ranks, on all ranks
  double bytes_per_step = 0;        // that all ranks sent each other, for all that was done
};

struct RunResult {
  Forecast forecast;  // what was expected before
  std::int64_t steps = 0;
  double time = 0;
  Ledger first, last;
  double shortest_step = 0, longest_step = 0;
  std::size_t limiting_particle = 0;  // of the shortest step
  // |nodes' - particles'|, of all steps; of the first and the last one without a ledger.
  double largest_momentum_defect = 0;
  std::size_t unfitted = 0;  // most nodes in a step without a fit of their own
  std::optional<NegativeMass> negative_mass, sign_change;  // see Simulation
  std::size_t frames = 0;
  bool stopped = false;  // as RunOptions::stop asked, before the end
  // Of the last state, where the problem asks for rest (TimeOptions::rest); a run that comes to its
  // end without it is not at rest.
  std::optional<RestMeasure> rest;
  std::optional<Spread> spread;
};

// Runs the problem to its end, or until it is at rest where TimeOptions::rest asks for that. A
// restart from a checkpoint in the folder continues the run there: its ledger is kept up to the
// checkpoint, and its frames stay in the lists. Files of any other run are overwritten only if
// RunOptions::overwrite says so, and then none of its frames of this name is left; otherwise
// OtherRun is thrown. Throws NoRestart for a checkpoint
// that read_checkpoint() refuses or that is later than the end, FileError for files that cannot be
// written, InvalidArgument for a problem without an end or one that takes more than there is
// (forecast.hpp), Failure where the run cannot go on.
template <int D>
RunResult run(ProblemFile<D> problem, const RunOptions& options);

// Steps until `end` exactly, without any output. The steps are equal where their rule gives the
// same for all. observe() is called after every map(), also after the last one, at `end`. Throws
// Failure where the run cannot go on, or would take more steps than the limits allow.
template <int D>
void run_until(Simulation<D>& simulation, double end, const std::function<void()>& observe = {},
               const Limits& limits = {});

}  // namespace recon::mpm
