// The state of a run as files that ParaView and VisIt open.
//
// A frame is NAME_particles_0007.vtp, NAME_nodes_0007.vti and, for methods that fit stress at cell
// centres, NAME_cells_0007.vti. NAME_particles.pvd and so on list the frames with their times.
//   particles   what is asked for of particle_fields()
//   nodes       mass, velocity, force; degree, rank, neighbours of the fitted velocity
//   cells       density, stress_xx, stress_xy, ..., fill, degree and rank of the fit
// Vectors have three components and tensors nine, row by row, whatever the dimension: directions
// without motion have zero velocity and displacement, F is 1 along them, and the stress there is
// the one that holds them (Material's out_of_plane). With the full stress sigma, pressure is
// -tr(sigma) / 3 and von_mises sqrt(3/2 s : s) with s = sigma + pressure I.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "recon/io/error.hpp"
#include "recon/runs/simulation.hpp"

namespace recon::mpm {

// All fields that particles can have in a frame: velocity, displacement, stress, von_mises,
// pressure, F, det_F, density, mass, volume, body, id, which are the default, velocity_gradient,
// energy, and the history variables of materials by their names (material.hpp): NaN for particles
// whose material has no such variable.
std::span<const std::string> particle_fields();
std::vector<std::string> default_particle_fields();

struct FrameOptions {
  std::vector<std::string> fields = default_particle_fields();  // what particles have
  std::size_t first_listed = 0;  // frames before it are in another folder, and not in the lists
};

// Writes the state that map() computed last as the frame after those at `times`, to files in an
// existing folder, and appends its time to `times`. Throws InvalidArgument for a field that does
// not exist or is asked for twice.
template <int D>
void write_frame(const std::filesystem::path& folder, const std::string& name,
                 const Simulation<D>& simulation, std::vector<double>& times,
                 const FrameOptions& options = {});

}  // namespace recon::mpm
