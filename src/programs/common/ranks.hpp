// The ranks of a program that mpirun or srun has started, and how they end together. For what is built
// with recon::petsc.
#pragma once

#include <functional>
#include <string>

#include "programs/common/errors.hpp"
#include "programs/common/started.hpp"
#include "recon/petsc/communicator.hpp"

namespace recon::program {

// MPI is there as long as this lives.
class Ranks {
 public:
  Ranks() : all_(MPI_COMM_WORLD) {}

  const petsc::Communicator& all() const { return all_; }
  int rank() const { return all_.rank(); }
  int size() const { return all_.size(); }

  // Throws on all ranks unless MPI sees those that were started.
  void require_started() const {
    if (size() != started().copies)
      fail_usage(
          std::to_string(started().copies) +
          " copies were started, and MPI, as this program was built with it, does not see "
          "them as ranks of one run: mpirun must be that of the same MPI, and srun needs the "
          "--mpi that it understands");
  }

  // Does the work; where it fails on some ranks, all throw what the lowest of them says, as
  // ProgramError. Collective.
  void together(const std::function<void()>& work) const {
    int code = success;
    std::string text;
    try {
      work();
    } catch (const ProgramError& error) {
      code = error.code();
      text = error.what();
    } catch (const InvalidArgument& error) {
      code = wrong_usage;
      text = error.what();
    } catch (const std::exception& error) {
      code = internal_error;
      text = error.what();
    }
    const auto failed = static_cast<int>(all_.sum(code == success ? 0 : 1));
    if (failed == 0) return;
    const int first = -static_cast<int>(all_.largest(code == success ? -size() : -rank()));
    int head[2] = {code, static_cast<int>(text.size())};
    MPI_Bcast(head, 2, MPI_INT, first, all_.get());
    text.resize(static_cast<std::size_t>(head[1]));
    MPI_Bcast(text.data(), head[1], MPI_CHAR, first, all_.get());
    throw ProgramError(
        static_cast<ExitCode>(head[0]),
        failed == size() || first == 0 ? text : "rank " + std::to_string(first) + ": " + text);
  }

 private:
  petsc::Session session_{0, nullptr};
  petsc::Communicator all_;
};

}  // namespace recon::program
