// The consistent mass matrix M_ij = sum_p m_p S_ip S_jp: M v = p, M a = f (Andersen, Andersen
// 2007, eq. 10, 17).
#pragma once

#include <Eigen/SparseCore>

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// Entries of M; several of one place add up.
using MassEntries = std::vector<Eigen::Triplet<double>>;

// Adds mass * S_i S_j for all pairs of nodes.
template <int D, class Count>
void add_mass(const NodeFunctions<D, Count>& shape, double mass, MassEntries& entries) {
  for (std::size_t a = 0; a < shape.size(); ++a)
    for (std::size_t b = 0; b < shape.size(); ++b)
      entries.emplace_back(static_cast<int>(shape.node[a]), static_cast<int>(shape.node[b]),
                           mass * shape.S[a] * shape.S[b]);
}

// Replaces nodes.mapped and nodes.acceleration of all nodes heavier than `lightest` by the
// solutions of M v = p and M a = f + M g, the latter with zero where a velocity is held; keeps M in
// nodes.mass_matrix. Throws Failure where the particles do not determine a node.
template <int D>
void solve_mass(const MassEntries& entries, double lightest, const Vector<D>& gravity,
                const std::vector<HeldVelocity>& held, std::int64_t step, Nodes<D>& nodes);

extern template void solve_mass(const MassEntries&, double, const Vector<1>&,
                                const std::vector<HeldVelocity>&, std::int64_t, Nodes<1>&);
extern template void solve_mass(const MassEntries&, double, const Vector<2>&,
                                const std::vector<HeldVelocity>&, std::int64_t, Nodes<2>&);
extern template void solve_mass(const MassEntries&, double, const Vector<3>&,
                                const std::vector<HeldVelocity>&, std::int64_t, Nodes<3>&);

}  // namespace recon::mpm
