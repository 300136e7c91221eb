// The search for PairRadii and PairEllipsoids: pairs that are within the support of the particle,
// of the target, or of both.
//
// Which targets a particle reaches is found by a search among the targets, and turned round. So
// radii may differ by any factor: the cost is that of the pairs found. Only means of tensors, which
// may reach what neither of the two does, are left to find_neighbours_with.hpp.
#pragma once

#include "neighbourhood/search_index.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::detail {

bool finds_pairs(const NeighbourRule& rule);

// What find_neighbours() finds with such a rule, into `list`. Throws as it does.
template <int D, class Scalar>
void find_pairs(SearchIndex<Scalar, D>& index, const PointCloud<Scalar>& targets,
                const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                const NeighbourOptions& options, NeighbourList<Scalar>& list);

}  // namespace recon::detail
