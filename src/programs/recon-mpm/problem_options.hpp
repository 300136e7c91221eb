// What all subcommands that read a problem file understand.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "programs/common/checks.hpp"
#include "recon/runs/read_problem.hpp"

namespace recon::program {

struct ProblemOptions {
  std::string file, method, cells;
  std::vector<std::string> settings;
  int threads = 0;

  // choice: also --method and --cells.
  void add_to(CLI::App& command, bool choice);
  // The problem with all options and `more` applied; ends the program where it is wrong.
  mpm::AnyProblem read(std::vector<std::string> more = {}) const;
};

// Names of methods with commas between them; all methods for an empty text. Fails as wrong usage of
// --methods for one that is not known.
std::vector<std::string> method_names(const std::string& list);

// The width of a column for the methods' names, at least this: compositions are long.
inline int name_width(std::size_t least, const std::vector<std::string>& names) {
  for (const std::string& name : names) least = std::max(least, name.size());
  return static_cast<int>(least);
}

}  // namespace recon::program
