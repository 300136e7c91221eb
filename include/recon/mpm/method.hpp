// A method is a choice of policies; every method of the literature is one row of a table.
//
// Sources: Sulsky, Chen, Schreyer 1994 (mpm); Bardenhagen, Kober 2004 (ugimp, cpgimp); Sadeghirad,
// Brannon, Burghardt 2011 and Sadeghirad, Brannon, Guilkey 2013 (cpdi1, cpdi2); Gong 2015 (impm ch.
// 5, improved_cpdi sec. 6.6); Tran, Solowski, Berzins, Guilkey 2019 (imls_mpm, cpls).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "recon/mpm/domains.hpp"

namespace recon::mpm {

enum class Domain { point, ugimp, cpgimp, cpdi1, cpdi2 };

// v_i at the nodes from v_p:
//   mass_weighted  sum_p S_ip m_p v_p / m_i, which is Shepard's with the weight m_p S_ip
//   mls            moving least squares, tensor cubic B-spline of support 2 h, moments on the grid
//   imls           the same by graded Gram-Schmidt with neighbour lists
//   cpls           imls from particles and the corners of their domains, v_c = v_p + L_p (x_c -
//   x_p)
enum class VelocityMap { mass_weighted, mls, imls, cpls };

// Mass and forces of the nodes:
//   particles  m_i = sum_p S_ip m_p,  f_i = -sum_p V_p sigma_p G_ip + external
//   cells      density and stress fitted at the cell centres (quadratic B-spline of support 1.5 h):
//              m_i = sum_c rho_c N_i(x_c) V_c,  f_i = -sum_c sigma_c grad N_i(x_c) V_c + external
//              (Gong 2015, eq. 5.9-5.14)
enum class Quadrature { particles, cells };

struct Method {
  std::string name;
  Domain domain = Domain::point;
  VelocityMap velocity = VelocityMap::mass_weighted;
  Quadrature quadrature = Quadrature::particles;
  std::string source;

  int degree = 1;                    // of the fits: 1 or 2
  bool momentum_correction = false;  // shift fitted v_i so that their momentum is the particles'
};

// All rows.
std::span<const Method> methods();
// Throws InvalidArgument for a name that is not there, with the nearest ones that are.
const Method& method_named(std::string_view name);

std::string_view name_of(Domain domain);
std::string_view name_of(VelocityMap map);
std::string_view name_of(Quadrature quadrature);

// Calls work(policy) with the policy of a domain.
template <class Work>
decltype(auto) with_domain(Domain domain, Work&& work) {
  switch (domain) {
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
  return work(PointDomain{});
}

}  // namespace recon::mpm
