// A run by this process, or by all ranks.
#pragma once

#include "programs/common/launch.hpp"
#include "recon/runs/run.hpp"

namespace recon::program {

// mpm::run(), on all ranks where there are some.
template <int D>
mpm::RunResult run_on(const Launch& launch, mpm::ProblemFile<D>&& problem,
                      const mpm::RunOptions& options);

}  // namespace recon::program
