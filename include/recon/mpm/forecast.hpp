// What a run will take, told before it begins, and refused where that is more than there is.
#pragma once

#include <string>
#include <vector>

#include "recon/mpm/problem.hpp"

namespace recon::mpm {

struct Forecast {
  std::size_t particles = 0, nodes = 0;
  Step step;          // the first; 0 where there is no end
  double steps = 0;   // to the end, all like the first
  double memory = 0;  // bytes: the problem, its simulation, and what a step needs beside them
  double available_memory = 0;        // bytes that the machine has now
  std::vector<std::string> warnings;  // whole sentences
};

// Of a run of a valid problem from `time` to its end. Warns of a step that is longer than what the
// method is known to bear (Method::stable_courant()), and of what breaks the method on this problem
// whatever the step is (Method::caveat()).
template <int D>
Forecast forecast(const Problem<D>& problem, double time = 0);

// Throws InvalidArgument, with the numbers, for more steps or memory than the limits allow, and for
// a first step that does not move the clock at `time`.
template <int D>
void require_possible(const Problem<D>& problem, const Forecast& forecast, double time = 0);

// Bytes of a particle of the problem in one copy, and bytes that the machine has now.
template <int D>
double bytes_of_particle(const Method& method);
double available_memory();

}  // namespace recon::mpm
