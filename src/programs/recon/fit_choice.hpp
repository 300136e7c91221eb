// How fields are reconstructed: the options of the command line, turned into those of the library.
#pragma once

#include <optional>
#include <string>

#include "particles.hpp"
#include "recon/local_solve/report.hpp"
#include "recon/shape/options.hpp"

namespace recon::program {

struct FitChoice {
  std::optional<int> degree;
  std::string weight = "cubic", form = "radial", unsupported = "nan";
  std::optional<double> radius;
  std::optional<std::size_t> k;
  int grow = 0, threads = 0;
};

// A method by name and, where the user said so, its own degree: "imls", "imls:2".
struct Method {
  std::string name;
  int degree;
  Solver solver;
};

void add_fit_options(CLI::App& app, FitChoice& choice);

// What --method takes, for its help.
extern const char* const method_help;

// `text` is NAME or NAME:DEGREE; without a degree that of `choice` holds, else 1, and 0 for
// shepard.
Method read_method(const std::string& text, const FitChoice& choice);

Options fit_options(const FitChoice& choice, const Method& method, const Particles& particles);

// "radius 2", "radius 1.9 (chosen: 2 mean spacings; --radius changes it)", "15 nearest particles".
std::string describe_support(const FitChoice& choice, const Method& method,
                             const Particles& particles);

}  // namespace recon::program
