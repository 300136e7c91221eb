// How the program was started: alone, or as one of several copies by mpirun or srun.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "programs/common/everyone.hpp"

namespace recon::petsc {
class Communicator;
}

namespace recon::program {

// The copies that were started together are the ranks of one work where the program was built with
// recon::petsc, and are refused where it was not: each would write the same files. A program that
// was started alone does not touch MPI.
class Launch {
 public:
  Launch();
  ~Launch();
  Launch(const Launch&) = delete;
  Launch& operator=(const Launch&) = delete;

  // Those that do the work: this process alone or, once they have been joined, all ranks.
  const Everyone& everyone() const;
  bool has_ranks() const { return ranks_ != nullptr; }
  // As recon::petsc sees them, where there are some.
  const petsc::Communicator& ranks() const;

  // Joins the copies, which must have been started with the same words. Each prepares its work,
  // together with the others, and does it. A failure of all is said once; one of a rank alone, for
  // which others might wait, is said and ends all of them at once. The exit code.
  int join(const std::string& program, const std::vector<std::string>& words,
           const std::function<std::function<void()>()>& prepare);

 private:
  struct All;
  std::unique_ptr<All> ranks_;
};

}  // namespace recon::program
