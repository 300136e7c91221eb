// The state of a run: data, which a step (step.hpp) takes and changes.
#pragma once

#include "recon/mpm/problem.hpp"

namespace recon::mpm {

template <int D>
struct State {
  Particles<D> particles;
  double time = 0;
  double last_dt = 0;      // of the step before; 0 at the start
  std::int64_t steps = 0;  // made so far
  // So many of the particles, the last ones, are copies of those of other parts (parts.hpp): they
  // give to the nodes as all do, and are not moved.
  std::size_t others = 0;

  // The number of all other particles.
  std::size_t own() const { return particles.size() - others; }

  // A step dt has been made.
  void tick(double dt) {
    time += dt;
    last_dt = dt;
    ++steps;
  }
};

// The state at t = 0 of the problem's particles: with the corners, modes and history that method
// and materials keep with them, where the problem does not give these. Throws InvalidArgument as
// Problem::validate() does.
template <int D>
State<D> start(const Problem<D>& problem);
// The same without a copy: the problem's particles become those of the state.
template <int D>
State<D> start(Problem<D>&& problem);

}  // namespace recon::mpm
