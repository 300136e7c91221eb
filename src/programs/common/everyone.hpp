// The processes that do a work together: one, unless ranks of an MPI program share it.
#pragma once

#include <cstddef>
#include <functional>

namespace recon::program {

class Everyone {
 public:
  virtual ~Everyone() = default;

  virtual int size() const { return 1; }
  virtual int rank() const { return 0; }

  // All call each of these, in the same order.
  // Does the work; where it fails on one, it fails on all. It may only wait for the others before
  // anything in it can fail.
  virtual void together(const std::function<void()>& work) const { work(); }
  virtual std::size_t sum(std::size_t number) const { return number; }
  virtual double greatest(double number) const { return number; }
  double least(double number) const { return -greatest(-number); }

  // One process that has read all.
  static const Everyone& alone() {
    static const Everyone one;
    return one;
  }
};

}  // namespace recon::program
