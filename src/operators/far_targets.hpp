// The targets that Options::max_distance leaves without a value.
#pragma once

#include <cstddef>
#include <vector>

#include "neighbourhood/cloud.hpp"

namespace recon::detail {

// The targets (ascending) whose nearest particle is farther away than `multiple` times the local
// spacing there: the distance from that particle to its neighbour number 2 D + 3, of particles at
// one place counting one. None where all particles are at one place, which has no spacing, and
// where `multiple` is infinite.
//
// `neighbours` are those of the targets in numbers of places, found with `search`; they save most
// of the work. Where they are `complete`, every particle within the distance of a target's farthest
// one is in its list.
template <class Scalar>
std::vector<std::size_t> far_targets(const Cloud<Scalar>& cloud, const PointCloud<Scalar>& targets,
                                     const NeighbourList<Scalar>& neighbours, double multiple,
                                     bool complete, const NeighbourOptions& search);

}  // namespace recon::detail
