#include "recon/runs/simulation.hpp"

#include <cmath>

namespace recon::mpm {

using recon::detail::require;

template <int D>
Simulation<D>::Simulation(Problem<D> problem)
    : state_(start(std::move(problem))), step_(std::move(problem), state_.particles.size()) {}

template <int D>
const Nodes<D>& Simulation<D>::nodes() const {
  require(!step_.nodes().mass.empty(), "nodes", "none", "need a map() or a step() before");
  return step_.nodes();
}
template <int D>
const Cells<D>& Simulation<D>::cells() const {
  nodes();
  return step_.cells();
}

// After a failure nothing is what it says.
template <int D>
void Simulation<D>::map() {
  require(nodes_state_ != NodesState::broken, "simulation", "failed",
          "cannot go on after a step that failed; restore() brings back a state");
  if (nodes_state_ == NodesState::mapped) return;
  nodes_state_ = NodesState::broken;
  step_.to_nodes(state_);
  nodes_state_ = NodesState::mapped;
}

template <int D>
void Simulation<D>::step(double dt) {
  require(dt > 0 && std::isfinite(dt), "time step", dt, "must be positive and finite");
  require(time() + dt > time(), "time step", dt, "is too short to move the clock");
  map();
  nodes_state_ = NodesState::broken;
  step_.to_particles(state_, dt);
  nodes_state_ = NodesState::stepped;
}

template <int D>
void Simulation<D>::restore(Particles<D> particles, double time, std::int64_t steps,
                            double last_dt) {
  restore({std::move(particles), time, last_dt, steps});
}

template <int D>
void Simulation<D>::restore(State<D> state) {
  require(state.particles.size() == particles().size(), "particles of the restart",
          state.particles.size(), "must be as many as the problem has");
  problem().validate(state.particles, true);
  require(std::isfinite(state.time) && state.time >= 0, "time of the restart", state.time,
          "must be finite and not negative");
  require(state.steps >= 0, "steps of the restart", state.steps, "must not be negative");
  require(std::isfinite(state.last_dt) && state.last_dt >= 0, "last step of the restart",
          state.last_dt, "must be finite and not negative");
  state_ = std::move(state);
  step_.forget();
  nodes_state_ = NodesState::none;
}

template class Simulation<1>;
template class Simulation<2>;
template class Simulation<3>;

}  // namespace recon::mpm
