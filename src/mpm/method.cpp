#include "recon/mpm/method.hpp"

#include <array>

#include "recon/core/names.hpp"

namespace recon::mpm {

std::span<const Method> methods() {
  using enum VelocityMap;
  using enum Quadrature;
  static const std::array<Method, 9> table{{
      {"mpm", Domain::point, mass_weighted, particles, "Sulsky, Chen, Schreyer 1994"},
      {"ugimp", Domain::ugimp, mass_weighted, particles, "Bardenhagen, Kober 2004"},
      {"cpgimp", Domain::cpgimp, mass_weighted, particles, "Bardenhagen, Kober 2004"},
      {"cpdi1", Domain::cpdi1, mass_weighted, particles, "Sadeghirad, Brannon, Burghardt 2011"},
      {"cpdi2", Domain::cpdi2, mass_weighted, particles, "Sadeghirad, Brannon, Guilkey 2013"},
      {"impm", Domain::point, mls, cells, "Gong 2015, chapter 5"},
      {"improved_cpdi", Domain::cpdi2, mls, particles, "Gong 2015, section 6.6"},
      {"imls_mpm", Domain::point, imls, particles, "Tran, Berzins, Solowski 2019"},
      {"cpls", Domain::cpdi1, cpls, particles, "Tran, Solowski, Berzins, Guilkey 2019"},
  }};
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

std::string_view name_of(Domain domain) {
  constexpr std::string_view names[] = {"point", "ugimp", "cpgimp", "cpdi1", "cpdi2"};
  return names[static_cast<int>(domain)];
}
std::string_view name_of(VelocityMap map) {
  constexpr std::string_view names[] = {"mass_weighted", "mls", "imls", "cpls"};
  return names[static_cast<int>(map)];
}
std::string_view name_of(Quadrature quadrature) {
  return quadrature == Quadrature::cells ? "cells" : "particles";
}

}  // namespace recon::mpm
