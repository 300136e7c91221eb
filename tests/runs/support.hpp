// Problems from files that the tests share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/temporary.hpp"
#include "mpm/support.hpp"
#include "recon/runs/read_problem.hpp"

namespace recon::mpm::test {

// Tests in a folder of their own, gone afterwards.
class InFolder : public testing::Test {
 protected:
  static std::string contents(const std::filesystem::path& path) { return ::test::bytes_of(path); }

 private:
  const ::test::TemporaryFolder temporary_;

 protected:
  const std::filesystem::path& folder_ = temporary_.path();
};

inline std::filesystem::path example(const std::string& name) {
  return std::filesystem::path(RECON_SOURCE_DIR) / "examples/mpm" / name;
}

template <int D>
ProblemFile<D> read_example(const std::string& name, std::vector<std::string> settings = {}) {
  return std::get<ProblemFile<D>>(read_problem(example(name), settings));
}

}  // namespace recon::mpm::test
