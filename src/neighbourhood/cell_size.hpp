// How large the cells of a cloud are, and how many: the same on the processor and on a GPU.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "recon/neighbourhood/mean_spacing.hpp"

namespace recon::detail {

// The edge of cells that hold so many of the particles on average over a box; 1 where all are in
// one place. extent(d) >= 0 is a length.
template <class Extent>
constexpr double size_of_cells(std::size_t particles, int dimension, double particles_per_cell,
                               const Extent& extent) {
  if (particles == 0) return 1;
  const double log_cells = -std::log(particles_per_cell / static_cast<double>(particles));
  const auto size = edge_of_cells(log_cells, dimension, extent);
  if (!size) return 1;
  return *size > std::numeric_limits<double>::min() ? *size : std::numeric_limits<double>::min();
}

// The largest number of cells for so many particles.
constexpr double most_cells(std::size_t particles) {
  constexpr double least = 64, per_particle = 4, most = 4e9;
  const double wanted = per_particle * static_cast<double>(particles);
  return wanted < least ? least : wanted < most ? wanted : most;
}

// Sets counts[d] to those of cells that cover a box, and returns their edge: that which is asked
// for, or a larger one if there would be too many.
template <class Extent>
constexpr double cover_with_cells(double size, std::size_t particles, int dimension,
                                  const Extent& extent, std::int64_t* counts) {
  double longest = 0;
  for (int d = 0; d < dimension; ++d) longest = extent(d) > longest ? extent(d) : longest;
  const double most = most_cells(particles);
  if (size < longest / most) size = longest / most;
  for (;; size *= 1.25) {
    double total = 1;
    for (int d = 0; d < dimension; ++d) total *= std::floor(extent(d) / size) + 1;
    if (total <= most) break;
  }
  for (int d = 0; d < dimension; ++d) counts[d] = static_cast<std::int64_t>(extent(d) / size) + 1;
  return size;
}

}  // namespace recon::detail
