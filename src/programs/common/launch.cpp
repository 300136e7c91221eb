#include "programs/common/launch.hpp"

#include "programs/common/errors.hpp"
#include "programs/common/started.hpp"

#ifdef RECON_PROGRAMS_HAVE_RANKS
#include "programs/common/ranks.hpp"
#endif

namespace recon::program {
#ifdef RECON_PROGRAMS_HAVE_RANKS

struct Launch::All : Ranks {};

const Everyone& Launch::everyone() const {
  return has_ranks() ? *ranks_ : Everyone::alone();
}

const petsc::Communicator& Launch::ranks() const {
  return ranks_->all();
}

int Launch::join(const std::string& program, const std::vector<std::string>& words,
                 const std::function<std::function<void()>()>& prepare) {
  // Until the last message has been said: a rank that ends earlier makes mpirun end the others.
  ranks_ = std::make_unique<All>();
  try {
    ranks_->require_started();
    std::function<void()> work;
    ranks_->together([&] { work = prepare(); });
    std::string line = program;
    for (const std::string& word : words) line += " " + word;
    ranks_->require_same(line, "the command");
    work();
    return success;
  } catch (const FailureOfAll& of_all) {
    // The first as it was started: another MPI makes every copy the first one.
    if (started().rank == 0) say(program, of_all.what());
    return of_all.code();
  } catch (...) {
    const Failure own = failure();
    say(program, "rank " + std::to_string(ranks_->rank()) + ": " + own.text);
    MPI_Abort(MPI_COMM_WORLD, own.code);
    return own.code;
  }
}

#else

struct Launch::All {};

const Everyone& Launch::everyone() const {
  return Everyone::alone();
}

int Launch::join(const std::string&, const std::vector<std::string>&,
                 const std::function<std::function<void()>()>&) {
  throw FailureOfAll(
      wrong_usage,
      std::to_string(started().copies) +
          " copies were started, which would all write the same files: this program was built "
          "without ranks (RECON_BUILD_PETSC); start it once, without mpirun or srun");
}

#endif

Launch::Launch() = default;
Launch::~Launch() = default;

}  // namespace recon::program
