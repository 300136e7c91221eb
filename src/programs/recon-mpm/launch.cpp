#include "launch.hpp"

#include "programs/common/errors.hpp"
#include "programs/common/started.hpp"

#ifdef RECON_HAS_RANKS
#include "programs/common/ranks.hpp"
#include "recon/ranks/run.hpp"
#endif

namespace recon::program {
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
                     : mpm::run(std::move(problem), options);
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
  return mpm::run(std::move(problem), options);
}

#endif

Launch::~Launch() = default;

template mpm::RunResult Launch::run(mpm::ProblemFile<1>&&, const mpm::RunOptions&) const;
template mpm::RunResult Launch::run(mpm::ProblemFile<2>&&, const mpm::RunOptions&) const;
template mpm::RunResult Launch::run(mpm::ProblemFile<3>&&, const mpm::RunOptions&) const;

}  // namespace recon::program
