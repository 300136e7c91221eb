// A problem, its state and its step in one object that cannot be misused.
//
// ```cpp
//   recon::mpm::Simulation<2> simulation(problem);
//   while (simulation.time() < end) simulation.step(simulation.choose_step().dt);
// ```
//
// step.hpp says what a step is. map() does its first part alone, for those who want to see the
// nodes (or an account, ledger.hpp) before the rest; step() then does not do it again.
#pragma once

#include "recon/mpm/step.hpp"

namespace recon::mpm {

template <int D>
class Simulation {
 public:
  // Throws InvalidArgument as Problem::validate() does.
  explicit Simulation(Problem<D> problem);

  const State<D>& state() const { return state_; }
  const Particles<D>& particles() const { return state_.particles; }
  double time() const { return state_.time; }
  std::int64_t steps() const { return state_.steps; }
  double last_step() const { return state_.last_dt; }  // dt of the step before; 0 at the start
  // The time by which the velocities of the particles are behind time().
  double velocity_lag() const { return problem().method.velocity_lag(state_.last_dt); }
  // Without its particles, which are in the state.
  const Problem<D>& problem() const { return step_.problem(); }
  // The nodes and cells that map() or step() computed last: after map() those of the state at
  // time(), after step() those with which the step moved its particles. Throw InvalidArgument
  // before the first call of either.
  const Nodes<D>& nodes() const;
  const Cells<D>& cells() const;
  // Whether nodes() and cells() belong to the particles as they are now.
  bool mapped() const { return nodes_state_ == NodesState::mapped; }
  // The first node of negative mass, and the first whose mass changed its sign between two steps.
  const std::optional<NegativeMass>& negative_mass() const { return step_.signs().negative; }
  const std::optional<NegativeMass>& sign_change() const { return step_.signs().change; }

  // What makes the steps, with its parts.
  const Step<D>& stepper() const { return step_; }

  // The step that the rule of the problem gives (problem.hpp).
  TimeStep choose_step() const { return mpm::choose_step(problem(), particles()); }

  // Computes nodes() (and cells()) from the particles, once for each state. Throws Failure.
  void map();
  // Throws InvalidArgument for a step that is not positive and finite, or too short to move the
  // clock; Failure where the particles cannot go on. In the second case some of them have already
  // moved: after that map() and step() throw InvalidArgument until restore() brings back a state.
  void step(double dt);

  // Continues from a state of another run of the same problem. Throws InvalidArgument, and leaves
  // everything as it was, for particles that differ in number, that Problem::validate() would
  // refuse, or that lack what the method keeps with them, and for a time, a number of steps or a
  // last step that no run can have.
  void restore(State<D> state);
  void restore(Particles<D> particles, double time, std::int64_t steps, double last_dt);

 private:
  State<D> state_;
  Step<D> step_;
  // What nodes() belong to. none: there was no map so far; mapped: the particles as they are;
  // stepped: the particles before the last step; broken: a step has failed.
  enum class NodesState { none, mapped, stepped, broken };
  NodesState nodes_state_ = NodesState::none;
};

extern template class Simulation<1>;
extern template class Simulation<2>;
extern template class Simulation<3>;

}  // namespace recon::mpm
