// A method is a choice of policies. The methods of the literature are rows of a table; any of their
// choices can be replaced (by their names in texts: runs/compose.hpp):
//
// ```cpp
//   recon::mpm::Method method = recon::mpm::method_named("cpdi1");
//   method.velocity = recon::mpm::VelocityMap::affine;
//   method.validate(2);  // throws where a choice needs what another one does not have
// ```
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "recon/mpm/shapes.hpp"

namespace recon::mpm {

// What a particle is (transfer/domain_functions.hpp), and with which functions it sees the grid
// (transfer/point_functions.hpp). Domains other than the point need the linear basis. mls_bspline2
// is bspline2 with the gradients of MLS-MPM (Hu et al. 2018); cell_linear and cell_bspline2 are
// linear functions seen through the centres of the cells.
enum class Domain { point, ugimp, cpgimp, cpdi1, cpdi2 };
enum class Basis { linear, q8, q9, bspline2, bspline3, mls_bspline2, cell_linear, cell_bspline2 };

// How the velocities v_i at the nodes follow from those of the particles, with d = x_i - x_p:
//   mass_weighted  sum_p S_ip m_p v_p / m_i, which is Shepard's with the weight m_p S_ip
//   mls            moving least squares, tensor cubic B-spline of support 2 h, moments on the grid
//   imls           the same by graded Gram-Schmidt with neighbour lists; degree up to 3
//   cpls           imls from particles and the corners of their domains,
//                  v_c = v_p + L_p (x_c - x_p)
//   taylor         sum_p S_ip m_p (v_p + L_p d) / m_i (Wallstedt, Guilkey 2007)
//   affine         sum_p S_ip m_p (v_p + C_p d) / m_i with C_p = B_p D_p^+ of the step before, B_p
//                  and D_p the sums of S_ip v_i d^T and of S_ip d d^T (Jiang et al. 2015). Over any
//                  domain: linear fields and momentum are kept; angular momentum as far as D_p is
//                  where the particle goes what it was, so exactly with splines. A direction that
//                  a small domain does not see has no slope (transfer/modes.hpp)
//   polynomial     the same with all products of the polynomials 1, d, d^2 of the axes, made
//                  orthogonal under S_ip (Fu et al. 2017)
enum class VelocityMap { mass_weighted, mls, imls, cpls, taylor, affine, polynomial };

// How mass, forces and, for maps that weight by mass, momentum of the nodes are integrated:
//   particles    m_i = sum_p S_ip m_p,  f_i = -sum_p V_p sigma_p G_ip + external
//   cells        density and stress fitted at the cell centres (quadratic B-spline of support
//                1.5 h): m_i = sum_c rho_c N_i(x_c) V_c,
//                f_i = -sum_c sigma_c grad N_i(x_c) V_c + external (Gong 2015, eq. 5.9-5.14)
//   nodal_cells  density and stress fitted at the nodes, linear between them, integrated over the
//                part of each cell that is filled (Wallstedt, Guilkey 2011)
//   taylor_cells density, momentum and stress as polynomials of each cell that keep its mass and
//                momentum, at Gauss points; cells on the border of a body keep their particles as
//                points of integration (Wobbes et al. 2018)
//   gauss_cells  the same with least squares at the Gauss points (Tran et al. 2019)
//   adjoint_cells  mass and external forces over particles, the stress fitted at the cell centres
//                inside of a body and summed at its border, f_i = -sum_c (sum_p W_cp sigma_p) grad
//                N_i(x_c), and the strain the transpose of that, L_p = sum_c W_cp L_c / sum_c W_cp
//                with L_c = sum_i v_i grad N_i(x_c)^T (transfer/cell_weights.hpp)
enum class Quadrature { particles, cells, nodal_cells, taylor_cells, gauss_cells, adjoint_cells };

// How particles are updated from the nodes, with a_i = f_i / m_i:
//   flip          v_p += k sum_i S a_i,  x_p += dt sum_i S v_i+ ; with Method::blend the part
//                 `blend` of v_p is that of pic, and with Method::blend_rate it goes there at that
//                 rate, 1 / time, so that as much is taken in a time whatever the steps
//   pic           v_p  = sum_i S v_i+ ,  x_p += dt v_p
//   xpic          v_p  = sum_i S (v*_i + k a_i),  v* = sum_{j < m} (1 - S+ S)^j v_i , where S+ S v
//                 is the velocity that goes to the particles and back; m is Method::order
//                 (Hammerquist, Nairn 2017)
//   fmpm          v_p  = sum_i S v*_i with v* of v_i+, also in L (Nairn, Hammerquist 2021)
//   runge_kutta   the rates of flip in the classical four stages, velocities at whole steps
//                 (Edwards, Bridson 2012). Stresses that are not functions of F, those of
//                 LinearElastic, follow from the mean L of the stages
// With leapfrog the velocities of particles are half a step behind their positions, so a single
// velocity serves for the position where the sources take the mean of two.
enum class Update { flip, pic, xpic, fmpm, runge_kutta };

// The mass matrix. lumped: the masses m_i alone. consistent: M_ij = sum_p m_p S_ip S_jp, M v = p
// and M a = f (Andersen, Andersen 2007, eq. 10, 17), solved by sparse Cholesky.
enum class MassMatrix { lumped, consistent };

// From which nodal velocity the velocity gradient L, and with it the stress, is computed:
//   last   from v_i+, at the old place of the particle. What the map removes from a velocity is
//          removed from the strain only in the next step: energy is lost, less with short steps
//   first  from v_i as it is mapped after the step, at the new place: in each step before the
//          forces (Andersen, Andersen 2007, section 3.2). Strain and force are then transposes of
//          each other, and energy oscillates without loss (Bardenhagen 2002). Costs a second map
//   musl   from v_i as it is mapped from the updated velocities, at the old place; particles move
//          with v_i+ still (Sulsky, Zhou, Schreyer 1995). It is a mean of the velocities of
//          particles, so that a node of next to no mass does no harm. Costs a second map
enum class StressUpdate { last, first, musl };

// How long the kick k of the velocities is.
//   leapfrog          half the step before and half this one: velocities are half a step behind
//                     positions, and the start at t = 0 is of second order
//   symplectic_euler  this step, as the papers print it: velocities and positions are given at the
//                     same time, so that a start is of first order. In equal steps the same motion
//                     as leapfrog, from a start that is half a step apart
enum class Scheme { leapfrog, symplectic_euler };

// What is done about a node of negative mass: it stands in MassSigns (nodes.hpp), or a step throws
// Failure.
enum class AtNegativeMass { report, stop };

// The names of the choices, in the order of the enumerators.
template <class Enum>
requires std::is_enum_v<Enum> std::string_view name_of(Enum choice);
template <class Enum>
std::vector<std::string> names_of();

// Kinds of these choices that are treated alike.
inline bool is_element(Basis basis) {
  return basis == Basis::q8 || basis == Basis::q9;
}
inline bool is_fit(VelocityMap map) {
  return map == VelocityMap::mls || map == VelocityMap::imls || map == VelocityMap::cpls;
}
inline bool is_cell(Quadrature quadrature) {
  return quadrature == Quadrature::cells || quadrature == Quadrature::nodal_cells;
}
inline bool is_through_cells(Basis basis) {
  return basis == Basis::cell_linear || basis == Basis::cell_bspline2;
}
inline bool is_gauss(Quadrature quadrature) {
  return quadrature == Quadrature::taylor_cells || quadrature == Quadrature::gauss_cells;
}

struct Method {
  std::string name;
  Domain domain = Domain::point;
  Basis basis = Basis::linear;
  VelocityMap velocity = VelocityMap::mass_weighted;
  Quadrature quadrature = Quadrature::particles;
  Update update = Update::flip;
  std::string source;

