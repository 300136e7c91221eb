// The ranks of a program that mpirun or srun has started, and how they end together. For what is built
// with recon::petsc.
#pragma once

#include <string>

#include "programs/common/errors.hpp"
#include "programs/common/everyone.hpp"
#include "programs/common/started.hpp"
#include "recon/petsc/communicator.hpp"

namespace recon::program {

// MPI is there as long as this lives.
class Ranks : public Everyone {
 public:
  Ranks() : all_(MPI_COMM_WORLD) {}

  const petsc::Communicator& all() const { return all_; }
  int rank() const override { return all_.rank(); }
  int size() const override { return all_.size(); }

  // Throws on all ranks unless MPI sees those that were started.
  void require_started() const {
    if (size() != started().copies)
      throw FailureOfAll(
          wrong_usage,
          std::to_string(started().copies) +
              " copies were started, and MPI, as this program was built with it, does not see "
              "them as ranks of one run: mpirun must be that of the same MPI, and srun needs the "
              "--mpi that it understands");
  }

  // Throws on all ranks where one of them has another text, which `what` names, than the first.
  void require_same(const std::string& text, const std::string& what) const {
    int length = static_cast<int>(text.size());
    MPI_Bcast(&length, 1, MPI_INT, 0, all_.get());
    std::string first = text;
    first.resize(static_cast<std::size_t>(length));
    MPI_Bcast(first.data(), length, MPI_CHAR, 0, all_.get());
    together([&] {
      if (text != first)
        fail_usage(what + " is '" + text + "', and that of the first rank is '" + first + "'");
    });
  }

  // Where the work fails on some ranks, all throw what the lowest of them says, as FailureOfAll.
  void together(const std::function<void()>& work) const override {
    Failure own;
    try {
      work();
    } catch (...) {
      own = failure();
    }
    const bool failed_here = own.code != success;
    const auto failed = static_cast<int>(all_.sum(failed_here ? 1 : 0));
    if (failed == 0) return;
    const int first = -static_cast<int>(all_.largest(failed_here ? -rank() : -size()));
    int head[2] = {own.code, static_cast<int>(own.text.size())};
    MPI_Bcast(head, 2, MPI_INT, first, all_.get());
    own.text.resize(static_cast<std::size_t>(head[1]));
    MPI_Bcast(own.text.data(), head[1], MPI_CHAR, first, all_.get());
    throw FailureOfAll(
        static_cast<ExitCode>(head[0]),
        failed == size() ? own.text : "rank " + std::to_string(first) + ": " + own.text);
  }
  std::size_t sum(std::size_t number) const override {
    return static_cast<std::size_t>(all_.sum(static_cast<long long>(number)));
  }
  double greatest(double number) const override { return all_.largest(number); }

 private:
  petsc::Session session_{0, nullptr};
  petsc::Communicator all_;
};

}  // namespace recon::program
