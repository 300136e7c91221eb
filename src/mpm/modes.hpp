// Which polynomials (transfer/modes.hpp) the particles of a velocity map carry.
#pragma once

#include "recon/mpm/method.hpp"
#include "recon/transfer/modes.hpp"

namespace recon::mpm {

inline ModeSet mode_set(VelocityMap map) {
  return map == VelocityMap::affine ? ModeSet::affine : ModeSet::polynomial;
}
// The number of coefficients of a particle beyond its velocity.
inline int mode_count(VelocityMap map, int dimension) {
  if (map != VelocityMap::affine && map != VelocityMap::polynomial) return 0;
  return mode_count(mode_set(map), dimension);
}

}  // namespace recon::mpm
