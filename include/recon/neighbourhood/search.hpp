// What a neighbour search is: four questions about the particles near one point.
//
// Every search answers with the same particles in the same order, so that one can take the place of
// another without a bit of the results changing:
//   within(x, radius)            all with |x - x_p| <= radius, by ascending index
//   nearest(x, k)                the k nearest (fewer if there are fewer), by (distance, index)
//   nearest_within(x, k, radius) the k nearest of those within the radius, in the same order
//   in_box(lower, upper)         all with lower <= x_p <= upper on every axis, by ascending index;
//                                there is no x, so distance2 is 0
// Equal distances are told apart by the smaller index. Distances are squared_distance(x, x_p)
// below, in the scalar type of the points, whatever the search computes inside. The answer replaces
// what `found` held.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "recon/neighbourhood/neighbour_list.hpp"

namespace recon {

// The square of the distance, summed axis by axis: every search compares exactly this number.
template <class Scalar, std::size_t D>
Scalar squared_distance(const std::array<Scalar, D>& a, const std::array<Scalar, D>& b) {
  Scalar sum = 0;
  for (std::size_t d = 0; d < D; ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

// Every p with squared_distance(x, p) <= radius * radius has |x_d - p_d| <= reach(radius) on each
// axis, in spite of rounding and of squares that underflow.
template <class Scalar>
Scalar reach(Scalar radius) {
  return radius * (1 + 16 * std::numeric_limits<Scalar>::epsilon()) +
         std::sqrt(std::numeric_limits<Scalar>::min());
}

// A search over points of `S::dimension` coordinates of type S::Scalar. Queries are const and may
// run concurrently. kd_tree.hpp, r_tree.hpp, cell_grid.hpp and brute_force.hpp are models.
template <class S>
concept NeighbourSearch = requires(const S& search,
                                   const std::array<typename S::Scalar, S::dimension>& x,
                                   typename S::Scalar radius, std::size_t k,
                                   std::vector<Neighbour<typename S::Scalar>>& found) {
  { S::dimension } -> std::convertible_to<int>;
  { search.size() } -> std::convertible_to<std::size_t>;
  search.within(x, radius, found);
  search.nearest(x, k, found);
  search.nearest_within(x, k, radius, found);
  search.in_box(x, x, found);
};

}  // namespace recon
