// A problem: bodies of particles on a grid, what acts on them, and how it is to be solved.
//
//   recon::mpm::Problem<2> problem;
//   problem.grid = {{0, 0}, {1, 1}, 0.05};
//   problem.materials = {recon::mpm::NeoHookean{Lame::from(1000, 0.3)}};
//   problem.particles.add(...);                   // or a problem file, read_problem.hpp
//   problem.method = recon::mpm::method_named("cpls");
//   recon::mpm::Simulation<2> simulation(problem);        // simulation.hpp
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recon/mpm/grid.hpp"
#include "recon/mpm/manufactured.hpp"
#include "recon/mpm/material.hpp"
#include "recon/mpm/method.hpp"
#include "recon/mpm/particles.hpp"

namespace recon::mpm {

// The nodes of the plane x_axis = at, which must be a plane of the grid. A velocity that is
// set is held there, the others are free: fixed, all zero; roller, the one of the axis zero.
template <int D>
struct Boundary {
  int axis = 0;
  double at = 0;
  std::array<std::optional<double>, D> velocity{};
};

// A force on one particle. With `area` N A0 (reference normal times reference area), `magnitude` is
// a pressure p and follows the surface: f = -p det F F^-T N A0. Without, the force is magnitude(t)
// * direction.
template <int D>
struct Load {
  std::size_t particle = 0;
  Vector<D> direction = Vector<D>::Zero(), area = Vector<D>::Zero();
  std::function<double(double t)> magnitude;
};

// At time t, force.
template <int D>
Vector<D> force_of(const Load<D>& load, const Particles<D>& particles, double t) {
  const Matrix<D>& F = particles.F[load.particle];
  const Vector<D> follower = F.determinant() * (F.inverse().transpose() * load.area);
  return load.magnitude(t) * (load.direction - follower);
}

// How the step is chosen; see Simulation::choose_step().
enum class StepRule { adaptive, p_wave, bar_wave, fixed };

struct TimeOptions {
  double end = 0;
  StepRule rule = StepRule::adaptive;
  double courant = 0.4;
  double step = 0;  // of the rule `fixed`
};

template <int D>
struct Problem {
  std::string title;
  Grid<D> grid;
  Particles<D> particles;
  std::vector<Material> materials;  // of each body
  std::vector<double> densities;    // reference density of each body
  std::vector<Boundary<D>> boundaries;
  Vector<D> gravity = Vector<D>::Zero();
  // Adds a force per mass to out[p]; empty: none.
  std::function<void(const Particles<D>&, double t, int threads, std::vector<Vector<D>>& out)>
      body_force;
  std::vector<Load<D>> loads;
  std::shared_ptr<const Manufactured<D>> exact;  // null: no solution is known
  Method method;
  TimeOptions time;
  int threads = 0;
  // Of what functions and initial values were made, by key: read_problem() fills it. A checkpoint
  // belongs to problems with the same texts; what is not told here cannot be compared.
  std::map<std::string, std::string> formulas{};

  // Velocity, velocity gradient and body force are made those of `exact`.
  void follow_exact();
  // Throws InvalidArgument where sizes disagree, a particle lies outside of the grid, a boundary on
  // no plane of it, or a value is not finite.
  void validate() const;
};

}  // namespace recon::mpm
