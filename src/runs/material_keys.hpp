// The materials and their constants by the names that files have for them.
#pragma once

#include <vector>

#include "recon/mpm/material.hpp"

namespace recon::mpm {

// Calls work(M()) for each kind of material, in the order of the list.
template <class Work, std::size_t at = 0>
void for_each_material(Work&& work) {
  if constexpr (at < std::variant_size_v<Material>) {
    using M = std::variant_alternative_t<at, Material>;
    static_assert(MaterialModel<M>);
    work(M());
    for_each_material<Work, at + 1>(std::forward<Work>(work));
  }
}

// Its constants beyond Lame's, with their keys.
inline std::vector<std::pair<std::string_view, double>> constants_of(const Material& material) {
  std::vector<std::pair<std::string_view, double>> found;
  std::visit(
      [&](const auto& m) {
        if constexpr (requires { m.parameters(); })
          for (const auto& [key, member] : m.parameters()) found.emplace_back(key, m.*member);
      },
      material);
  return found;
}

}  // namespace recon::mpm
