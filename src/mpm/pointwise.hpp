// What a step does to single nodes and particles: the bodies of its loops, on plain numbers, so
// that they are the same wherever the loop runs (policies.hpp: over arrays of this process; gpu/:
// over those of a GPU).
//
// Vectors are D numbers in a row. `heaviest` is the largest mass of a node, without its sign.
#pragma once

#include <cmath>

#include "recon/mpm/problem.hpp"

namespace recon::mpm {

constexpr double lightest_node = 1e-10;  // of the heaviest: lighter ones do not feel forces
constexpr double light_node = 0.1;       // of the heaviest: lighter ones may strain too much
constexpr double most_strained = 0.5;    // k dt K / m of a light node

constexpr double magnitude(double number) {
  return number < 0 ? -number : number;
}

// v_i = p_i / m_i and a_i = f_i / m_i + g of a node.
template <int D>
constexpr void move_node(double mass, const double* momentum, const double* force,
                         const double* gravity, double heaviest, double* mapped,
                         double* acceleration) {
  const bool feels_forces = magnitude(mass) > lightest_node * heaviest;
  for (int d = 0; d < D; ++d) {
    mapped[d] = mass == 0 ? 0 : momentum[d] / mass;
    acceleration[d] = mass == 0 ? 0 : gravity[d];
    if (mass != 0 && feels_forces) acceleration[d] += force[d] / mass;
  }
}

// -1, 0 or 1: of masses that are more than next to nothing.
constexpr int sign_of_mass(double mass, double heaviest) {
  const double lightest = lightest_node * heaviest;
  return mass > lightest ? 1 : mass < -lightest ? -1 : 0;
}

// What damping adds to a component of the acceleration a of a node that was mapped to have the
// velocity v.
constexpr double damping_of(const Damping& damping, double v, double a) {
  const double against = v > 0 ? -1 : v < 0 ? 1 : 0;
  return against * damping.local * magnitude(a) - damping.mass * v;
}

// By how much of its internal force the velocity of a node counts less in L than it is, time /
// mass: 0 where its mass is large enough for the step (step.hpp).
constexpr double left_out_of_strain(double mass, double stiffness, double kick, double dt,
                                    double heaviest) {
  const double size = magnitude(mass), strained = kick * dt * stiffness;
  const bool feels_forces = size > lightest_node * heaviest;
  if (!feels_forces || size > light_node * heaviest || strained <= most_strained * size) return 0;
  return (1 - most_strained * size / strained) * kick / mass;
}

// v_p after a kick of which it takes the part `pic` of what it sees of the nodes' velocities.
template <int D>
constexpr void kick_particle(double pic, double kick, const double* seen_velocity,
                             const double* seen_acceleration, double* v) {
  for (int d = 0; d < D; ++d) {
    if (pic < 1) v[d] += kick * seen_acceleration[d];
    if (pic == 1)
      v[d] = seen_velocity[d];
    else if (pic > 0)
      v[d] += pic * (seen_velocity[d] - v[d]);
  }
}

// (I + dt L) F
template <class M>
constexpr M deformed(const M& F, const M& L, double dt) {
  return (M::Identity() + dt * L) * F;
}

// Stress, strain energy and history of a particle after the step that led to F.
template <class AnyMaterial, class M>
constexpr void strain_particle(const AnyMaterial& material, const M& F, const M& L, double dt,
                               double volume0, M& stress, double& energy,
                               [[maybe_unused]] double* history) {
  double density = energy / volume0;
  if constexpr (history_of<AnyMaterial>() > 0)
    material.update(F, L, dt, stress, density, history);
  else
    material.update(F, L, dt, stress, density);
  energy = density * volume0;
}

// How fast waves run past a place of the grid: c_p + |v_p|, or what the rule takes for it.
constexpr double fastest(StepRule rule, const Lame& elastic, double mass, double volume0,
                         double det_F, double speed) {
  if (rule == StepRule::adaptive) return elastic.p_wave_speed(mass / (det_F * volume0)) + speed;
  return rule == StepRule::p_wave ? elastic.p_wave_speed(mass / volume0)
                                  : elastic.bar_wave_speed(mass / volume0);
}

// Whether a particle has passed a face by so little that it is put back.
constexpr bool passes_by_a_hair(double x, double face, bool upper, double h) {
  const double beyond = upper ? x - face : face - x;
  return beyond > 0 && beyond < 1e-3 * h;
}

}  // namespace recon::mpm
