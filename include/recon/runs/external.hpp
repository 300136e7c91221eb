// What acts on the bodies of a simulation from outside, at the nodes and at time t.
//
// With F_i = f_i + m_i g all forces on a node but those of damping, a_i its acceleration and d_i
// the part of damping in it, the force that holds a component of its velocity is what momentum
// lacks,
//     R = sum_j M_ij (a_j - d_j) - F_i   (M diagonal with a lumped mass) ,
// and the power of what acts on the nodes is
//     sum_i f_i . v_i over loads and damping, and R v over held components,
// with f_i what the loads add to the forces of the nodes, M d for damping, and v_i = v_i(t),
// carried to t by half the step before. Velocities that are held at 0 have no power. Gravity and
// body forces act on the particles: account() (ledger.hpp) adds their power.
#pragma once

#include <cstdint>
#include <vector>

#include "recon/runs/view.hpp"

namespace recon::mpm {

// A component of the velocity of a node that a boundary holds. A node that several boundaries hold
// is in the list for each of them; the last one's velocity is that of the node.
struct Reaction {
  std::size_t boundary = 0;  // its number in Problem::boundaries, from 0
  std::uint32_t node = 0;
  int axis = 0;
  double force = 0;    // R, on the body
  bool first = false;  // of several boundaries that hold the same
};

template <int D>
struct ExternalForces {
  std::vector<Vector<D>> loads;     // on the nodes; empty where there are none
  std::vector<Reaction> reactions;  // in the order of the boundaries
  double power = 0;                 // of loads, damping and reactions
  // Sums of absolute values: of the components of F_i that are free (of nodes that feel forces), of
  // the reactions, and of the forces from outside on particles and nodes (gravity, body force,
  // loads).
  double unbalanced = 0, held = 0, applied = 0;
};

// For the state that map() computed last. Throws InvalidArgument without one.
template <int D>
ExternalForces<D> external_forces(const Simulation<D>& simulation);
// The same; of a state of several parts, loads and reactions are those of this part, and power and
// sums those of all parts.
template <int D>
ExternalForces<D> external_forces(const View<D>& view);
// The same for a state that step.to_nodes() has mapped last. In a state of several parts
// (parts.hpp) all sums are those of one part, and the whole has their sums.
template <int D>
ExternalForces<D> external_forces(const State<D>& s, const Step<D>& step);

// How far a state is from rest: `unbalanced` over the larger one of `held` and `applied`, and the
// kinetic energy of the nodes over the strain energy. A body on which nothing acts, or that is not
// strained, is at no rest: its ratios are infinite.
struct RestMeasure {
  double unbalanced = 0, kinetic = 0;
  bool reached = false;
};

// Whether the state that map() computed last is at rest: both ratios are below the tolerance, no
// boundary moves, and the loads are those of the end of the problem (if it has one), to the
// tolerance: what still grows is no rest, however slowly it does. `forces` are those of the view,
// and the energies those of the whole.
template <int D>
RestMeasure rest_of(const View<D>& view, const ExternalForces<D>& forces, double node_kinetic,
                    double strain, double tolerance);

}  // namespace recon::mpm
