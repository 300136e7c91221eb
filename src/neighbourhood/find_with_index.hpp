// find_neighbours with searches that are kept.
#pragma once

#include "neighbourhood/search_index.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::detail {

// What find_neighbours() finds among the particles of the index, into `list`, whose memory is used
// again.
template <int D, class Scalar>
void find_with_index(SearchIndex<Scalar, D>& index, const PointCloud<Scalar>& targets,
                     const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                     const NeighbourOptions& options, const RowsAsked& rows,
                     NeighbourList<Scalar>& list);

}  // namespace recon::detail
