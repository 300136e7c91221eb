#include "run_on.hpp"

#ifdef RECON_PROGRAMS_HAVE_RANKS
#include "recon/petsc/communicator.hpp"
#include "recon/ranks/run.hpp"
#endif

namespace recon::program {

template <int D>
mpm::RunResult run_on(const Launch& launch, mpm::ProblemFile<D>&& problem,
                      const mpm::RunOptions& options) {
#ifdef RECON_PROGRAMS_HAVE_RANKS
  if (launch.has_ranks()) return mpm::run(launch.ranks(), std::move(problem), options);
#endif
  (void)launch;
  return mpm::run(std::move(problem), options);
}

template mpm::RunResult run_on(const Launch&, mpm::ProblemFile<1>&&, const mpm::RunOptions&);
template mpm::RunResult run_on(const Launch&, mpm::ProblemFile<2>&&, const mpm::RunOptions&);
template mpm::RunResult run_on(const Launch&, mpm::ProblemFile<3>&&, const mpm::RunOptions&);

}  // namespace recon::program
