// What run() asks of the simulation that it takes to its end: one of this process, one whose state
// is elsewhere (gpu/stepping.cpp), or one that is spread over several processes (ranks/run.cpp). In
// the last case all processes run the same run(), and ask the same in the same order.
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
  // The state, and what belongs to it. Where that has to be brought from elsewhere, this takes
  // time, and is asked where something is measured or written alone.
  virtual View<D> view() const = 0;
  struct Clock {
    double time, last_dt;
    std::int64_t steps;
  };
  virtual Clock clock() const {
    const State<D>& s = view().state();
    return {s.time, s.last_dt, s.steps};
  }
  double time() const { return clock().time; }
  std::int64_t steps() const { return clock().steps; }
  virtual const Problem<D>& problem() const { return view().problem(); }

  // Of the nodes whose velocity had to be mass-weighted the part that counts here.
  virtual double unfitted() const;
  // Each number becomes the sum of those of all processes.
  virtual void sum(std::span<double> numbers) const { view().sum(numbers); }

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

// Throws InvalidArgument for a problem that asks for a GPU.
template <int D>
void require_on_processor(const ProblemFile<D>& file);

template <int D>
RunResult run(ProblemFile<D>&& problem, const RunOptions& options, const Place<D>& place);

}  // namespace recon::mpm
