// The state of a run in a file. A run that is continued from it gives the same bits as one that was
// not interrupted.
//
// The first 512 bytes are text: what the file is, its format, and a length and a checksum of the
// rest. The rest is HDF5 (whose libraries skip the text): one data set per quantity (X, x, v, F, L,
// stress, half_edges, mass, volume0, energy, body; corners, modes, history where there are any; a
// row per entry, matrices by columns), frame_times, the attributes time, steps, last_dt, start_*,
// work, and `problem`: a text of lines "key = value" with all that identifies the problem. The file
// is written completely or not at all.
//
// A checkpoint belongs to one problem: dimension, grid, every choice of the method, materials,
// densities and particles of the bodies, boundaries, loads, and the texts of formulas must be those
// that it was written with, numbers to twelve figures. Functions without a text cannot be compared.
// What may differ: title, threads, the end of the time, the rule of the step, and what is written.
#pragma once

#include <filesystem>

#include "recon/io/error.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/read_problem.hpp"

namespace recon::mpm {

// The part of the state of a run that its simulation does not have.
struct RunState {
  Ledger start;                     // the account at the start: energy errors are relative to it
  std::vector<double> frame_times;  // the times of the frames written so far
  double work = 0;  // of external forces so far (ledger.hpp); NaN where it was not summed up
};

// Writes a checkpoint; the memory needed for it does not depend on the number of particles. Throws
// FileError where the file cannot be written; a file that was there before is then unchanged.
template <int D>
void write_checkpoint(const std::filesystem::path& path, const Simulation<D>& simulation,
                      const Formulas& formulas, const RunState& state);

// The same of a state whose problem, without its particles, is given.
template <int D>
void write_checkpoint(const std::filesystem::path& path, const Problem<D>& problem,
                      const State<D>& of, const Formulas& formulas, const RunState& state);

// Reads a checkpoint into the simulation. Throws FileError for a file that is no checkpoint, is of
// another format, is damaged, or is of another problem (with the first difference: what, its value
// in the checkpoint, its value now), and for contents that no run can have: numbers that are not
// finite, particles outside of the grid or turned inside out, times out of order. The simulation is
// then unchanged.
template <int D>
RunState read_checkpoint(const std::filesystem::path& path, Simulation<D>& simulation,
                         const Formulas& formulas);

}  // namespace recon::mpm
