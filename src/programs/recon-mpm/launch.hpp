// How the program was started: alone, or as one of several copies by mpirun or srun.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "recon/runs/run.hpp"

namespace recon::program {

// The copies that were started together are the ranks of one run where the program was built with
// recon::ranks, and are refused where it was not: each would write the same files. A program that
// was started alone does not touch MPI.
class Launch {
 public:
  // Where there are ranks, MPI is there as long as this lives: until the last message has been said.
  Launch();
  ~Launch();
  Launch(const Launch&) = delete;
  Launch& operator=(const Launch&) = delete;

  bool has_ranks() const { return ranks_ != nullptr; }
  // Throws ProgramError where there are several copies that cannot be ranks.
  void require_ranks() const;
  // Does the work; a ProgramError of one rank is that of all.
  void together(const std::function<void()>& work) const;
  // The largest of a number of each rank.
  int largest(int number) const;
  // Ends the program where a run cannot be on this device: on ranks, in a program that was built
  // without CUDA, where there is no GPU.
  void require_device(mpm::RunDevice device) const;
  // mpm::run(), on all ranks where there are some, or on a GPU where the problem says so.
  template <int D>
  mpm::RunResult run(mpm::ProblemFile<D>&& problem, const mpm::RunOptions& options) const;

 private:
  struct All;
  std::unique_ptr<All> ranks_;
};

}  // namespace recon::program
