// A run whose steps are made on a GPU, or by whatever else makes them: device_step.hpp.
#pragma once

#include "gpu/device_step.hpp"
#include "recon/gpu/run.hpp"

namespace recon::mpm {

// As run_on_gpu(), with the steps of `make`.
template <int D>
RunResult run_with(const MakeStep<D>& make, ProblemFile<D> file, const RunOptions& options);

}  // namespace recon::mpm
