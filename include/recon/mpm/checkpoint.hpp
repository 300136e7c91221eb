// The state of a run in a file, from which it goes on bit for bit.
//
// The first 512 bytes are text: what the file is, its format, and a length and a checksum of the
// rest. The rest is HDF5 (whose libraries skip the text): one data set per quantity (X, x, v, F, L,
// stress, half_edges, mass, volume0, energy, body, corners of CPDI2, modes; a row per particle,
// matrices by columns), frame_times, the attributes time, steps, last_dt, start_*, and `problem`: a
// text of lines "key = value" with all that identifies the problem. The file is written whole or
// not at all.
//
// A checkpoint belongs to one problem: dimension, grid, every choice of the method, materials,
// densities and particles of the bodies, boundaries, loads, and the texts of Problem::formulas must
// be those that it was written with, numbers to twelve figures. What may differ: title, threads,
// the end of the time, the rule of the step, and what is written.
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

// Memory beyond the simulation's does not depend on the number of particles. FileError where the
// file cannot be written; one that was there before is whole then.
template <int D>
void write_checkpoint(const std::filesystem::path& path, const Simulation<D>& simulation,
                      const RunState& state);

// Throws FileError for a file that is none, is of another format, is damaged, or is of another
// problem (with the first difference: what, its value in the checkpoint, its value now), and for
// contents that no run can have: numbers that are not finite, particles outside of the grid or
// turned inside out, times out of order. The simulation is as it was then.
template <int D>
RunState read_checkpoint(const std::filesystem::path& path, Simulation<D>& simulation);

}  // namespace recon::mpm
