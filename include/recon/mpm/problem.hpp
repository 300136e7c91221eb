// A problem: bodies of particles on a grid, what acts on them, and how it is to be solved.
//
// ```cpp
//   recon::mpm::Problem<2> problem;
//   problem.grid = {{0, 0}, {1, 1}, 0.05};
//   problem.materials = {recon::mpm::NeoHookean{recon::mpm::Lame::from(1000, 0.3)}};
//   problem.densities = {1};
//   problem.particles.add({0.5, 0.5}, half_edges, problem.densities[0], 0);  // particles.hpp
//   problem.method = recon::mpm::method_named("cpls");
//   recon::mpm::State<2> state = recon::mpm::start(problem);  // step.hpp, or runs/simulation.hpp
// ```
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "recon/mpm/material.hpp"
#include "recon/mpm/method.hpp"
#include "recon/mpm/particles.hpp"

namespace recon::mpm {

// A boundary condition on the nodes of the plane x_axis = at, which must be a plane of the grid.
// Velocity components that are set are held there, the others are free. fixed: all are zero.
// roller: that along the axis is zero.
template <int D>
struct Boundary {
  int axis = 0;
  double at = 0;
  std::array<std::optional<double>, D> velocity{};

  // Throws InvalidArgument for an axis or a plane that the grid does not have, and for a velocity
  // that is not finite.
  void validate(const Grid<D>& grid) const;
};

// A force on one particle. With `area` set to N A0 (reference normal times reference area),
// `magnitude` is a pressure p that follows the surface: f = -p det F F^-T N A0. Without `area` the
// force is magnitude(t) * direction.
template <int D>
struct Load {
  std::size_t particle = 0;
  Vector<D> direction = Vector<D>::Zero(), area = Vector<D>::Zero();
  std::function<double(double t)> magnitude;

  // Throws InvalidArgument unless the particle exists, all numbers are finite and there
  // is a magnitude.
  void validate(std::size_t particles) const;
};

// The force at time t.
template <int D>
Vector<D> force_of(const Load<D>& load, const Particles<D>& particles, double t) {
  const Matrix<D>& F = particles.F[load.particle];
  const Vector<D> follower = F.determinant() * (F.inverse().transpose() * load.area);
  return load.magnitude(t) * (load.direction - follower);
}

// Damping at the nodes, for bodies that are to come to rest. It takes from each component of the
// acceleration of a node
//     local |a_i| sign(v_i) + mass v_i ,   v_i as it was mapped.
// `local`, without a unit, is a force against the motion that is a part of the force out of
// balance: -local |f_i| sign(v_i) with a lumped mass (Cundall 1987, in: Analytical and
// Computational Methods in Engineering Rock Mechanics). It vanishes in balance, and damps all
// frequencies alike. `mass`, 1 / time, is the rate at which momentum decays, the rotation of whole
// bodies too.
struct Damping {
  double local = 0, mass = 0;

  bool any() const { return local != 0 || mass != 0; }
  // Throws InvalidArgument unless 0 <= local < 1 and mass is finite and not negative.
  void validate() const;
};

// How the step is chosen; see choose_step().
enum class StepRule { adaptive, p_wave, bar_wave, fixed };

struct TimeOptions {
  double end = std::numeric_limits<double>::infinity();
  StepRule rule = StepRule::adaptive;
  std::optional<double> courant;  // none: that of the method, Method::default_courant()
  double step = 0;                // of the rule `fixed`
  // Where it is set, a run ends as soon as it is at rest to this tolerance (runs/external.hpp).
  std::optional<double> rest;

  // Throws InvalidArgument unless all are positive, courant and step finite, and rest below 1.
  void validate() const;
};

// A time step, and the particle that limits it.
struct TimeStep {
  double dt = 0;
  std::size_t particle = 0;
};

template <int D>
struct Problem {
  Grid<D> grid;
  Particles<D> particles;
  std::vector<Material> materials;  // one per body
  std::vector<double> densities;    // reference density, one per body
  std::vector<Boundary<D>> boundaries;
  Vector<D> gravity = Vector<D>::Zero();
  // Adds a force per mass to out[p]; empty: none.
  std::function<void(const Particles<D>&, double t, int threads, std::vector<Vector<D>>& out)>
      body_force;
  std::vector<Load<D>> loads;
  Damping damping;
  Method method;
  TimeOptions time;
  int threads = 0;  // 0: all

  // What method and materials keep with each particle.
  Kept kept() const;
  // Throws InvalidArgument for a problem that cannot be stepped: choices of the method that do not
  // go together, arrays of particles of wrong length, values that are not finite or have a wrong
  // sign, a particle outside of the grid, a boundary on no plane of the grid, a body without a
  // material.
  void validate() const;
  // Checks particles that would take the place of those of the problem. What kept() counts may be
  // missing as a whole unless they are `complete`.
  void validate(const Particles<D>& others, bool complete = false) const;
};

// The step by the rule of the problem, for these particles as they are:
//   adaptive  courant h / max_p (c_p + |v_p|), c_p = sqrt((lambda + 2 mu) / density), density as it
//             is now
//   p_wave    courant h / c_p, bar_wave: courant h / sqrt(E / density), at the reference density
template <int D>
TimeStep choose_step(const Problem<D>& problem, const Particles<D>& particles);
// The number max_p (c_p + |v_p|) dt / h of a step dt, on which stability depends, whatever the rule
// of the step is.
template <int D>
double courant_of(const Problem<D>& problem, const Particles<D>& particles, double dt);

// Throws InvalidArgument unless the density is positive and finite.
void validate_density(double density);

}  // namespace recon::mpm
