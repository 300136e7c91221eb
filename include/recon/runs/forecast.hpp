// The steps and the memory that a run will take, told before it begins.
#pragma once

#include <string>
#include <vector>

#include "recon/mpm/state.hpp"

namespace recon::mpm {

// Limits of memory and steps beyond which a run is refused before it begins.
struct Limits {
  double memory = 0;  // bytes; 0: what the machine has available
  double steps = 1e9;

  // Throws InvalidArgument unless memory >= 0 and steps > 0.
  void validate() const;
};

struct Forecast {
  std::size_t particles = 0, nodes = 0;
  TimeStep step;      // the first step; 0 where there is no end
  double steps = 0;   // number of steps to the end, all like the first
  double memory = 0;  // bytes: the problem, its simulation, and what a step needs beside them
  double available_memory = 0;        // bytes that the machine has now
  std::vector<std::string> warnings;  // whole sentences
};

// The forecast for a run of a valid problem to its end, from its start or from a state. Warns of a
// step that is longer than the method is known to be stable with (stable_courant()), and of
// what breaks the method on this problem whatever the step is (caveat()).
template <int D>
Forecast forecast(const Problem<D>& problem);
template <int D>
Forecast forecast(const Problem<D>& problem, const State<D>& state);

// Throws InvalidArgument, with the numbers, for more steps or memory than the limits allow, and for
// a first step so short that time + step rounds to `time`.
void require_possible(const Forecast& forecast, const Limits& limits, double time = 0);

// The longest step of a method, in units of h / (c_p + |v|), with which small noise does not grow,
// for two particles per cell and axis (docs/mpm.md has the measurement).
double stable_courant(const Method& method, int dimension);
// A sentence about what breaks the method whatever the step is: always for elements, whose
// functions are negative in parts, and at free surfaces for quadrature over cells. Empty where
// nothing is known.
std::string caveat(const Method& method);

// The bytes of one particle, and the bytes that the machine has available now.
template <int D>
double bytes_of_particle(const Kept& kept);
double available_memory();

}  // namespace recon::mpm
