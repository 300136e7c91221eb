// Some of the targets, and their rows in a list of neighbours.
#pragma once

#include <cstddef>
#include <vector>

#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

template <class Scalar>
PointCloud<Scalar> subset(const PointCloud<Scalar>& points,
                          const std::vector<std::size_t>& chosen) {
  return points.permuted(std::vector<std::uint32_t>(chosen.begin(), chosen.end()));
}

// The list in which target rows[i] (ascending) has the neighbours and the support of target i of
// `other` where take[i].
template <class Scalar>
NeighbourList<Scalar> with_rows(const NeighbourList<Scalar>& list,
                                const std::vector<std::size_t>& rows,
                                const NeighbourList<Scalar>& other, const std::vector<bool>& take) {
  NeighbourList<Scalar> merged;
  merged.support = list.support;
  merged.support_factor = list.support_factor;
  const bool pairs = !list.pair_support.empty();
  std::size_t next = 0;
  for (std::size_t t = 0; t < list.targets(); ++t) {
    const NeighbourList<Scalar>* from = &list;
    std::size_t row = t;
    if (next < rows.size() && rows[next] == t) {
      if (take[next]) {
        from = &other;
        row = next;
        merged.support[t] = other.support[next];
      }
      ++next;
    }
    const std::int64_t begin = from->offsets[row], end = from->offsets[row + 1];
    merged.indices.insert(merged.indices.end(), from->indices.begin() + begin,
                          from->indices.begin() + end);
    if (!from->shifts.empty())
      merged.shifts.insert(merged.shifts.end(), from->shifts.begin() + begin,
                           from->shifts.begin() + end);
    for (std::int64_t e = begin; e < end && pairs; ++e)
      merged.pair_support.push_back(from->pair_support.empty() ? from->support[row]
                                                               : from->pair_support[e]);
    merged.offsets.push_back(static_cast<std::int64_t>(merged.indices.size()));
  }
  return merged;
}

// The list in which the targets `rows` (ascending) have their supports and no neighbours.
template <class Scalar>
NeighbourList<Scalar> without_neighbours(const NeighbourList<Scalar>& list,
                                         const std::vector<std::size_t>& rows) {
  NeighbourList<Scalar> nothing;
  for (const std::size_t t : rows) {
    nothing.offsets.push_back(0);
    nothing.support.push_back(list.support[t]);
  }
  return with_rows(list, rows, nothing, std::vector<bool>(rows.size(), true));
}

}  // namespace recon::detail
