#include "run_on.hpp"

#include "programs/common/errors.hpp"

#ifdef RECON_HAS_GPU
#include "recon/gpu/run.hpp"
#endif
#ifdef RECON_PROGRAMS_HAVE_RANKS
#include "recon/petsc/communicator.hpp"
#include "recon/ranks/run.hpp"
#endif

namespace recon::program {

void require_device(const Launch& launch, mpm::RunDevice device) {
  if (device == mpm::RunDevice::cpu) return;
  if (launch.has_ranks())
    fail_usage(
        "device gpu: a run on several ranks is on processors; one on a GPU is started alone");
#ifdef RECON_HAS_GPU
  with_exit_code(wrong_input, [] { mpm::gpu_of_runs(); });
#else
  fail_usage("device gpu: this recon-mpm was built without CUDA (-DRECON_CUDA=ON builds with it)");
#endif
}

template <int D>
mpm::RunResult run_on(const Launch& launch, mpm::ProblemFile<D>&& problem,
                      const mpm::RunOptions& options) {
#ifdef RECON_PROGRAMS_HAVE_RANKS
  if (launch.has_ranks()) return mpm::run(launch.ranks(), std::move(problem), options);
#endif
#ifdef RECON_HAS_GPU
  if (problem.device == mpm::RunDevice::gpu) return mpm::run_on_gpu(std::move(problem), options);
#endif
  (void)launch;
  return mpm::run(std::move(problem), options);
}

template mpm::RunResult run_on(const Launch&, mpm::ProblemFile<1>&&, const mpm::RunOptions&);
template mpm::RunResult run_on(const Launch&, mpm::ProblemFile<2>&&, const mpm::RunOptions&);
template mpm::RunResult run_on(const Launch&, mpm::ProblemFile<3>&&, const mpm::RunOptions&);

}  // namespace recon::program
