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

// A velocity component that a boundary holds: a number, or a function of the place x of the node
// and of time.
template <int D>
class HeldVelocity {
 public:
  using Function = std::function<double(const Vector<D>& x, double t)>;

  HeldVelocity(double constant = 0) : constant_(constant) {}  // NOLINT: numbers are velocities
  explicit HeldVelocity(Function function) : function_(std::move(function)) {}

  bool varies() const { return static_cast<bool>(function_); }
  double operator()(const Vector<D>& x, double t) const {
    return function_ ? function_(x, t) : constant_;
  }
  // Whether it is this number everywhere and always; a function is not.
  friend bool operator==(const HeldVelocity& a, double b) {
    return !a.varies() && a.constant_ == b;
  }

 private:
  double constant_ = 0;
  Function function_;
};

// Whether a place of a plane lies between two corners of it.
template <int D>
constexpr bool is_covered(int axis, const double* from, const double* to, const double* x,
                          double margin) {
  for (int d = 0; d < D; ++d)
    if (d != axis && !(x[d] >= from[d] - margin && x[d] <= to[d] + margin)) return false;
  return true;
}

// A boundary condition on the nodes of the plane x_axis = at, which must be a plane of the grid.
// Velocity components that are set are held there, the others are free. fixed: all are zero.
// roller: that along the axis is zero.
//
// Of the plane, the nodes between the corners `from` and `to` are held, up to a millionth of a
// cell; what these say along `axis` does not count. A velocity that varies is held at the time of
// the velocities, and particles get its change over the kick: with dt_before and dt the steps at
// time t, v(t - dt_before / 2) before the kick and v(t + dt / 2) after it (both without the halves
// for velocities at whole steps). In runge_kutta the stages have v of their time and the mean
// acceleration of the step, which is of second order.
//
// symmetry: the plane is one of symmetry, so that its normal velocity is zero, and what fits see
// of the particles goes on beyond it as in a mirror (transfer/images.hpp). It must be a whole face
// of the grid.
//
// images: no node is held, and the plane may lie anywhere between the nodes. Every particle has an
// image beyond the plane, which gives its nodes mass, momentum and force as particles do, so that
// nodes beyond the plane move as images: a roller is a mirror, and where all components are held
// the image has the opposite velocity and force. The velocity of the plane is then zero up to
// what the functions of the grid leave, and a particle may lie up to half a cell beyond it. The
// bodies lie on the side of the farther face, and the grid goes on for `image_cells` beyond the
// plane. On a plane of nodes linear functions at points see what a held node gives. (Ghost nodes by
// image points are future work in Gong 2015, chapter 8.)
template <int D>
struct Boundary {
  int axis = 0;
  double at = 0;
  std::array<std::optional<HeldVelocity<D>>, D> velocity{};
  Vector<D> from = Vector<D>::Constant(-std::numeric_limits<double>::infinity());
  Vector<D> to = Vector<D>::Constant(std::numeric_limits<double>::infinity());
  bool symmetry = false, images = false;

  // Whether a node of the plane is held, and a particle there meets a wall.
  bool covers(const Vector<D>& x, double margin) const {
    return is_covered<D>(axis, from.data(), to.data(), x.data(), margin);
  }
  // Whether it is a plane of nodes of the grid, to a millionth of a cell.
  bool is_on_nodes(const Grid<D>& grid) const;
  // Whether it is the lower (-1) or upper (1) face of the grid, or neither (0).
  int face(const Grid<D>& grid) const;

  // With images: whether the bodies lie below it, and whether it holds all components.
  bool is_upper(const Grid<D>& grid) const;
  bool holds_all() const;

  // Throws InvalidArgument for an axis or a plane that the grid does not have, a velocity that is
  // not finite, a part of the plane without nodes, and a plane of symmetry that is not a whole face
  // of the grid or holds another normal velocity than zero. With images the plane must be whole,
  // hold zero along its axis and zero or nothing along the others, and lie so far inside the grid
  // as said above.
  void validate(const Grid<D>& grid) const;
};

// How many cells of the grid lie beyond a plane with images and beyond the ends of a period: as far
// as a particle there sees nodes that fits and functions reach.
inline constexpr int image_cells = 4;

