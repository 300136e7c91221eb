// A problem from beginning to end with the state in the memory of a GPU (recon::gpu, built with
// RECON_CUDA).
//
// ```cpp
//   using recon::mpm::ProblemFile;
//   const auto disks = std::get<ProblemFile<2>>(recon::mpm::read_problem("disks.toml"));
//   const recon::mpm::RunResult result = recon::mpm::run_on_gpu(disks, {.folder = "out"});
// ```
//
// The particles stay there between steps. They are copied back for what is written and measured:
// frames, rows of the ledger and of probes, checkpoints; the processor then maps them to the nodes
// once more. So a ledger of every step costs more than the steps.
//
// The folder has the same files as that of run() (runs/run.hpp), to rounding, and a run goes on
// from the checkpoint of any other, wherever that was. Results are the same bits from run to run.
#pragma once

#include <string>
#include <vector>

#include "recon/runs/run.hpp"

namespace recon::mpm {

// The methods of the table (method.hpp) that have a form for a GPU.
std::vector<std::string> methods_on_gpu();

// Throws InvalidArgument for a problem with a choice that has no form for a GPU: which, and which
// others have one.
template <int D>
void require_form_on_gpu(const Problem<D>& problem);

// The name of the GPU that a run would be on. Throws InvalidArgument where there is none.
std::string gpu_of_runs();

// As run() of runs/run.hpp, on one GPU. Throws, too, what the two above do, and cuda::Error for
// what goes wrong on the GPU.
template <int D>
RunResult run_on_gpu(ProblemFile<D> problem, const RunOptions& options);

}  // namespace recon::mpm
