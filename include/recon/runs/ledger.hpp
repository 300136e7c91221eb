// Momenta and energies of a simulation at one time: what should be conserved, and where it goes.
//
// Energies are at time t: velocities, known half a step earlier, are carried to t by half the step
// before. Momenta are those of the half step itself, before boundaries act:
//     momentum       sum_p m_p v_p          node_momentum  sum_i m_i v_i
//     angular        sum_p m_p x_p x v_p    node_angular   sum_i m_i x_i x v_i   about the origin
// The differences are the defect of the velocity map. Where particles carry more than a velocity
// (apic, polypic) their angular momentum is sum_p m_p (x_p x v_p + sum_d e_d x B_p e_d) with B_p =
// sum_i S_ip v_i d^T. Energies (Andersen, Andersen 2007, eq. 25-32):
//     kinetic        sum_p m_p v_p^2 / 2    node_kinetic   sum_i m_i v_i^2 / 2, with a consistent
//                                                          mass sum_ij v_i M_ij v_j / 2
//     strain         the integral of the strain energy
//     linear_strain  sum_p V_p sigma_p : epsilon_p / 2 with epsilon the strain of Hooke's law
//                    (eq. 27), which misses 13 % at an amplitude of 0.1
//     interpolation_error = node_kinetic - kinetic   and
//     algorithmic_error   = -(node_kinetic + strain), both less their value at the start
// of the account, so that the change of kinetic + strain is minus their sum. The algorithmic error
// is as published: the work of external forces is in it. What closes with it is
//     balance = kinetic + strain - work ,
// which should stay as it was at the start, with
//     power  sum_p m_p (g + b_p) . sum_i S_ip v_i  of gravity and body force b per mass, plus the
//            power of loads, of damping, and of reactions where a held velocity is not 0
//            (external.hpp)
//     work   its integral over time since the start, by the trapezoidal rule over the steps.
// What the balance loses is what the method dissipates: the part of velocities that the way to the
// nodes and back does not keep, and what boundaries take from mapped velocities.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "recon/runs/external.hpp"

namespace recon::mpm {

struct Ledger {
  std::int64_t step = 0;
  double time = 0, mass = 0, node_mass = 0;
  std::array<double, 3> momentum{}, node_momentum{}, angular{}, node_angular{};
  double kinetic = 0, node_kinetic = 0, strain = 0;
  double linear_strain = 0;
  double interpolation_error = 0, algorithmic_error = 0;
  std::size_t negative_nodes = 0;  // nodes of negative mass
  double power = 0, work = 0;

  double total() const { return kinetic + strain; }
  double balance() const { return total() - work; }
};

// The distance between two vectors.
inline double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// The account of the state that map() computed last. Errors of energy are relative to the account
// `start`; without one they and the work are zero. The work is that of the account `before`, one
// step earlier, and that of this step; it is unknown (NaN) with a start and without the account
// before.
template <int D>
Ledger account(const Simulation<D>& simulation, const std::optional<Ledger>& start = {},
               const std::optional<Ledger>& before = {});
// The same with the external forces of that state, where they are at hand; of a state of several
// parts on all of them.
template <int D>
Ledger account(const View<D>& view, const ExternalForces<D>& forces,
               const std::optional<Ledger>& start, const std::optional<Ledger>& before);
// The sums of a state that step.to_nodes() has mapped last: without errors of energy, work, and the
// power of the external forces. In a state of several parts (parts.hpp) they are those of one part,
// and the whole has their sums.
template <int D>
Ledger sums_of(const State<D>& s, const Step<D>& step);
// The account with these sums and this power of external forces.
Ledger account(const Ledger& sums, double power, const std::optional<Ledger>& start,
               const std::optional<Ledger>& before);

// The line of column names and a line of numbers, as ledger.csv has them.
std::string ledger_header();
std::string ledger_row(const Ledger& ledger);

}  // namespace recon::mpm
