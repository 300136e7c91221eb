// The consistent mass matrix M_ij = sum_p m_p S_ip S_jp: M v = p, M a = f (Andersen, Andersen
// 2007, eq. 10, 17).
#pragma once

#include "mpm/policies.hpp"

namespace recon::mpm {

// Adds mass * S_i S_j for all pairs of nodes.
template <int D, class Count>
void add_mass(const NodeFunctions<D, Count>& shape, double mass, MassEntries& entries) {
  for (std::size_t a = 0; a < shape.size(); ++a)
    for (std::size_t b = 0; b < shape.size(); ++b)
      entries.emplace_back(static_cast<int>(shape.node[a]), static_cast<int>(shape.node[b]),
                           mass * shape.S[a] * shape.S[b]);
}

}  // namespace recon::mpm
