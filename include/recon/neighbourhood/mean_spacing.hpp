// How far particles are apart on average.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "recon/points/domain.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

// The edge of cells of which `cells` fill the extents of a cloud, over the axes along which it has
// one; none where it has none. extent(d) >= 0 is a length, and the number is given by its logarithm.
template <class Extent>
constexpr std::optional<double> edge_of_cells(double log_cells, int dimension,
                                              const Extent& extent) {
  double log_volume = 0;
  int axes = 0;
  for (int d = 0; d < dimension; ++d) {
    const double length = extent(d);
    if (!(length > 0)) continue;
    log_volume += std::log(length);
    ++axes;
  }
  if (axes == 0) return {};
  return std::exp((log_volume - log_cells) / axes);
}

// (volume / particles)^(1 / axes) over the axes with an extent; 1 where there is none.
template <class Scalar, class Extent>
constexpr Scalar mean_spacing_of(std::size_t particles, int dimension, const Extent& extent) {
  if (particles == 0) return 1;
  const auto spacing = edge_of_cells(std::log(static_cast<double>(particles)), dimension, extent);
  if (!spacing) return 1;
  const Scalar least = 2 * std::sqrt(std::numeric_limits<Scalar>::min());
  return static_cast<Scalar>(*spacing) < least ? least : static_cast<Scalar>(*spacing);
}

// Of particles in a domain: along periodic axes the extent is the period.
template <class Scalar>
Scalar mean_spacing(const PointCloud<Scalar>& particles, const PeriodicDomain<Scalar>& domain) {
  return mean_spacing_of<Scalar>(particles.size(), particles.dimension(), [&](int d) {
    return static_cast<double>(domain.periodic[d] ? domain.period(d) : particles.box().extent(d));
  });
}

}  // namespace recon::detail
