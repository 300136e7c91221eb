// Particles at one place: duplicates, ghosts of another rank that were written too.
#pragma once

#include <cstddef>

#include "particles.hpp"

namespace recon::program {

struct Coincidence {
  std::size_t places = 0;     // that hold more than one particle
  std::size_t particles = 0;  // at these places
};

// Places are the same where all coordinates are equal, periodic images being one place.
// Cost O(n log n).
Coincidence count_coincident(const Particles& particles);

}  // namespace recon::program