// A grid for problems in which what lies from lower to upper repeats itself along some axes: with
// `image_cells` more on both ends of these. Throws as CartesianGrid does.
template <int D>
Grid<D> periodic_grid(const Vector<D>& lower, const Vector<D>& upper, double h,
                      const std::array<bool, D>& periodic) {
  const Grid<D> period(lower, upper, h);
  Vector<D> from = lower, to = upper;
  for (int d = 0; d < D; ++d) {
    if (!periodic[d]) continue;
    from[d] -= image_cells * h;
    to[d] += image_cells * h;
  }
  return Grid<D>(from, to, h);
}

// Where a load acts: a place of the particle, in its reference domain and now, and the surface
// there, outward normal times area. Both areas are zero for a load that has no surface.
template <int D>
struct LoadedPlace {
  Vector<D> X, x;         // length
  Vector<D> area0, area;  // N A0 and n A = det F F^-T N A0
};

// A force on one particle, at the place X_p + offset of its reference domain. With `area` set to
// N A0 (reference normal times reference area) the force may depend on the surface as it is now:
// -p place.area for a pressure p, tau * place.area0.norm() for a nominal traction tau.
//
// With d the vector from the particle to the place as it is now, the nodes get
//     f_i += w_i f ,   w_i = S_ip + G_ip . d   over domains and with mls_bspline2,
//                      w_i = N_i at the place  for functions at points, along each axis linear
//                                              from where others than the particle's nodes come in
//                                              (through cells: N_i the spline whose slope G is).
// These sum to one and have the place as their mean, so that the nodes have the force f and its
// moment at the place, and none counts that has no mass from the particle. So the integral of
// N_i tau over a surface (Gong 2015, eq. 4.19) is a sum over the middles of faces of particles. At
// the particle's own place (offset 0) w is S.
template <int D>
struct Load {
  std::size_t particle = 0;
  Vector<D> offset = Vector<D>::Zero(), area = Vector<D>::Zero();
  std::function<Vector<D>(const LoadedPlace<D>& place, double t)> force;

  // Throws InvalidArgument unless the particle exists, all numbers are finite and there
  // is a force.
  void validate(std::size_t particles) const;
};

// A force magnitude(t) * direction on a particle.
template <int D>
Load<D> point_load(std::size_t particle, const Vector<D>& direction,
                   std::function<double(double t)> magnitude) {
  Load<D> load;
  load.particle = particle;
  if (magnitude)
    load.force = [direction, magnitude = std::move(magnitude)](const LoadedPlace<D>&, double t) {
      return Vector<D>(magnitude(t) * direction);
    };
  return load;
}

// Where a load acts now.
template <int D>
LoadedPlace<D> place_of(const Load<D>& load, const Particles<D>& particles) {
  const std::size_t p = load.particle;
  const Matrix<D>& F = particles.F[p];
  return {particles.X[p] + load.offset, particles.place(p, load.offset), load.area,
          F.determinant() * (F.inverse().transpose() * load.area)};
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

// Along a periodic axis all but the outer `image_cells` cells of the grid (periodic_grid) are one
// period of what repeats itself for ever. Particles near one end have images beyond the other, so
// that all nodes in reach have what those of the next period have; a particle that leaves at one
// end comes in at the other, and its reference place X and corners go with it, so that x - X is
// its displacement as before. Positions lie in the period, angular momentum is about the origin as
// everywhere, and jumps as a particle does.
template <int D>
struct Problem {
  Grid<D> grid;
  std::array<bool, D> periodic{};
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
  // From where to where particles may lie along an axis: a period, or between planes with images
  // and the faces of the grid.
  std::pair<double, double> room(int axis) const;
  // Whether there are images of particles that give to the nodes.
  bool has_images() const;
  // Throws InvalidArgument for a problem that cannot be stepped: choices of the method that do not
  // go together, arrays of particles of wrong length, values that are not finite or have a wrong
  // sign, a particle outside of the grid, a boundary on no plane of the grid, a body without a
  // material, images that the method cannot have, a boundary across a periodic axis.
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
