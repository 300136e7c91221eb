// recon map on the ranks of an MPI program: each reads a part of the particles, and maps a part of
// the grid.
#pragma once

#include "map_job.hpp"

namespace recon::program {

// Ends with wrong_usage where the program was built without recon::petsc, and for options that need
// all particles at once, naming them.
void map_on_ranks(const MapOptions& options, const Method& method);

}  // namespace recon::program
