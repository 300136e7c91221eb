// A method is a choice of policies; every method of the literature is one row of a table.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "recon/mpm/shapes.hpp"

namespace recon::mpm {

// What a particle is (transfer/domain_functions.hpp), and with which functions it sees the grid
// (transfer/point_functions.hpp). Domains other than the point need the linear basis. mls_bspline2
// is bspline2 with the gradients of MLS-MPM (Hu et al. 2018).
enum class Domain { point, ugimp, cpgimp, cpdi1, cpdi2 };
enum class Basis { linear, q8, q9, bspline2, bspline3, mls_bspline2 };

// How the velocities v_i at the nodes follow from those of the particles, with d = x_i - x_p:
//   mass_weighted  sum_p S_ip m_p v_p / m_i, which is Shepard's with the weight m_p S_ip
//   mls            moving least squares, tensor cubic B-spline of support 2 h, moments on the grid
//   imls           the same by graded Gram-Schmidt with neighbour lists; degree up to 3
//   cpls           imls from particles and the corners of their domains,
//                  v_c = v_p + L_p (x_c - x_p)
//   taylor         sum_p S_ip m_p (v_p + L_p d) / m_i (Wallstedt, Guilkey 2007)
//   affine         sum_p S_ip m_p (v_p + C_p d) / m_i with C_p = B_p D_p^-1 of the step before, B_p
//                  and D_p the sums of S_ip v_i d^T and of S_ip d d^T (Jiang et al. 2015)
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
enum class Quadrature { particles, cells, nodal_cells, taylor_cells, gauss_cells };

// How particles are updated from the nodes, with a_i = f_i / m_i:
//   flip          v_p += k sum_i S a_i,  x_p += dt sum_i S v_i+
//   pic           v_p  = sum_i S v_i+ ,  x_p += dt v_p
//   xpic          v_p  = sum_i S (v*_i + k a_i),  v* = sum_{j < m} (1 - S+ S)^j v_i , where S+ S v
//                 is the velocity that goes to the particles and back; m is Method::order
//                 (Hammerquist, Nairn 2017)
//   fmpm          v_p  = sum_i S v*_i with v* of v_i+, also in L (Nairn, Hammerquist 2021)
//   runge_kutta   the rates of flip in the classical four stages, velocities at whole steps
//                 (Edwards, Bridson 2012). Stresses that are not functions of F, those of
//                 LinearElastic, follow from the mean L of the stages
// The velocities of particles are half a step behind their positions, so a single velocity serves
// for the position where the sources take the mean of two.
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
enum class StressUpdate { last, first };

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

  int degree = 1;  // degree of the fits: 1 or 2, with imls up to 3
  int order = 2;   // the order m of xpic and fmpm
  MassMatrix mass = MassMatrix::lumped;
  StressUpdate stress = StressUpdate::last;
  SplineBorder border = SplineBorder::corrected;
  bool momentum_correction = false;    // shift fitted v_i so that their momentum is the particles',
                                       // also those of gauss_cells
  bool stop_at_negative_mass = false;  // else it is reported: Simulation::negative_mass()

  // Steps in units of h / (c_p + |v|): the longest with which small noise does not grow, for two
  // particles per cell and axis (docs/mpm.md has the measurement), and the default.
  double stable_courant(int dimension) const;
  double default_courant(int dimension) const;
  // A sentence about what breaks the method whatever the step is: always for elements, whose
  // functions are negative in parts, and at free surfaces for quadrature over cells. Empty where
  // nothing is known.
  std::string caveat() const;

  // Throws InvalidArgument for choices that do not go together, saying why.
  void validate(int dimension) const;
};

// All methods of the table.
std::span<const Method> methods();
// Throws InvalidArgument for an unknown name, with the nearest valid ones.
const Method& method_named(std::string_view name);

std::string_view name_of(Domain domain);
std::string_view name_of(Basis basis);
std::string_view name_of(VelocityMap map);
std::string_view name_of(Quadrature quadrature);
std::string_view name_of(Update update);
std::string_view name_of(MassMatrix mass);
std::string_view name_of(StressUpdate stress);

// Calls work(policy) with the policy of the method's domain and basis.
template <class Work>
decltype(auto) with_shape(const Method& method, Work&& work) {
  switch (method.domain) {
    case Domain::ugimp:
      return work(UniformGimp{});
    case Domain::cpgimp:
      return work(StretchedGimp{});
    case Domain::cpdi1:
      return work(Cpdi1{});
    case Domain::cpdi2:
      return work(Cpdi2{});
    case Domain::point:
      break;
  }
  switch (method.basis) {
    case Basis::q8:
      return work(PointShape<EightNodeFunctions>{});
    case Basis::q9:
      return work(PointShape<NineNodeFunctions>{});
    case Basis::bspline2:
      return work(PointShape<SplineFunctions<2>>{{{method.border}}});
    case Basis::bspline3:
      return work(PointShape<SplineFunctions<3>>{{{method.border}}});
    case Basis::mls_bspline2:
      return work(PointShape<MomentSplineFunctions>{{{{method.border}}}});
    case Basis::linear:
      break;
  }
  return work(PointShape<LinearFunctions>{});
}

}  // namespace recon::mpm
