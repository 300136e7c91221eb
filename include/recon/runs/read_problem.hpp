// Problems from TOML files. docs/mpm.md lists all keys.
//
// ```cpp
//   const std::vector<std::string> settings{"method.name=cpls", "grid.cells=40"};
//   recon::mpm::AnyProblem file = recon::mpm::read_problem("disks.toml", settings);
//   std::visit([](auto& any) { recon::mpm::Simulation simulation(any.problem); }, file);
// ```
//
// Lengths, masses and times are in any consistent units. A value that may vary is a number or a
// text with an expression of X, Y, Z (reference position), x, y, z (current position) and t;
// constants are pi and what [constants] defines.
//
// A setting "key=value" replaces a value of the file, or adds one; a key without its table
// ("cells") stands for the one key of that name that a problem can have. Values are TOML; a bare
// word is a text.
//
// Everything wrong with the file throws FileError: file, line, key, and the valid choices.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <variant>

#include "recon/io/error.hpp"
#include "recon/runs/forecast.hpp"
#include "recon/runs/frames.hpp"
#include "recon/runs/manufactured.hpp"
#include "recon/runs/probes.hpp"

namespace recon::mpm {

// What a run writes, and how often.
struct OutputOptions {
  int frames = 50;  // pictures of the state, evenly in time; 0: none
  bool ledger = true;
  std::vector<std::string> fields = default_particle_fields();  // of the frames, frames.hpp
  // The rows of probes.csv: those of every so many steps, or, where it is above 0, the first one of
  // each such interval of time; and the last one.
  int probe_every = 1;
  double probe_interval = 0;
};

// Where a run happens: its steps on the processor, or on a GPU (gpu/run.hpp). It is no part of the
// problem: checkpoints are the same.
enum class RunDevice { cpu, gpu };

// The texts of the formulas that the functions and initial values of a problem were made from, by
// key. A checkpoint belongs to problems with the same texts (checkpoint.hpp).
using Formulas = std::map<std::string, std::string>;

template <int D>
struct ProblemFile {
  Problem<D> problem;
  std::string title;
  std::shared_ptr<const Manufactured<D>> exact;  // null: no solution is known
  Formulas formulas;
  Limits limits;
  OutputOptions output;
  RunDevice device = RunDevice::cpu;
  std::vector<Probe<D>> probes;
};

using AnyProblem = std::variant<ProblemFile<1>, ProblemFile<2>, ProblemFile<3>>;

AnyProblem read_problem(const std::filesystem::path& path,
                        std::span<const std::string> settings = {});

// Reads a problem from the text of a file. Messages call the file `name`, and files that the text
// names are sought beside it.
AnyProblem read_problem_text(const std::string& text, const std::filesystem::path& name,
                             std::span<const std::string> settings = {});

}  // namespace recon::mpm
