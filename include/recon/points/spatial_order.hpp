// An order of points in which neighbours in space follow each other, so that work that goes through
// the points finds what it needs in the cache.
//
// The bounding box is cut into cells, about four points in each, numbered along a Morton curve
// (Morton 1966: the bits of the cell's coordinates interleaved); points are sorted by cell and,
// in one cell, by index. Cost O(n): two passes and a counting sort; 4 bytes per point and, while
// it runs, 5 more.
#pragma once

#include <cstdint>
#include <vector>

#include "recon/points/point_cloud.hpp"

namespace recon {

// order[i] is the index of the point that comes as number i: a permutation of 0 .. size() - 1.
// threads as in parallel_blocks; the order does not depend on it.
template <class Scalar>
std::vector<std::uint32_t> spatial_order(const PointCloud<Scalar>& points, int threads = 0);

// Do the points follow each other in space as they stand, as particles sorted by a code or nodes of
// a grid do? True where four of five steps from a point to the next are shorter than four mean
// spacings, judged by a thousand of them.
template <class Scalar>
bool is_spatially_ordered(const PointCloud<Scalar>& points);

extern template bool is_spatially_ordered(const PointCloud<float>&);
extern template bool is_spatially_ordered(const PointCloud<double>&);
extern template std::vector<std::uint32_t> spatial_order(const PointCloud<float>&, int);
extern template std::vector<std::uint32_t> spatial_order(const PointCloud<double>&, int);

}  // namespace recon
