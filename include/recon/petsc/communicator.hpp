// The ranks of a computation on many machines, and how they fail together.
//
// ```cpp
//   const recon::petsc::Session session(argc, argv);  // or your own PetscInitialize
//   const recon::petsc::Communicator ranks(PETSC_COMM_WORLD);
//   ranks.together([&] { read_my_part(ranks.rank()); });  // throws on all ranks, or on none
// ```
//
// Every function of recon::petsc that is called "collective" must be called on all ranks, in the
// same order. Where the arguments of one rank are refused, all ranks throw what that rank has
// thrown, with "rank 3: " in front of it (the lowest rank's, where several fail): none of them
// waits for the others, and a program that lets the exception end it ends on all ranks.
//
// A call of PETSc or of MPI that fails throws Error, with the call and its code; nothing is
// printed, and nothing aborts. Such a failure in the middle of a message round (memory that is used
// up on one machine, a broken network) is seen where MPI says it, which need not be on all ranks.
#pragma once

#include <mpi.h>

#include <functional>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>

#include "recon/core/error.hpp"

namespace recon::petsc {

// A call of PETSc or MPI has failed. what() reads "<call>: error <code>: <text>".
class Error : public std::runtime_error {
 public:
  Error(std::string call, int code, const std::string& text);

  const std::string& call() const { return call_; }
  int code() const { return code_; }

 private:
  std::string call_;
  int code_;
};

// PETSc (and with it MPI) is there as long as the first of these lives, unless it was there before.
// No options are read from the command line or from files, and handlers of signals stay as they are.
class Session {
 public:
  Session(int argc, char** argv);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  bool finalizes_ = false;
};

class Communicator {
 public:
  // A duplicate of `comm`, whose failures are returned. Collective. Throws InvalidArgument where
  // PETSc has not been initialised, and Error.
  explicit Communicator(MPI_Comm comm);

  MPI_Comm get() const { return *comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }

  // Does the work, which must not wait for other ranks; where it throws on any rank, all ranks throw.
  // InvalidArgument, Cancelled and Error keep their types, other exceptions become runtime_error.
  // Collective; one reduction of three numbers.
  void together(const std::function<void()>& work) const;
  // The same, and also throws InvalidArgument on all ranks unless `same` is equal on all of them;
  // `what` says what that is.
  void together(const std::function<void()>& work, const char* what,
                std::initializer_list<double> same) const;

  // The sum and the largest of a number of each rank. Collective.
  long long sum(long long number) const;
  double largest(double number) const;

 private:
  std::shared_ptr<const MPI_Comm> comm_;
  int rank_ = 0, size_ = 1;
};

}  // namespace recon::petsc
