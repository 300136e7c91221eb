// The state of a run as files that ParaView and VisIt open.
//
// A frame is NAME_particles_0007.vtp, NAME_nodes_0007.vti and, for methods that fit stress at cell
// centres, NAME_cells_0007.vti. NAME_particles.pvd and so on list the frames with their times.
//   particles   velocity, displacement, stress (upper triangle row by row: xx, xy, ...), density,
//               det_F, body
//   nodes       mass, velocity, force; degree, rank, neighbours of the fitted velocity
//   cells       density, stress, fill, degree and rank of the fit
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recon/io/error.hpp"
#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// Writes what map() left as the frame after those at `times`, to files in an existing folder, and
// adds its time.
template <int D>
void write_frame(const std::filesystem::path& folder, const std::string& name,
                 const Simulation<D>& simulation, std::vector<double>& times);

}  // namespace recon::mpm
