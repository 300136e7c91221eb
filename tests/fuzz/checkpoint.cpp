// Checkpoints whose seal is right, so that what lies behind it is all that is fuzzed: a state from
// which two steps are made, or an error that says what is wrong. The HDF5 library is not built with
// the fuzzer's instruments; this is a program of its own so that its faults are seen as such.
//
// The input is what follows the seal. With RECON_FUZZ_SEEDS a folder, a first seed is put there.
#include <unistd.h>

#include <stdlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "recon/runs/checkpoint.hpp"
#include "recon/runs/read_problem.hpp"
#include "support/checkpoint_seal.hpp"

namespace {

namespace fs = std::filesystem;

constexpr const char* text = R"([grid]
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = 4
[material]
young = 1000
poisson = 0.3
density = 1
[[body]]
shape = "box"
lower = [0.25, 0.25]
upper = [0.75, 0.75]
particles = 1
velocity = [0.1, 0]
[method]
name = "cpdi2"
[time]
end = 1
)";

const recon::mpm::ProblemFile<2>& problem() {
  static const auto file =
      std::get<recon::mpm::ProblemFile<2>>(recon::mpm::read_problem_text(text, "fuzz.toml"));
  return file;
}

recon::mpm::Simulation<2> fresh() {
  return recon::mpm::Simulation<2>(problem().problem);
}

void two_steps(recon::mpm::Simulation<2>& simulation) {
  for (int s = 0; s < 2; ++s) simulation.step(simulation.choose_step().dt);
}

// A file of this process, in memory where there is such a place; removed with its owner.
struct TemporaryFile {
  fs::path path;

  TemporaryFile() {
    std::string name =
        (fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
        "recon-fuzz-XXXXXX";
    const int descriptor = mkstemp(name.data());
    if (descriptor < 0) abort();
    close(descriptor);
    path = name;
  }
  ~TemporaryFile() { fs::remove(path); }
};

const fs::path& file_name() {
  static const TemporaryFile file;
  return file.path;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* folder = getenv("RECON_FUZZ_SEEDS");
  if (!folder) return 0;
  recon::mpm::Simulation<2> simulation = fresh();
  two_steps(simulation);
  write_checkpoint(file_name(), simulation, problem().formulas, {.start = {}, .frame_times = {0}});
  std::ifstream file(file_name(), std::ios::binary);
  file.seekg(recon::test::seal_size);
  std::ofstream(fs::path(folder) / "whole", std::ios::binary) << file.rdbuf();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::ofstream(file_name(), std::ios::binary)
      << recon::test::sealed(std::string(recon::test::seal_size, '\0') +
                             std::string(reinterpret_cast<const char*>(data), size));
  try {
    recon::mpm::Simulation<2> simulation = fresh();
    read_checkpoint(file_name(), simulation, problem().formulas);
    two_steps(simulation);
  } catch (const recon::FileError&) {
  } catch (const recon::mpm::Failure&) {
  } catch (const recon::InvalidArgument&) {  // a step that is none
  }
  return 0;
}
