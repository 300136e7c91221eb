#include "launch.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "programs/common/errors.hpp"

#ifdef RECON_HAS_RANKS
#include "recon/ranks/run.hpp"
#endif

namespace recon::program {
namespace {

// A whole number of the environment; -1 where there is none.
int number_in_environment(const char* name) {
  const char* text = std::getenv(name);
  int number = -1;
  if (text == nullptr) return number;
  const char* end = text + std::strlen(text);
  const auto read = std::from_chars(text, end, number);
  return read.ec == std::errc() && read.ptr == end ? number : -1;
}

// What starts several copies says to each how many there are, and which of them it is.
struct Started {
  int copies = 1, rank = 0;
  bool by_launcher = false;
};

Started started() {
  struct Names {
    const char *copies, *rank;
  };
  // OpenMPI; MPICH, Intel and what else has its PMI; MVAPICH.
  for (const Names& names :
       {Names{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"}, Names{"PMI_SIZE", "PMI_RANK"},
        Names{"MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"}})
    if (const int copies = number_in_environment(names.copies); copies > 0)
      return {copies, std::max(number_in_environment(names.rank), 0), true};
  // A step of Slurm; one of a single task may be a shell, too.
  if (const int copies = number_in_environment("SLURM_STEP_NUM_TASKS"); copies > 1)
    return {copies, std::max(number_in_environment("SLURM_PROCID"), 0), true};
  return {};
}

}  // namespace

#ifdef RECON_HAS_RANKS

struct Launch::Ranks {
  Ranks(int argc, char** argv) : session(argc, argv), all(MPI_COMM_WORLD) {}
  petsc::Session session;
  petsc::Communicator all;
};

Launch::Launch(int argc, char** argv) {
  const Started here = started();
  copies_ = here.copies;
  rank_ = here.rank;
  if (here.by_launcher) {
    ranks_ = std::make_unique<Ranks>(argc, argv);
    // Where MPI sees others than were started, it is another one than that of mpirun.
    if (ranks_->all.size() == copies_)
      rank_ = ranks_->all.rank();
    else
      ranks_.reset();
  }
  if (!first() && std::freopen("/dev/null", "w", stdout) == nullptr) std::fclose(stdout);
}

void Launch::require_ranks() const {
  if (copies_ > 1 && !has_ranks())
    fail_usage(std::to_string(copies_) +
               " copies were started, and MPI, as this program was built with it, does not see "
               "them as ranks of one run: mpirun must be that of the same MPI, and srun needs the "
               "--mpi that it understands");
}

void Launch::together(const std::function<void()>& work) const {
  if (!has_ranks()) return work();
  int code = success;
  std::string text;
  try {
    work();
  } catch (const ProgramError& error) {
    code = error.code();
    text = error.what();
  } catch (const std::exception& error) {
    code = internal_error;
    text = error.what();
  }
  const int ranks = ranks_->all.size();
  const int failed = ranks - largest(code == success ? 0 : ranks - rank_);
  if (failed == ranks) return;
  std::array<int, 2> head{code, static_cast<int>(text.size())};
  MPI_Bcast(head.data(), 2, MPI_INT, failed, ranks_->all.get());
  text.resize(static_cast<std::size_t>(head[1]));
  MPI_Bcast(text.data(), head[1], MPI_CHAR, failed, ranks_->all.get());
  throw ProgramError(static_cast<ExitCode>(head[0]),
                     failed == 0 ? text : "rank " + std::to_string(failed) + ": " + text);
}

int Launch::largest(int number) const {
  return has_ranks() ? static_cast<int>(ranks_->all.largest(number)) : number;
}

template <int D>
mpm::RunResult Launch::run(const mpm::ProblemFile<D>& problem,
                           const mpm::RunOptions& options) const {
  return has_ranks() ? mpm::run(ranks_->all, problem, options) : mpm::run(problem, options);
}

#else

struct Launch::Ranks {};

Launch::Launch(int, char**) : copies_(started().copies), rank_(started().rank) {
  if (!first() && std::freopen("/dev/null", "w", stdout) == nullptr) std::fclose(stdout);
}

void Launch::require_ranks() const {
  if (copies_ > 1)
    fail_usage(std::to_string(copies_) +
               " copies were started, which would all write the same files: this program was built "
               "without ranks (RECON_BUILD_PETSC); start it once, without mpirun or srun");
}

void Launch::together(const std::function<void()>& work) const {
  work();
}

int Launch::largest(int number) const {
  return number;
}

template <int D>
mpm::RunResult Launch::run(const mpm::ProblemFile<D>& problem,
                           const mpm::RunOptions& options) const {
  return mpm::run(problem, options);
}

#endif

Launch::~Launch() = default;

void Launch::require_one(const std::string& command) const {
  if (copies_ > 1)
    fail_usage(command + " is for one process, and " + std::to_string(copies_) +
               " were started; only recon-mpm run is spread over the ranks of mpirun or srun");
}

template mpm::RunResult Launch::run(const mpm::ProblemFile<1>&, const mpm::RunOptions&) const;
template mpm::RunResult Launch::run(const mpm::ProblemFile<2>&, const mpm::RunOptions&) const;
template mpm::RunResult Launch::run(const mpm::ProblemFile<3>&, const mpm::RunOptions&) const;

}  // namespace recon::program
