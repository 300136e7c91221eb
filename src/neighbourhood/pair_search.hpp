// The search for PairRadii: pairs that are within the radius of the particle, of the target, or of
// both.
//
// Which targets a particle reaches is found by a search among the targets, and turned round. So
// radii may differ by any factor: the cost is that of the pairs found.
#pragma once

#include "neighbourhood/search_index.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::detail {

// What find_neighbours() finds with this rule, into `list`. Throws as it does.
template <int D, class Scalar>
void find_pairs(SearchIndex<Scalar, D>& index, const PointCloud<Scalar>& targets,
                const PairRadii& rule, const PeriodicDomain<Scalar>& domain,
                const NeighbourOptions& options, NeighbourList<Scalar>& list);

}  // namespace recon::detail
