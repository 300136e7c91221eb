#include "recon/mpm/method.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "recon/core/names.hpp"

namespace recon::mpm {

namespace {

using recon::detail::require;

// What a choice may need of the others.
enum Property : unsigned {
  linear_basis = 1,
  point_domain = 2,
  positive = 4,
  products = 8,
  own_gradients = 16,
  plane = 32,
  particle_mass = 64,
  same_points = 128,
  particle_momentum = 256,
  mass_weighted = 512,
  lumped = 1024,
  single_map = 2048,
  own_velocity = 4096,
  no_corners = 8192,
  flip_update = 16384,
};

// How a need is told, which choice meets it or not, and whether a method does.
struct Rule {
  Property property;
  const char* text;
  const char* key;
  bool (*met)(const Method&, int dimension);
};
const Rule rules[] = {
    {linear_basis, "linear functions of the grid", "basis",
     [](const Method& m, int) { return m.basis == Basis::linear; }},
    {point_domain, "point particles: domains reach beyond the cells that it is about", "domain",
     [](const Method& m, int) { return m.domain == Domain::point; }},
    {positive, "functions that are nowhere negative: linear ones or splines", "basis",
     [](const Method& m, int) { return !is_element(m.basis); }},
    {products, "functions that are products of those of the axes: point particles", "domain",
     [](const Method& m, int) { return m.domain == Domain::point; }},
    {own_gradients, "gradients that are those of the functions: a linear or spline basis", "basis",
     [](const Method& m, int) { return m.basis != Basis::mls_bspline2; }},
    {plane, "a problem in 2-D; q9 is for any dimension", "",
     [](const Method&, int dimension) { return dimension == 2; }},
    {particle_mass, "nodes with the mass of the particles: quadrature over them", "quadrature",
     [](const Method& m, int) { return m.quadrature == Quadrature::particles; }},
    {same_points,
     "momentum and mass from the same points, not momentum of particles and mass of cells: mls, "
     "imls and cpls do without",
     "quadrature", [](const Method& m, int) { return !is_cell(m.quadrature); }},
    {particle_momentum, "momentum from the particles, not one that the quadrature reconstructs",
     "quadrature", [](const Method& m, int) { return !is_gauss(m.quadrature); }},
    {mass_weighted, "mass-weighted velocities, no fit", "velocity",
     [](const Method& m, int) { return !is_fit(m.velocity); }},
    {lumped, "lumped mass", "mass",
     [](const Method& m, int) { return m.mass == MassMatrix::lumped; }},
    {single_map, "an update that maps once a step", "update",
     [](const Method& m, int) { return m.update != Update::runge_kutta; }},
    {own_velocity, "an update that takes the nodes' own velocity: flip or pic", "update",
     [](const Method& m, int) { return m.update == Update::flip || m.update == Update::pic; }},
    {no_corners, "a domain without corners that move with the grid", "domain",
     [](const Method& m, int) { return m.domain != Domain::cpdi2; }},
    {flip_update, "the update flip, of which pic is a part then", "update",
     [](const Method& m, int) { return m.update == Update::flip; }},
};

// What may be chosen for a key, and what it needs. The order is that of the enumerators.
struct Choice {
  std::string_view name;
  unsigned needs = 0;
};
constexpr unsigned of_moments = same_points | particle_momentum;
constexpr Choice domains[] = {{"point"},
                              {"ugimp", linear_basis},
                              {"cpgimp", linear_basis},
                              {"cpdi1", linear_basis},
                              {"cpdi2", linear_basis}};
constexpr Choice bases[] = {{"linear"},   {"q8", plane}, {"q9"},
                            {"bspline2"}, {"bspline3"},  {"mls_bspline2"}};
constexpr Choice velocities[] = {
    {"mass_weighted", same_points},
    {"mls", particle_momentum},
    {"imls", particle_momentum},
    {"cpls", particle_momentum},
    {"taylor", of_moments},
    {"affine", of_moments | positive | own_velocity},
    {"polynomial", of_moments | positive | products | own_velocity},
};
constexpr Choice quadratures[] = {
    {"particles"},
    {"cells", linear_basis | point_domain},
    {"nodal_cells", linear_basis | point_domain},
    {"taylor_cells", point_domain | positive | own_gradients},
    {"gauss_cells", point_domain | positive | own_gradients},
};
constexpr Choice updates[] = {{"flip"},
                              {"pic"},
                              {"xpic", particle_mass | lumped},
                              {"fmpm", particle_mass | lumped},
                              {"runge_kutta", lumped | no_corners}};
constexpr Choice masses[] = {{"lumped"}, {"consistent", same_points | mass_weighted}};
constexpr Choice stresses[] = {{"last"}, {"first", own_velocity}, {"musl", own_velocity}};
constexpr Choice schemes[] = {{"leapfrog"}, {"symplectic_euler", single_map}};
constexpr Choice borders[] = {{"corrected"}, {"extra_column"}, {"linear_cells"}};
constexpr Choice negatives[] = {{"report"}, {"stop"}};

template <auto member>
MethodKey key(MethodKey::Kind kind, const char* name, std::span<const Choice> choices = {}) {
  using Value = std::remove_reference_t<decltype(std::declval<Method&>().*member)>;
  MethodKey made{kind,
                 name,
                 {},
                 [](const Method& m) { return static_cast<double>(m.*member); },
                 [](Method& m, double value) {
                   if constexpr (std::is_enum_v<Value>)
                     m.*member = static_cast<Value>(static_cast<int>(value));
                   else
                     m.*member = static_cast<Value>(value);
                 }};
  for (const Choice& choice : choices) made.words.emplace_back(choice.name);
  return made;
}

// The needs of the choice that a method makes for a key.
unsigned needs_of(const Method& m, std::string_view key) {
  const auto at = [](const auto& choices, auto value) {
    return choices[static_cast<std::size_t>(value)].needs;
  };
  if (key == "domain") return at(domains, m.domain);
  if (key == "basis") return at(bases, m.basis);
  if (key == "velocity") return at(velocities, m.velocity);
  if (key == "quadrature") return at(quadratures, m.quadrature);
  if (key == "update") return at(updates, m.update);
  if (key == "mass") return at(masses, m.mass);
  if (key == "stress") return at(stresses, m.stress);
  if (key == "scheme") return at(schemes, m.scheme);
  if (key == "blend" && m.blend != 0) return flip_update;
  return 0;
}

const MethodKey& key_named(std::string_view name) {
  std::vector<std::string> names;
  for (const MethodKey& each : method_keys()) {
    if (each.name == name) return each;
    names.push_back(each.name);
  }
  recon::detail::throw_invalid("choice of a method", name, "is unknown; " + suggest(name, names));
}

std::string number_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

template <class Enum>
std::string_view word(std::span<const Choice> choices, Enum value) {
  return choices[static_cast<std::size_t>(value)].name;
}

}  // namespace

std::span<const MethodKey> method_keys() {
  using enum MethodKey::Kind;
  static const std::vector<MethodKey> keys{
      key<&Method::domain>(MethodKey::Kind::word, "domain", domains),
      key<&Method::basis>(MethodKey::Kind::word, "basis", bases),
      key<&Method::velocity>(MethodKey::Kind::word, "velocity", velocities),
      key<&Method::quadrature>(MethodKey::Kind::word, "quadrature", quadratures),
      key<&Method::update>(MethodKey::Kind::word, "update", updates),
      key<&Method::blend>(number, "blend"),
      key<&Method::degree>(integer, "degree"),
      key<&Method::order>(integer, "order"),
      key<&Method::mass>(MethodKey::Kind::word, "mass", masses),
      key<&Method::stress>(MethodKey::Kind::word, "stress", stresses),
      key<&Method::scheme>(MethodKey::Kind::word, "scheme", schemes),
      key<&Method::border>(MethodKey::Kind::word, "spline_border", borders),
      key<&Method::momentum_correction>(flag, "momentum_correction"),
      key<&Method::stop_at_negative_mass>(MethodKey::Kind::word, "negative_mass", negatives),
  };
  return keys;
}

void Method::set(std::string_view key, std::string_view value) {
  const MethodKey& of = key_named(key);
  const auto refuse = [&](const std::string& rule) {
    recon::detail::throw_invalid(std::string(key) + " of the method", value, rule);
  };
  if (of.kind == MethodKey::Kind::word || of.kind == MethodKey::Kind::flag) {
    const std::vector<std::string> words =
        of.kind == MethodKey::Kind::flag ? std::vector<std::string>{"false", "true"} : of.words;
    const auto found = std::find(words.begin(), words.end(), value);
    if (found == words.end()) refuse("is unknown; " + suggest(value, words));
    return of.set(*this, static_cast<double>(found - words.begin()));
  }
  double number = 0;
  const auto end = std::from_chars(value.data(), value.data() + value.size(), number);
  if (end.ec != std::errc() || end.ptr != value.data() + value.size() || !std::isfinite(number))
    refuse("must be a number");
  if (of.kind == MethodKey::Kind::integer &&
      !(std::abs(number) < 1e6 && number == std::floor(number)))
    refuse("must be a whole number");
  of.set(*this, number);
}

std::string Method::get(std::string_view key) const {
  const MethodKey& of = key_named(key);
  const double value = of.get(*this);
  if (of.kind == MethodKey::Kind::word) return of.words[static_cast<std::size_t>(value)];
  if (of.kind == MethodKey::Kind::flag) return value != 0 ? "true" : "false";
  return number_text(value);
}

Method composed(std::string_view text) {
  const std::size_t end = std::min(text.find('+'), text.size());
  Method method = method_named(text.substr(0, end));
  for (std::size_t at = end; at < text.size();) {
    const std::size_t stop = std::min(text.find('+', at + 1), text.size());
    const std::string_view part = text.substr(at + 1, stop - at - 1);
    at = stop;
    const std::size_t equals = part.find('=');
    if (equals != std::string_view::npos) {
      method.set(part.substr(0, equals), part.substr(equals + 1));
      continue;
    }
    std::vector<std::string> known;
    std::vector<std::string> of;
    for (const MethodKey& key : method_keys())
      for (const std::string& word : key.words) {
        known.push_back(word);
        if (word == part) of.push_back(key.name);
      }
    if (of.size() != 1)
      recon::detail::throw_invalid(
          "choice of a method", part,
          of.empty() ? "is no word of a key; " + suggest(part, known)
                     : "is a word of several keys: say which, KEY=" + std::string(part));
    method.set(of.front(), part);
  }
  method.name = text;
  return method;
}

void Method::validate(int dimension) const {
  const int highest = velocity == VelocityMap::imls ? 3 : 2;
  require(degree >= 1 && degree <= highest, "degree of the method", degree,
          highest == 3 ? "must be 1, 2 or 3" : "must be 1 or 2; 3 needs the velocity map imls");
  require(order >= 1 && order <= 1000, "order of the method", order, "must be from 1 to 1000");
  require(blend >= 0 && blend <= 1, "blend of the method", blend, "must be from 0 to 1");
  for (const MethodKey& of : method_keys()) {
    const unsigned needs = needs_of(*this, of.name);
    for (const Rule& rule : rules) {
      if (!(needs & rule.property) || rule.met(*this, dimension)) continue;
      const std::string other = rule.key;
      recon::detail::throw_invalid(of.name + " of the method", get(of.name),
                                   std::string("needs ") + rule.text +
                                       (other.empty() ? "" : "; " + other + " is " + get(other)));
    }
  }
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

std::string_view name_of(Domain domain) {
  return word(domains, domain);
}
std::string_view name_of(Basis basis) {
  return word(bases, basis);
}
std::string_view name_of(VelocityMap map) {
  return word(velocities, map);
}
std::string_view name_of(Quadrature quadrature) {
  return word(quadratures, quadrature);
}
std::string_view name_of(Update update) {
  return word(updates, update);
}
std::string_view name_of(MassMatrix mass) {
  return word(masses, mass);
}
std::string_view name_of(StressUpdate stress) {
  return word(stresses, stress);
}
std::string_view name_of(Scheme scheme) {
  return word(schemes, scheme);
}

}  // namespace recon::mpm
