#include "recon/mpm/method.hpp"

#include <cmath>

#include "recon/core/names.hpp"

namespace recon::mpm {

namespace {
using recon::detail::require;
}  // namespace

std::span<const Method> methods() {
  using enum Domain;
  using enum VelocityMap;
  using enum Quadrature;
  using enum Update;
  using enum Basis;
  constexpr Domain box = ugimp;
  static const std::vector<Method> table{
      {"mpm", point, linear, mass_weighted, particles, flip, "Sulsky, Chen, Schreyer 1994"},
      {"ugimp", ugimp, linear, mass_weighted, particles, flip, "Bardenhagen, Kober 2004"},
      {"cpgimp", cpgimp, linear, mass_weighted, particles, flip, "Bardenhagen, Kober 2004"},
      {"cpdi1", cpdi1, linear, mass_weighted, particles, flip,
       "Sadeghirad, Brannon, Burghardt 2011"},
      {"cpdi2", cpdi2, linear, mass_weighted, particles, flip, "Sadeghirad, Brannon, Guilkey 2013"},
      {"q8", point, q8, mass_weighted, particles, flip, "Andersen, Andersen 2007"},
      {"q9", point, q9, mass_weighted, particles, flip, "Andersen, Andersen 2007"},
      {"bspline2", point, bspline2, mass_weighted, particles, flip, "Steffen, Kirby, Berzins 2008"},
      {"bspline3", point, bspline3, mass_weighted, particles, flip, "Andersen, Andersen 2007"},
      {"impm", point, linear, mls, cells, flip, "Gong 2015, chapter 5"},
      {"improved_cpdi", cpdi2, linear, mls, particles, flip, "Gong 2015, section 6.6"},
      {"imls_mpm", point, linear, imls, particles, flip, "Tran, Berzins, Solowski 2019"},
      {"cpls", cpdi1, linear, cpls, particles, flip, "Tran, Solowski, Berzins, Guilkey 2019"},
      {"wls", point, linear, mls, nodal_cells, flip, "Wallstedt, Guilkey 2011"},
      {"tls", point, bspline3, mass_weighted, taylor_cells, flip,
       "Wobbes, Moller, Galavi, Vuik 2018"},
      {"bspline_mls", point, bspline3, mass_weighted, gauss_cells, flip,
       "Tran, Wobbes, Solowski, Moller, Vuik 2019"},
      {.name = "hopic",
       .velocity = imls,
       .quadrature = cells,
       .update = runge_kutta,
       .source = "Edwards, Bridson 2012",
       .degree = 3},
      {"improved_projection", box, linear, taylor, particles, flip, "Wallstedt, Guilkey 2007"},
      {"tpic", point, bspline2, taylor, particles, pic, "Nakamura, Matsumura, Mizutani 2023"},
      {"apic", point, bspline2, affine, particles, pic, "Jiang et al. 2015"},
      {"mls_mpm", point, mls_bspline2, affine, particles, pic, "Hu et al. 2018"},
      {"polypic", point, bspline2, polynomial, particles, pic, "Fu et al. 2017"},
      {"xpic", box, linear, mass_weighted, particles, xpic, "Hammerquist, Nairn 2017"},
      {.name = "fmpm",
       .domain = box,
       .update = fmpm,
       .source = "Nairn, Hammerquist 2021",
       .order = 4},
  };
  return table;
}

const Method& method_named(std::string_view name) {
  std::vector<std::string> names;
  for (const Method& method : methods()) {
    if (method.name == name) return method;
    names.push_back(method.name);
  }
  recon::detail::throw_invalid("method", name, "is unknown; " + suggest(name, names));
}

void Method::validate(int dimension) const {
  const bool cell_fits = is_cell(quadrature), gauss = is_gauss(quadrature);
  const bool elements = is_element(basis), fitted = is_fit(velocity);
  const bool remembers = velocity == VelocityMap::affine || velocity == VelocityMap::polynomial;
  const int highest = velocity == VelocityMap::imls ? 3 : 2;
  require(degree >= 1 && degree <= highest, "degree of the method", degree,
          highest == 3 ? "must be 1, 2 or 3" : "must be 1 or 2; 3 needs the velocity map imls");
  require(order >= 1 && order <= 1000, "order of the method", order, "must be from 1 to 1000");
  require(domain == Domain::point || basis == Basis::linear, "basis of the method", name_of(basis),
          "needs point particles: domains are averages of linear functions");
  require(basis != Basis::q8 || dimension == 2, "basis of the method", "q8",
          "is for 2-D; q9 is for any dimension");
  require(!cell_fits || basis == Basis::linear, "basis of the method", name_of(basis),
          "does not go with quadrature over cell centres or nodes, which is for linear functions");
  require(!gauss || (domain == Domain::point && !elements && basis != Basis::mls_bspline2),
          "quadrature of the method", name_of(quadrature),
          "is for point particles in a linear or spline basis");
  require(!gauss || velocity == VelocityMap::mass_weighted, "velocity map of the method",
          name_of(velocity), "does not go with a quadrature that reconstructs momentum itself");
  require(!remembers || (domain == Domain::point && !elements), "velocity map of the method",
          name_of(velocity),
          "needs point particles and functions that are positive products: linear or splines");
  require(!remembers || update == Update::pic, "update of the method", name_of(update),
          "does not leave what affine and polynomial maps remember; pic does");
  require(!cell_fits || domain == Domain::point, "quadrature of the method", name_of(quadrature),
          "needs point particles: domains reach nodes that have no mass from the cells");
  require(!cell_fits || fitted, "velocity map of the method", name_of(velocity),
          "divides the momentum of particles by the mass of cells, which is another: mls, imls and "
          "cpls do not");
  require(quadrature == Quadrature::particles || (update != Update::xpic && update != Update::fmpm),
          "update of the method", name_of(update),
          "divides by the mass of particles: the quadrature must be over them");
  require(mass == MassMatrix::lumped || (!cell_fits && !fitted), "mass matrix of the method",
          "consistent", "is for mass-weighted velocities and mass from particles or Gauss points");
  require(mass == MassMatrix::lumped || update == Update::flip || update == Update::pic,
          "update of the method", name_of(update), "is for lumped mass");
  require(stress == StressUpdate::last || update == Update::flip, "update of the method",
          name_of(update), "has its own order of the stress: stress first is for flip");
  require(update != Update::runge_kutta || domain != Domain::cpdi2, "update of the method",
          name_of(update), "does not move the corners of cpdi2; cpdi1 has none to move");
}

// The least of what is measured in docs/mpm.md, for groups of methods. A consistent mass is lighter
// in short waves, by 3 on each axis with linear functions; FMPM(m) multiplies accelerations of what
// particles do not see by m, so that its step is sqrt(m) times shorter where that is excited.
double Method::stable_courant(int dimension) const {
  if (basis == Basis::q8) return 0;
  if (basis == Basis::q9) return 0.55;
  if (mass == MassMatrix::consistent) return dimension == 1 ? 0.49 : dimension == 2 ? 0.41 : 0.35;
  if (update == Update::fmpm) return 0.75 / std::sqrt(order);
  if (is_cell(quadrature) || (domain == Domain::point && basis != Basis::linear)) return 0.85;
  return 0.7;
}

double Method::default_courant(int) const {
  if (update == Update::fmpm) return 0.4 / std::sqrt(order);
  return mass == MassMatrix::consistent ? 0.3 : 0.4;
}

std::string Method::caveat() const {
  if (is_element(basis))
    return "functions of " + std::string(name_of(basis)) +
           " are negative in parts: a body breaks where the mass of a node passes through zero";
  if (quadrature == Quadrature::nodal_cells && degree == 2)
    return "quadrature over nodal cells with fits of degree 2 gains energy on fine grids";
  if (is_cell(quadrature) && degree == 3) return "cubic fits at free surfaces break the body";
  if (is_cell(quadrature))
    return "quadrature over cells gains energy at free surfaces, the more the shorter the step";
  return "";
}

namespace {
template <std::size_t count, class Enum>
std::string_view name_in(const std::string_view (&names)[count], Enum value) {
  return names[static_cast<std::size_t>(value)];
}
}  // namespace

std::string_view name_of(Domain domain) {
  return name_in({"point", "ugimp", "cpgimp", "cpdi1", "cpdi2"}, domain);
}
std::string_view name_of(Basis basis) {
  return name_in({"linear", "q8", "q9", "bspline2", "bspline3", "mls_bspline2"}, basis);
}
std::string_view name_of(VelocityMap map) {
  return name_in({"mass_weighted", "mls", "imls", "cpls", "taylor", "affine", "polynomial"}, map);
}
std::string_view name_of(Quadrature quadrature) {
  return name_in({"particles", "cells", "nodal_cells", "taylor_cells", "gauss_cells"}, quadrature);
}
std::string_view name_of(Update update) {
  return name_in({"flip", "pic", "xpic", "fmpm", "runge_kutta"}, update);
}
std::string_view name_of(MassMatrix mass) {
  return name_in({"lumped", "consistent"}, mass);
}
std::string_view name_of(StressUpdate stress) {
  return name_in({"last", "first"}, stress);
}

}  // namespace recon::mpm
