#include "recon/mpm/method.hpp"

#include <array>
#include <cmath>

#include "recon/core/names.hpp"

namespace recon::mpm {

namespace {

using recon::detail::require;

// What a choice may need of the others: how it is told, which choice meets it or not, and whether a
// method does.
struct Need {
  const char* text;
  const char* key;
  bool (*met)(const Method&, int dimension);
};
constexpr Need linear_basis{"linear functions of the grid", "basis",
                            [](const Method& m, int) { return m.basis == Basis::linear; }};
constexpr Need point_domain{"point particles: domains reach beyond the cells that it is about",
                            "domain",
                            [](const Method& m, int) { return m.domain == Domain::point; }};
constexpr Need positive{"functions that are nowhere negative: linear ones or splines", "basis",
                        [](const Method& m, int) { return !is_element(m.basis); }};
constexpr Need products{"functions that are products of those of the axes: point particles",
                        "domain", [](const Method& m, int) { return m.domain == Domain::point; }};
constexpr Need own_gradients{"gradients that are those of the functions: a linear or spline basis",
                             "basis", [](const Method& m, int) {
                               return m.basis != Basis::mls_bspline2 && !is_through_cells(m.basis);
                             }};
constexpr Need every_node{"functions that see every nodal value: not means over cells", "basis",
                          [](const Method& m, int) { return !is_through_cells(m.basis); }};
constexpr Need through_cells{"functions through the cells: cell_linear or cell_bspline2", "basis",
                             [](const Method& m, int) { return is_through_cells(m.basis); }};
constexpr Need whole_cells{
    "splines up to the faces: corrected or extra_column", "spline_border",
    [](const Method& m, int) { return m.border != SplineBorder::linear_cells; }};
constexpr Need plane{"a problem in 2-D; q9 is for any dimension", "",
                     [](const Method&, int dimension) { return dimension == 2; }};
constexpr Need particle_mass{
    "nodes with the mass of the particles: quadrature over them", "quadrature",
    [](const Method& m, int) { return m.quadrature == Quadrature::particles; }};
constexpr Need same_points{
    "momentum and mass from the same points, not momentum of particles and mass of cells: mls, "
    "imls and cpls do without",
    "quadrature", [](const Method& m, int) { return !is_cell(m.quadrature); }};
constexpr Need particle_momentum{
    "momentum from the particles, not one that the quadrature reconstructs", "quadrature",
    [](const Method& m, int) { return !is_gauss(m.quadrature); }};
constexpr Need mass_weighted{"mass-weighted velocities, no fit", "velocity",
                             [](const Method& m, int) { return !is_fit(m.velocity); }};
constexpr Need lumped{"lumped mass", "mass",
                      [](const Method& m, int) { return m.mass == MassMatrix::lumped; }};
constexpr Need single_map{"an update that maps once a step", "update",
                          [](const Method& m, int) { return m.update != Update::runge_kutta; }};
constexpr Need own_velocity{
    "an update that takes the nodes' own velocity: flip or pic", "update",
    [](const Method& m, int) { return m.update == Update::flip || m.update == Update::pic; }};
constexpr Need no_corners{"a domain without corners that move with the grid", "domain",
                          [](const Method& m, int) { return m.domain != Domain::cpdi2; }};
constexpr Need flip_update{"the update flip, of which pic is a part then", "update",
                           [](const Method& m, int) { return m.update == Update::flip; }};

using Needs = std::array<const Need*, 5>;

// What may be chosen, and what it needs, in the order of the enumerators.
struct Choice {
  std::string_view name;
  Needs needs{};
};
template <class Enum>
constexpr int choices = 0;
template <>
constexpr Choice choices<Domain>[] = {{"point"},
                                      {"ugimp", {&linear_basis}},
                                      {"cpgimp", {&linear_basis}},
                                      {"cpdi1", {&linear_basis}},
                                      {"cpdi2", {&linear_basis}}};
template <>
constexpr Choice choices<Basis>[] = {{"linear"},      {"q8", {&plane}}, {"q9"},
                                     {"bspline2"},    {"bspline3"},     {"mls_bspline2"},
                                     {"cell_linear"}, {"cell_bspline2"}};
template <>
constexpr Choice choices<VelocityMap>[] = {
    {"mass_weighted", {&same_points}},
    {"mls", {&particle_momentum}},
    {"imls", {&particle_momentum}},
    {"cpls", {&particle_momentum}},
    {"taylor", {&same_points, &particle_momentum}},
    {"affine", {&positive, &same_points, &particle_momentum, &own_velocity}},
    {"polynomial", {&positive, &products, &same_points, &particle_momentum, &own_velocity}},
};
template <>
constexpr Choice choices<Quadrature>[] = {
    {"particles"},
    {"cells", {&linear_basis, &point_domain}},
    {"nodal_cells", {&linear_basis, &point_domain}},
    {"taylor_cells", {&point_domain, &positive, &own_gradients}},
    {"gauss_cells", {&point_domain, &positive, &own_gradients}},
    {"adjoint_cells", {&through_cells, &whole_cells}},
};
template <>
constexpr Choice choices<Update>[] = {{"flip"},
                                      {"pic"},
                                      {"xpic", {&particle_mass, &lumped}},
                                      {"fmpm", {&particle_mass, &lumped}},
                                      {"runge_kutta", {&lumped, &no_corners}}};
template <>
constexpr Choice choices<MassMatrix>[] = {
    {"lumped"}, {"consistent", {&same_points, &mass_weighted, &every_node}}};
template <>
constexpr Choice choices<StressUpdate>[] = {
    {"last"}, {"first", {&own_velocity}}, {"musl", {&own_velocity}}};
template <>
constexpr Choice choices<Scheme>[] = {{"leapfrog"}, {"symplectic_euler", {&single_map}}};
template <>
constexpr Choice choices<SplineBorder>[] = {{"corrected"}, {"extra_column"}, {"linear_cells"}};
template <>
constexpr Choice choices<AtNegativeMass>[] = {{"report"}, {"stop"}};

template <class T>
Needs needs_of(T value) {
  if constexpr (std::is_enum_v<T>) return choices<T>[static_cast<std::size_t>(value)].needs;
  return {};
}

}  // namespace

template <class Enum>
requires std::is_enum_v<Enum> std::string_view name_of(Enum choice) {
  return choices<Enum>[static_cast<std::size_t>(choice)].name;
}

template <class Enum>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const Choice& each : choices<Enum>) names.emplace_back(each.name);
  return names;
}

