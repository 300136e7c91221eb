// One time step: momentum on the grid, particles carried by it.
//
// ```cpp
//   recon::mpm::State<2> state = recon::mpm::start(problem);
//   recon::mpm::Step<2> step(problem);
//   while (state.time < end) step(state, choose_step(problem, state.particles).dt);
// ```
//
// With S and G the averages of N and grad N over the domain of a particle at its old place,
// a_i = f_i / m_i, and k = (dt_before + dt) / 2:
//   1  particles to nodes: v_i, m_i, f_i
//   2  nodes: a_i = f_i / m_i, held velocities, v_i+ = v_i + k a_i
//   3  nodes to particles: v_p += k sum S a_i ,  x_p += dt sum S v_i+ ,  L = sum v_i+ (x) G ,
//      F = (I + dt L) F ,  sigma = sigma(F)                          (Gong 2015, eq. 4.25-4.30)
//   4  the grid is forgotten
// This is the update `flip`; method.hpp has the others. A step is made of policies, one for each
// choice of the method: small objects that are asked once a step, or once a block of particles.
//
// Leapfrog: positions and stresses are at t, velocities half a step earlier. The first kick
// takes half a step, so that a start at t = 0 is of second order, and steps may differ in
// length. G is taken at the old place; at the new one, as the source prints, it costs an order.
//
// Nodes lighter than 1e-10 of the heaviest feel gravity alone, because forces on them would be
// divided by next to nothing. Nodes without mass stay at rest. Results are the same bits for any
// number of threads.
//
// A point that has just entered a cell of linear functions sees the far nodes of the cell with S
// near 0 and G = 1 / h. The acceleration of these nodes by internal forces is large because their
// mass is small. What the particle takes from it, S a, is not large, but its part of L would be. So
// in L (not in v_p and x_p) only a fraction theta_i of the internal part of a_i counts, limited by
// the stability of an explicit step:
//     theta_i = min(1, 0.5 m_i / (k dt K_i)) ,  K_i = sum_p V_p (lambda + 2 mu) |G|^2 ,
// at nodes lighter than a tenth of the heaviest. Inside a body k dt K / m is about
// 2.5 (c_p dt / h)^2. Domains and splines need no such limit: their |G|^2 / S is bounded.
//
// A particle that is carried over a face of the grid whose nodes are held in normal direction, by
// less than a thousandth of a cell, is put back on the face: averages over a sheared domain, half
// of which lies beyond the face, are not exactly at rest.
#pragma once

#include <memory>

#include "recon/mpm/nodes.hpp"
#include "recon/mpm/parts.hpp"
#include "recon/mpm/state.hpp"

namespace recon::mpm {

template <int D>
struct Policies;

template <int D>
class Step {
 public:
  // The problem's particles are not kept. Throws InvalidArgument for a method whose choices do not
  // go together.
  explicit Step(const Problem<D>& problem) : Step(problem, problem.particles.size()) {}
  // For a problem whose particles, so many, are elsewhere; in parts where `parts` are given, which
  // are asked for as long as this lives. Throws InvalidArgument as require_parts() does, too.
  Step(Problem<D> problem, std::size_t particles, OtherParts<D>* parts = nullptr);

  // The whole step. Throws Failure where the particles cannot go on; some of them have moved then.
  void operator()(State<D>& s, double dt);

  // Its parts: the first two (nodes() and cells() of this state, whose copies of other parts'
  // particles are brought up to date first), and the rest, which needs the first two of the same
  // state.
  void to_nodes(State<D>& s);
  void to_particles(State<D>& s, double dt);

  const Problem<D>& problem() const { return *problem_; }
  const Nodes<D>& nodes() const { return nodes_; }
  const Cells<D>& cells() const { return cells_; }
  const MassSigns& signs() const { return signs_; }
  // The body force per mass of the particles for which nodes() were computed; empty: none.
  const std::vector<Vector<D>>& body_force() const { return body_force_; }
  // The forces on the nodes from the loads of the problem on a state, those on its own particles
  // alone; empty: there are no loads.
  std::vector<Vector<D>> load_forces(const State<D>& s) const;
  // Forgets nodes, cells and signs of masses.
  void forget();

  // For updates, which change the nodes' velocities, and may map again.
  const Policies<D>& policies() const { return *policies_; }
  OtherParts<D>* parts() const { return parts_; }  // null: there is one whole
  Nodes<D>& changeable_nodes() { return nodes_; }

 private:
  // Makes the nodes those of a part of the grid.
  void see(const Window<D>& window);

  std::shared_ptr<const Problem<D>> problem_;
  std::shared_ptr<const Policies<D>> policies_;  // of this problem; they do not change
  OtherParts<D>* parts_ = nullptr;
  Nodes<D> nodes_;
  Cells<D> cells_;
  MassSigns signs_;
  std::vector<Vector<D>> body_force_;  // per mass of the particles; empty: none
};

extern template class Step<1>;
extern template class Step<2>;
extern template class Step<3>;

}  // namespace recon::mpm
