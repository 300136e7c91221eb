// What makes a problem the one that a checkpoint was written for, as keys with values.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "recon/mpm/problem.hpp"

namespace recon::mpm {

// In the order in which differences are told. Numbers have twelve significant figures.
using Identity = std::vector<std::pair<std::string, std::string>>;

template <int D>
Identity identity_of(const Problem<D>& problem);

// Lines "key = value", and back. Line breaks within are written as blanks.
std::string to_text(const Identity& identity);
Identity identity_from(const std::string& text);

// "grid.lower is 0, 0 in the checkpoint, 1, 0 now": the first difference, or nothing.
std::string difference(const Identity& stored, const Identity& now);

}  // namespace recon::mpm