void Method::validate(int dimension) const {
  const int highest = velocity == VelocityMap::imls ? 3 : 2;
  require(degree >= 1 && degree <= highest, "degree of the method", degree,
          highest == 3 ? "must be 1, 2 or 3" : "must be 1 or 2; 3 needs the velocity map imls");
  require(order >= 1 && order <= 1000, "order of the method", order, "must be from 1 to 1000");
  require(blend >= 0 && blend <= 1, "blend of the method", blend, "must be from 0 to 1");
  require(blend_rate >= 0 && std::isfinite(blend_rate), "blend_rate of the method", blend_rate,
          "must be finite and not negative");
  choices([&](const std::string& key, auto value) {
    Needs needs = needs_of(value);
    if ((key == "blend" && blend != 0) || (key == "blend_rate" && blend_rate != 0))
      needs = {&flip_update};
    for (const Need* need : needs) {
      if (!need || need->met(*this, dimension)) continue;
      std::string rule = std::string("needs ") + need->text;
      choices([&](const std::string& other, auto chosen) {
        if constexpr (std::is_enum_v<decltype(chosen)>)
          if (other == need->key) rule += "; " + other + " is " + std::string(name_of(chosen));
      });
      if constexpr (std::is_enum_v<decltype(value)>)
        recon::detail::throw_invalid(key + " of the method", name_of(value), rule);
      else
        recon::detail::throw_invalid(key + " of the method", value, rule);
    }
  });
}

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
      {.name = "affine_cpdi",
       .domain = cpdi1,
       .velocity = affine,
       .source = "after Wallstedt, Guilkey 2007; Jiang et al. 2015; Fei et al. 2021",
       .blend = 0.05},
      {.name = "affine_cpdi2",
       .domain = cpdi2,
       .velocity = affine,
       .source = "after Wallstedt, Guilkey 2007; Jiang et al. 2015; Fei et al. 2021",
       .blend = 0.05},
      {"sgmp", point, cell_linear, mass_weighted, particles, flip, "Liang, Zhang, Liu 2019"},
      {"impm_adjoint", point, cell_bspline2, affine, adjoint_cells, flip,
       "after Gong 2015, chapter 5; Liang, Zhang, Liu 2019"},
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

// A consistent mass is lighter in short waves, by 3 on each axis with linear functions; FMPM(m)
// multiplies accelerations of what particles do not see by m, so that its step is sqrt(m) times
// shorter where that is excited. Cubic fits bear shorter steps in 3-D. Half of what is measured
// (docs/mpm.md).
double Method::default_courant(int dimension) const {
  if (is_cell(quadrature) && degree == 3 && dimension == 3) return 0.15;
  if (update == Update::fmpm) return 0.4 / std::sqrt(order);
  return mass == MassMatrix::consistent ? 0.3 : 0.4;
}

#define RECON_INSTANTIATE(Enum)                  \
  template std::string_view name_of<Enum>(Enum); \
  template std::vector<std::string> names_of<Enum>();
RECON_INSTANTIATE(Domain)
RECON_INSTANTIATE(Basis)
RECON_INSTANTIATE(VelocityMap)
RECON_INSTANTIATE(Quadrature)
RECON_INSTANTIATE(Update)
RECON_INSTANTIATE(MassMatrix)
RECON_INSTANTIATE(StressUpdate)
RECON_INSTANTIATE(Scheme)
RECON_INSTANTIATE(SplineBorder)
RECON_INSTANTIATE(AtNegativeMass)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
