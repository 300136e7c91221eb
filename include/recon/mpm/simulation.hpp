// The time steps: momentum on the grid, particles carried by it.
//
// ```cpp
//   recon::mpm::Simulation<2> simulation(problem);
//   while (simulation.time() < end) simulation.step(simulation.choose_step().dt);
// ```
//
// A step is
//   1  particles to nodes: v_i, m_i, f_i
//   2  nodes: v_i += dt f_i / m_i
//   3  nodes to particles
// map() does the first part alone, for those who want to see the nodes (or an account, ledger.hpp)
// before the rest; step() then does not do it again.
//
// Leapfrog: positions and stresses are at t, velocities half a step earlier. The first kick
// takes half a step, so that a start at t = 0 is of second order, and steps may differ in
// length. With a_i = f_i / m_i, k = (dt_before + dt) / 2, and S, G of the domain of the particle
// at its old place:
//     v_i+ = v_i + k a_i ,  v_p += k sum S a_i ,  x_p += dt sum S v_i+ ,  L = sum v_i+ (x) G ,
//     F = (I + dt L) F ,  sigma = sigma(F)                              (Gong 2015, eq. 4.25-4.30)
// G is taken at the old place; at the new one, as the source prints, it costs an order.
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
//
// This is the update `flip`; method.hpp has the others. runge_kutta has velocities at t as well,
// and calls map() four times a step.
#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <stdexcept>
#include <string>

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/mpm/problem.hpp"

namespace recon::mpm {

// Thrown where a run cannot go on: a particle left the grid, was turned inside out, or is not
// finite; a node has a mass that cannot be divided by.
class Failure : public std::runtime_error {
 public:
  // place: "particle" or "node", the kind of thing that `number` counts.
  Failure(std::int64_t step, const char* place, std::size_t number, const std::string& what);
  std::int64_t step() const { return step_; }
  std::size_t number() const { return number_; }

 private:
  std::int64_t step_;
  std::size_t number_;
};

// A boundary condition: the velocity of a node along an axis is given.
struct HeldVelocity {
  std::uint32_t node = 0;
  int axis = 0;
  double velocity = 0;
};

// A node whose mass is negative. Functions of elements (q8, q9) are negative in parts, and a fitted
// density can be. Momentum and force are then negative as well, and velocity and acceleration are
// right in rigid motion; but when the sign changes, the mass passes through zero, and dividing by
// it makes both arbitrary (Andersen, Andersen 2007, appendix, corrected).
struct NegativeMass {
  std::int64_t step = 0;
  std::size_t node = 0;
  double mass = 0;
};

template <int D>
struct Nodes {
  std::vector<double> mass;
  Eigen::SparseMatrix<double> mass_matrix;  // consistent mass, else empty
  std::vector<Vector<D>> momentum;          // sum_p S m_p v_p, or as the map defines it
  std::vector<Vector<D>> force;             // internal and external
  std::vector<Vector<D>> mapped;            // v_i as it was mapped, before boundary conditions
  std::vector<Vector<D>> velocity;          // v_i
  std::vector<Vector<D>> acceleration;      // f_i / m_i, zero where the velocity is held
  // Only for point particles in linear functions with lumped mass, else empty: the part of internal
  // forces in `force`, and K_i = sum_p V_p (lambda + 2 mu) |G_ip|^2, force / length.
  std::vector<Vector<D>> internal;
  std::vector<double> stiffness;
  FitReports fit;  // reports of a fitted velocity, at the nodes fit_nodes
  std::vector<std::uint32_t> fit_nodes;
  std::size_t unfitted = 0;  // nodes with mass whose velocity had to be mass-weighted
  std::size_t negative = 0;  // nodes of negative mass
};

// The fits of the quadrature, for `cells` at the cell centres and for `nodal_cells` at the
// nodes. The columns of `values` are density, the stress (row after row of its upper triangle),
// and body force.
template <int D>
struct Cells {
  Eigen::MatrixXd values;
  std::vector<double> fill;  // part of each cell that holds material
  FitReports fit;
};

template <int D>
class Simulation {
 public:
  // Throws InvalidArgument as Problem::validate() does.
  explicit Simulation(Problem<D> problem);

  double time() const { return time_; }
  std::int64_t steps() const { return steps_; }
  double last_step() const { return last_dt_; }  // dt of the step before; 0 at the start
  // The time by which the velocities of the particles are behind time().
  double velocity_lag() const {
    return problem_.method.update == Update::runge_kutta ? 0 : last_dt_ / 2;
  }
  const Problem<D>& problem() const { return problem_; }
  const Particles<D>& particles() const { return problem_.particles; }
  // The nodes and cells that map() or step() computed last: after map() those of the state at
  // time(), after step() those with which the step moved its particles. Throw InvalidArgument
  // before the first call of either.
  const Nodes<D>& nodes() const;
  const Cells<D>& cells() const;
  // Whether nodes() and cells() belong to the particles as they are now.
  bool mapped() const { return nodes_state_ == NodesState::mapped; }
  // The first node of negative mass, and the first whose mass changed its sign between two steps.
  const std::optional<NegativeMass>& negative_mass() const { return negative_mass_; }
  const std::optional<NegativeMass>& sign_change() const { return sign_change_; }

  // The step that the rule of the problem gives (problem.hpp).
  Step choose_step() const { return mpm::choose_step(problem_); }

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
  void restore(Particles<D> particles, double time, std::int64_t steps, double last_dt);

 private:
  template <class Shape>
  void scatter(Shape shape_of);
  template <class Shape>
  void gather(Shape shape_of, const std::vector<Vector<D>>& carried,
              const std::vector<Vector<D>>& straining, double dt, double kick);
  template <class Shape>
  void start_modes(Shape shape_of);
  void move(std::size_t p, const Vector<D>& x);
  void strain(std::size_t p, const Matrix<D>& L, const Matrix<D>& F, double dt);
  void strain_by_map();
  void correct_momentum();
  void solve_consistent(std::vector<Eigen::Triplet<double>> entries, double lightest);
  void watch_mass(double lightest);
  void find_held();
  void hold_boundaries();
  void fill_nodes();
  void advance(double dt);
  void advance_runge_kutta(double dt);
  std::vector<Vector<D>> filtered(std::vector<Vector<D>> velocity) const;
  std::vector<Vector<D>> limited(double dt, double kick) const;

  Problem<D> problem_;
  double time_ = 0, last_dt_ = 0;
  std::int64_t steps_ = 0;
  // What nodes() belong to. none: there was no map so far; mapped: the particles as they are;
  // stepped: the particles before the last step; broken: a step has failed.
  enum class NodesState { none, mapped, stepped, broken };
  NodesState nodes_state_ = NodesState::none;
  Nodes<D> nodes_;
  Cells<D> cells_;
  std::vector<HeldVelocity> held_;
  std::array<std::array<bool, 2>, D> walls_{};  // faces that hold their normal velocity at 0
  std::vector<Vector<D>> acceleration_;         // body force per mass of the particles
  std::vector<signed char> signs_;              // of the nodes' masses, in the step before
  std::optional<NegativeMass> negative_mass_, sign_change_;
};

extern template class Simulation<1>;
extern template class Simulation<2>;
extern template class Simulation<3>;

}  // namespace recon::mpm
