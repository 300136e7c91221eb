// Problem files: a problem, or an error that says what is wrong.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "recon/runs/read_problem.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    recon::mpm::read_problem_text(text, "fuzz.toml", std::vector<std::string>{"limits.memory=1e7"});
  } catch (const recon::FileError&) {
  }
  return 0;
}
