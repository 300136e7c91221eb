// A run by this process, by all ranks, or on a GPU.
#pragma once

#include "programs/common/launch.hpp"
#include "recon/runs/run.hpp"

namespace recon::program {

// Ends the program where a run cannot be on this device: on ranks, in a program that was built without
// CUDA, where there is no GPU.
void require_device(const Launch& launch, mpm::RunDevice device);

// mpm::run(), on all ranks where there are some, or on a GPU where the problem says so.
template <int D>
mpm::RunResult run_on(const Launch& launch, mpm::ProblemFile<D>&& problem,
                      const mpm::RunOptions& options);

}  // namespace recon::program
