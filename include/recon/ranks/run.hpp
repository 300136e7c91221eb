// A problem from beginning to end on the ranks of an MPI program.
//
// ```cpp
//   const recon::petsc::Session session(argc, argv);
//   const recon::petsc::Communicator ranks(PETSC_COMM_WORLD);
//   const auto disks = std::get<recon::mpm::ProblemFile<2>>(recon::mpm::read_problem("disks.toml"));
//   const recon::mpm::RunResult result = recon::mpm::run(ranks, disks, {.folder = "out"});
// ```
//
// The folder has the same files as without ranks (runs/run.hpp), to rounding, and a run goes on
// from the checkpoint of any other, with or without ranks: with as many ranks as before to the bit.
// All ranks see the same folder, and are given the same problem. Frames are written in pieces, one by
// each rank (DistributedSimulation::write_frame; one rank alone writes them as one process does). The first
// one writes ledger and probes, from sums of all ranks, and checkpoints, from the state of all
// particles, which comes to it whenever one is due.
//
// Memory: at the start, and where a restart is read, each rank has all particles for a moment; then
// its own and copies (ranks/distributed_simulation.hpp), and the first one all of them again while a
// checkpoint is written.
//
// What a rank throws, all throw, with their types as in run(): Failure with the number that the
// particle has in the problem, and "rank 3: " in front of its reason.
#pragma once

#include "recon/petsc/communicator.hpp"
#include "recon/runs/run.hpp"

namespace recon::mpm {

// As run() of runs/run.hpp, collective; the result is the same on all ranks, and RunResult::spread
// says how the particles were spread at the end. RunOptions::stop is asked on all ranks: one of
// them stops all. All other calls of RunOptions are made on the first rank alone. The memory that
// is expected is that of all ranks on the machine. Throws InvalidArgument, too, where the problems
// of the ranks differ (what identifies them, see checkpoint.hpp, their particles and times), and
// what DistributedSimulation refuses.
template <int D>
RunResult run(const petsc::Communicator& ranks, ProblemFile<D> problem, const RunOptions& options);

}  // namespace recon::mpm
