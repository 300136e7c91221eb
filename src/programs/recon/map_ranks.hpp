// recon map on the ranks of an MPI program: each reads a part of the particles, and maps a part of
// the grid.
#pragma once

#include "map_job.hpp"
#include "programs/common/launch.hpp"

namespace recon::program {

// Ends with wrong_usage for options that need all particles at once, naming them.
void map_on_ranks(const MapOptions& options, const Method& method, const Launch& launch);

}  // namespace recon::program
