#include "problem_options.hpp"

#include "programs/common/errors.hpp"
#include "recon/mpm/method.hpp"

namespace recon::program {

void ProblemOptions::add_to(CLI::App& command, bool choice) {
  command.add_option("FILE", file, "the problem, a TOML file")->required();
  if (choice) {
    std::vector<std::string> names;
    for (const mpm::Method& each : mpm::methods()) names.push_back(each.name);
    command.add_option("--method", method, "the method (see recon-mpm methods)")
        ->check(one_of(names));
    command.add_option("--cells", cells, "cells per unit length")->check(positive_number());
  }
  command.add_option("--set", settings, "KEY=VALUE: another value for a key of the file")
      ->allow_extra_args(false);
  command.add_option("--threads", threads, "threads (default: all processors)")
      ->check(whole_number(1));
}

mpm::AnyProblem ProblemOptions::read(std::vector<std::string> more) const {
  std::vector<std::string> all = settings;
  if (!method.empty()) all.push_back("method.name=" + method);
  if (!cells.empty()) all.push_back("grid.cells=" + cells);
  if (threads > 0) all.push_back("threads=" + std::to_string(threads));
  all.insert(all.end(), more.begin(), more.end());
  return with_exit_code(wrong_input, [&] { return mpm::read_problem(file, all); });
}

}  // namespace recon::program
