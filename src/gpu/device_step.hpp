// What a run on a GPU (stepping.hpp) asks of the step there: a state that stays in the memory of
// the GPU between steps, and copies of it.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "gpu/plan.hpp"
#include "recon/mpm/nodes.hpp"
#include "recon/mpm/state.hpp"

namespace recon::mpm {

// The particle at which a step could not go on.
struct Stopped {
  std::size_t particle;
  bool turned;  // inside out; else it is not in the grid
};

template <int D>
class DeviceStep {
 public:
  virtual ~DeviceStep() = default;

  virtual void put(const State<D>& s) = 0;
  // All of the state, into one of as many particles.
  virtual void bring(State<D>& s) = 0;
  // choose_step() of problem.hpp.
  virtual TimeStep choose_step() = 0;
  // Step::to_nodes(); a second time it does nothing.
  virtual void map() = 0;
  // Step::operator(). After a failure the state is what the step left.
  virtual std::optional<Stopped> step(double dt) = 0;

  // Nodes::unfitted of the last map(), and Step::signs() of all since put().
  virtual std::size_t unfitted() = 0;
  virtual MassSigns signs() const = 0;
};

template <int D>
using MakeStep = std::function<std::unique_ptr<DeviceStep<D>>(Plan<D>&&)>;

}  // namespace recon::mpm