  int degree = 1;         // degree of the fits: 1 or 2, with imls up to 3
  int order = 2;          // the order m of xpic and fmpm
  double blend = 0;       // the part of pic in flip, from 0 to 1
  double blend_rate = 0;  // the same as a rate, 1 / time
  MassMatrix mass = MassMatrix::lumped;
  StressUpdate stress = StressUpdate::last;
  Scheme scheme = Scheme::leapfrog;
  SplineBorder border = SplineBorder::corrected;
  bool momentum_correction = false;  // shift fitted v_i so that their momentum is the particles',
                                     // also those of gauss_cells
  AtNegativeMass at_negative_mass = AtNegativeMass::report;

  // Calls each(key, choice) for every choice but name and source. This is the one list of them:
  // needs, problem files, checkpoints and texts use it, in this order.
  template <class Each>
  void choices(Each&& each) {
    list(*this, each);
  }
  template <class Each>
  void choices(Each&& each) const {
    list(*this, each);
  }

  // The kick k of a step dt after one of last_dt, and the time by which velocities are behind the
  // positions after one of last_dt.
  double kick(double last_dt, double dt) const {
    return scheme == Scheme::leapfrog ? (last_dt + dt) / 2 : dt;
  }
  // The part of pic in v_p after a kick.
  double pic_part(double kick) const {
    if (update != Update::flip) return 1;
    return blend_rate == 0 ? blend : 1 - (1 - blend) * std::exp(-blend_rate * kick);
  }
  double velocity_lag(double last_dt) const {
    return update == Update::runge_kutta || scheme != Scheme::leapfrog ? 0 : last_dt / 2;
  }
  // Whether the nodes have the momentum of the particles, up to rounding.
  bool keeps_momentum() const { return !is_fit(velocity) && quadrature != Quadrature::gauss_cells; }
  // Whether light nodes may strain too much, so that L is limited there (step.hpp).
  bool has_light_nodes() const {
    return domain == Domain::point && basis == Basis::linear && mass == MassMatrix::lumped &&
           !is_cell(quadrature) && stress == StressUpdate::last && update != Update::runge_kutta;
  }

