// The polynomials that the particles of a velocity map carry beyond their velocities.
#pragma once

#include "recon/mpm/method.hpp"
#include "recon/transfer/modes.hpp"
#include "transfer/node_rows.hpp"

namespace recon::mpm {

inline ModeSet mode_set(VelocityMap map) {
  return map == VelocityMap::affine ? ModeSet::affine : ModeSet::polynomial;
}
// The number of coefficients of a particle beyond its velocity.
inline std::size_t mode_count(VelocityMap map, int dimension) {
  if (map != VelocityMap::affine && map != VelocityMap::polynomial) return 0;
  return static_cast<std::size_t>(mode_count(mode_set(map), dimension));
}

// The modes of a particle with the policy Shape.
template <int D, class Shape>
using ParticleModes = std::conditional_t<is_product<D, Shape>, PolynomialModes<D>, DomainModes<D>>;

// Those of a map at x, where `at` are the functions.
template <int D, class Shape, class At>
void fill_modes(const Grid<D>& grid, const Shape& shape_of, const Vector<D>& x, const At& at,
                VelocityMap map, ParticleModes<D, Shape>& modes) {
  if constexpr (is_product<D, Shape>)
    modes.fill(grid, shape_of.functions.axes(grid, x), x, mode_set(map));
  else
    modes.fill(grid, at);
}

// As kernels see them.
template <int D>
detail::ModeList list_of(const PolynomialModes<D>& modes) {
  return {modes.values(), static_cast<std::ptrdiff_t>(modes.nodes()), 1,
          static_cast<std::size_t>(modes.count())};
}
template <int D>
detail::ModeList list_of(const DomainModes<D>& modes) {
  return {modes.values(), 1, D, D};
}

}  // namespace recon::mpm
