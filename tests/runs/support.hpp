// Problems from files that the tests share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mpm/support.hpp"
#include "recon/runs/read_problem.hpp"

namespace recon::mpm::test {

inline std::filesystem::path example(const std::string& name) {
  return std::filesystem::path(RECON_SOURCE_DIR) / "examples/mpm" / name;
}

template <int D>
ProblemFile<D> read_example(const std::string& name, std::vector<std::string> settings = {}) {
  return std::get<ProblemFile<D>>(read_problem(example(name), settings));
}

}  // namespace recon::mpm::test
