// What quadratures over cells do to single cells, on plain numbers, wherever the loop runs
// (pointwise.hpp).
#pragma once

namespace recon::mpm {

// The part of a cell that counts: all of one whose neighbours hold particles, else the part that
// the volumes of its particles fill, at most 1.
constexpr double part_that_counts(double volume, bool inside, double cell_volume) {
  if (!(volume > 0)) return 0;
  if (inside) return 1;
  const double part = volume / cell_volume;
  return part < 1 ? part : 1;
}

}  // namespace recon::mpm
