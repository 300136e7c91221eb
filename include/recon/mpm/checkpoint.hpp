// The state of a run in a file, from which it goes on bit for bit.
//
// HDF5: one data set per quantity (X, x, v, F, L, stress, half_edges, mass, volume0, energy, body,
// corners of CPDI2; a row per particle, matrices by columns), frame_times, and attributes time,
// steps, last_dt, dimension, method. Written whole or not at all. What does not change in a run
// (grid, materials, loads) stays in the problem file; a restart is given both.
#pragma once

#include <filesystem>

#include "recon/io/error.hpp"
#include "recon/mpm/ledger.hpp"
#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// What a run knows besides its simulation.
struct RunState {
  Ledger start;                     // the account that errors of energy are counted from
  std::vector<double> frame_times;  // of the frames that were written
};

template <int D>
void write_checkpoint(const std::filesystem::path& path, const Simulation<D>& simulation,
                      const RunState& state);

// Throws FileError for a file that is not one, or of another dimension, method or number of
// particles.
template <int D>
RunState read_checkpoint(const std::filesystem::path& path, Simulation<D>& simulation);

}  // namespace recon::mpm
