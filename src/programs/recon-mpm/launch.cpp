#include "launch.hpp"

#include "programs/common/errors.hpp"
#include "programs/common/started.hpp"

#ifdef RECON_HAS_GPU
#include "recon/gpu/run.hpp"
#endif
#ifdef RECON_HAS_RANKS
#include "programs/common/ranks.hpp"
#include "recon/ranks/run.hpp"
#endif

namespace recon::program {
namespace {

#ifdef RECON_HAS_GPU
void require_gpu() {
  with_exit_code(wrong_input, [] { mpm::gpu_of_runs(); });
}
template <int D>
mpm::RunResult run_alone(mpm::ProblemFile<D>&& problem, const mpm::RunOptions& options) {
  return problem.device == mpm::RunDevice::gpu ? mpm::run_on_gpu(std::move(problem), options)
                                               : mpm::run(std::move(problem), options);
}
#else
void require_gpu() {
  fail_usage(
      "--device gpu: this recon-mpm was built without CUDA (-DRECON_CUDA=ON builds with it)");
}
template <int D>
mpm::RunResult run_alone(mpm::ProblemFile<D>&& problem, const mpm::RunOptions& options) {
  return mpm::run(std::move(problem), options);
}
#endif

}  // namespace

void Launch::require_device(mpm::RunDevice device) const {
  if (device == mpm::RunDevice::cpu) return;
  if (has_ranks())
    fail_usage(
        "--device gpu: a run on several ranks is on processors; one on a GPU is started alone");
  require_gpu();
}

#ifdef RECON_HAS_RANKS

struct Launch::All : Ranks {};

Launch::Launch() {
  if (started().by_launcher) ranks_ = std::make_unique<All>();
}

void Launch::require_ranks() const {
  if (has_ranks()) ranks_->require_started();
}

void Launch::together(const std::function<void()>& work) const {
  if (!has_ranks()) return work();
  ranks_->together(work);
}

int Launch::largest(int number) const {
  return has_ranks() ? static_cast<int>(ranks_->all().largest(number)) : number;
}

template <int D>
mpm::RunResult Launch::run(mpm::ProblemFile<D>&& problem, const mpm::RunOptions& options) const {
  return has_ranks() ? mpm::run(ranks_->all(), std::move(problem), options)
                     : run_alone(std::move(problem), options);
}

#else

struct Launch::All {};

Launch::Launch() = default;

void Launch::require_ranks() const {
  if (started().copies > 1) fail_without_ranks();
}

void Launch::together(const std::function<void()>& work) const {
  work();
}

int Launch::largest(int number) const {
  return number;
}

template <int D>
mpm::RunResult Launch::run(mpm::ProblemFile<D>&& problem, const mpm::RunOptions& options) const {
  return run_alone(std::move(problem), options);
}

#endif

Launch::~Launch() = default;

template mpm::RunResult Launch::run(mpm::ProblemFile<1>&&, const mpm::RunOptions&) const;
template mpm::RunResult Launch::run(mpm::ProblemFile<2>&&, const mpm::RunOptions&) const;
template mpm::RunResult Launch::run(mpm::ProblemFile<3>&&, const mpm::RunOptions&) const;

}  // namespace recon::program
