// Ranks that fail together in the middle of work in which they wait for each other.
//
// Whatever has ranks wait for others begins with a vote: a reduction in which each says whether it
// goes on. One that has failed votes once more, which meets the next vote of the others wherever
// they are, and all of them throw what it has thrown.
#pragma once

#include <functional>

#include "recon/petsc/communicator.hpp"

namespace recon::mpm {

class Votes {
 public:
  explicit Votes(const petsc::Communicator& ranks) : ranks_(ranks) {}

  // Does the work, which may hold votes and must be the same on all ranks up to where one fails.
  void together(const std::function<void()>& work);
  // Throws where another rank has failed; returns the largest of a number.
  double vote(double number = 0);

  // Whether what is thrown now is what all ranks throw.
  bool told() const { return told_; }
  const petsc::Communicator& ranks() const { return ranks_; }
  std::int64_t rounds = 0;

 private:
  double hold(bool failed, double number);
  petsc::Communicator ranks_;
  bool told_ = false;  // whether all ranks know of a failure
};

}  // namespace recon::mpm