  // The default of the step, in units of h / (c_p + |v|).
  double default_courant(int dimension) const;

  // Throws InvalidArgument for choices that do not go together: which one, what it needs, and which
  // other one does not have it.
  void validate(int dimension) const;

 private:
  template <class Self, class Each>
  static void list(Self& of, Each& each) {
    each("domain", of.domain);
    each("basis", of.basis);
    each("velocity", of.velocity);
    each("quadrature", of.quadrature);
    each("update", of.update);
    each("blend", of.blend);
    each("blend_rate", of.blend_rate);
    each("degree", of.degree);
    each("order", of.order);
    each("mass", of.mass);
    each("stress", of.stress);
    each("scheme", of.scheme);
    each("spline_border", of.border);
    each("momentum_correction", of.momentum_correction);
    each("negative_mass", of.at_negative_mass);
  }
};

// All methods of the table.
std::span<const Method> methods();
// Throws InvalidArgument for an unknown name, with the nearest valid ones.
const Method& method_named(std::string_view name);

// Calls work(policy) with the policy of the method's domain and basis.
template <class Work>
decltype(auto) with_shape(const Method& method, Work&& work) {
  if (method.domain == Domain::ugimp) return work(UniformGimp{});
  if (method.domain == Domain::cpgimp) return work(StretchedGimp{});
  if (method.domain == Domain::cpdi1) return work(Cpdi1{});
  if (method.domain == Domain::cpdi2) return work(Cpdi2{});
  if (method.basis == Basis::q8) return work(PointShape<EightNodeFunctions>{});
  if (method.basis == Basis::q9) return work(PointShape<NineNodeFunctions>{});
  if (method.basis == Basis::bspline2)
    return work(PointShape<SplineFunctions<2>>{{{method.border}}});
  if (method.basis == Basis::bspline3)
    return work(PointShape<SplineFunctions<3>>{{{method.border}}});
  if (method.basis == Basis::mls_bspline2)
    return work(PointShape<MomentSplineFunctions>{{{{method.border}}}});
  if (method.basis == Basis::cell_linear)
    return work(PointShape<CellFunctions<1>>{{{method.border}}});
  if (method.basis == Basis::cell_bspline2)
    return work(PointShape<CellFunctions<2>>{{{method.border}}});
  return work(PointShape<LinearFunctions>{});
}

}  // namespace recon::mpm
