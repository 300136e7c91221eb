// What identifies the problem that a checkpoint was written for, as keys with values.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "recon/runs/read_problem.hpp"

namespace recon::mpm {

// Keys and values in the order in which they are compared. Numbers have twelve significant digits.
using Identity = std::vector<std::pair<std::string, std::string>>;

template <int D>
Identity identity_of(const Problem<D>& problem, const Particles<D>& particles,
                     const Formulas& formulas);

// As lines "key = value", and back. Line breaks within a value are written as blanks.
std::string to_text(const Identity& identity);
Identity identity_from(const std::string& text);

// The first difference, such as "grid.lower is 0, 0 in the checkpoint, 1, 0 now"; empty
// if there is none.
std::string difference(const Identity& stored, const Identity& now);

}  // namespace recon::mpm
