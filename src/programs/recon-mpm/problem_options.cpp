#include "problem_options.hpp"

#include <algorithm>

#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/core/names.hpp"
#include "recon/runs/compose.hpp"

namespace recon::program {

void ProblemOptions::add_to(CLI::App& command, bool choice) {
  command.add_option("FILE", file, "the problem, a TOML file")->type_name("")->required();
  if (choice) {
    command
        .add_option("--method", method,
                    "the method (see recon-mpm methods), with other choices: NAME+KEY=VALUE+...")
        ->type_name("NAME")
        ->check(CLI::Validator(
            [](std::string& text) {
              try {
                mpm::composed(text);
                return std::string();
              } catch (const InvalidArgument& error) {
                return std::string(error.what());
              }
            },
            "", check_name(method_names(""))));
    command.add_option("--cells", cells, "cells per unit length")
        ->check(positive_number())
        ->type_name("N");
  }
  command.add_option("--set", settings, "another value for a key of the file, as in grid.cells=40")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command
      .add_option("--threads", threads,
                  "threads (default: all processors; 1 on each of several ranks)")
      ->type_name("N")
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

std::vector<std::string> method_names(const std::string& list) {
  std::vector<std::string> all, chosen = split(list);
  for (const mpm::Method& each : mpm::methods()) all.push_back(each.name);
  for (const std::string& name : chosen) try {
      mpm::composed(name);
    } catch (const InvalidArgument& error) {
      fail_usage(std::string("--methods: ") + error.what());
    }
  return chosen.empty() ? all : chosen;
}

}  // namespace recon::program
