// The problem files of examples/mpm, carried in the program.
#pragma once

#include <string>
#include <vector>

namespace recon::program {

struct ExampleProblem {
  std::string name, text;  // without .toml
};
const std::vector<ExampleProblem>& example_problems();
const std::string& example_problem(const std::string& name);

}  // namespace recon::program
