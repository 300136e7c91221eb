#include "recon/gpu/run.hpp"

#include <cuda_runtime_api.h>

#include "gpu/on_gpu.hpp"
#include "gpu/stepping.hpp"

namespace recon::mpm {

std::string gpu_of_runs() {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error != cudaSuccess || count == 0)
    recon::detail::throw_invalid(
        "device", "gpu",
        std::string("needs a GPU, and there is none here: ") +
            (error != cudaSuccess ? cudaGetErrorString(error) : "none found"));
  int device = 0;
  cudaDeviceProp properties;
  if (cudaGetDevice(&device) != cudaSuccess ||
      cudaGetDeviceProperties(&properties, device) != cudaSuccess)
    recon::detail::throw_invalid("device", "gpu", "needs a GPU that answers");
  return properties.name;
}

template <int D>
RunResult run_on_gpu(ProblemFile<D> problem, const RunOptions& options) {
  require_form_on_gpu(problem.problem);
  gpu_of_runs();
  return run_with<D>(make_on_gpu<D>, std::move(problem), options);
}

template RunResult run_on_gpu(ProblemFile<1>, const RunOptions&);
template RunResult run_on_gpu(ProblemFile<2>, const RunOptions&);
template RunResult run_on_gpu(ProblemFile<3>, const RunOptions&);

}  // namespace recon::mpm
