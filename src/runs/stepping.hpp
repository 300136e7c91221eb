// What run() asks of the simulation that it takes to its end: one of this process, or one that is
// spread over several (ranks/run.cpp). In the second case all processes run the same run(), and
// ask the same in the same order.
#pragma once

#include <functional>
#include <memory>

#include "recon/runs/frames.hpp"
#include "recon/runs/run.hpp"

namespace recon::mpm {

template <int D>
class Stepping {
 public:
  // What the state that a run goes on from says.
  struct Restart {
    RunState state;
    Forecast forecast;
  };

  virtual ~Stepping() = default;

  // As in Simulation; the same on all processes.
  virtual TimeStep choose_step() = 0;
  virtual void map() = 0;
  virtual void step(double dt) = 0;
  // The state, and what belongs to it.
  virtual View<D> view() const = 0;
  double time() const { return view().state().time; }
  std::int64_t steps() const { return view().state().steps; }

  // Whether this process writes the files of the run.
  virtual bool writes() const = 0;
  // Throws where another process has failed.
  virtual void agree() {}
  // As the functions of these names do, for the whole state.
  virtual Restart read_checkpoint(const std::filesystem::path& path, const Formulas& formulas) = 0;
  virtual void write_checkpoint(const std::filesystem::path& path, const Formulas& formulas,
                                const RunState& state) = 0;
  virtual void write_frame(const std::filesystem::path& folder, const std::string& name,
                           std::vector<double>& times, const FrameOptions& options) = 0;

  // Of the whole run so far.
  virtual MassSigns signs() const = 0;
  virtual std::optional<Spread> spread() const { return {}; }
};

// Where a run happens.
template <int D>
struct Place {
  std::function<std::unique_ptr<Stepping<D>>(Problem<D>&&)> begin;
  // The memory that it takes on this machine, of what one process is expected to take; null: that.
  std::function<double(double)> memory{};
};

template <int D>
RunResult run(ProblemFile<D>&& problem, const RunOptions& options, const Place<D>& place);

}  // namespace recon::mpm
