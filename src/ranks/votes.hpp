// Ranks that fail together in the middle of work in which they wait for each other.
//
// Whatever has ranks wait for others begins with a vote: a reduction in which each says whether it
// goes on. One that has failed votes once more, which meets the next vote of the others wherever
// they are, and all of them throw what it has thrown.
//
// What all throw is a Told, beside its own type: so votes within votes do not say it again, and an
// exception that a caller makes of it, on all ranks, is a failure as any other.
#pragma once

#include <functional>

#include "recon/petsc/communicator.hpp"

namespace recon::mpm {

// Marks what all ranks throw.
class Told {
 public:
  virtual ~Told() = default;
};

class Votes {
 public:
  explicit Votes(const petsc::Communicator& ranks) : ranks_(ranks) {}

  // Does the work, which may hold votes and must be the same on all ranks up to where one fails:
  // between two votes there must be no other waiting for ranks than what follows a vote at once.
  // Failure, InvalidArgument, bad_alloc, FileError and those of run.hpp keep their types, all else
  // becomes runtime_error.
  void together(const std::function<void()>& work);
  // Throws where another rank has failed; returns the largest of a number.
  double vote(double number = 0);

  const petsc::Communicator& ranks() const { return ranks_; }
  std::int64_t rounds = 0;

 private:
  double hold(bool failed, double number);
  petsc::Communicator ranks_;
};

}  // namespace recon::mpm
