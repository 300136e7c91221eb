// How fields are reconstructed: the options of the command line, turned into those of the library.
#pragma once

#include <optional>
#include <string>

#include "particles.hpp"
#include "recon/local_solve/report.hpp"
#include "recon/operators/limit.hpp"
#include "recon/shape/options.hpp"

namespace recon::program {

struct FitChoice {
  std::optional<int> degree;
  std::string weight = "cubic", form = "radial", unsupported = "nan";
  std::optional<double> radius;
  std::optional<std::size_t> k;
  std::string weight_by;  // a column whose numbers multiply the weights; none if empty
  std::string limit = "relaxed", max_distance = "2";
  double leverage = 2.5;
  int grow = 0, threads = 0;
};

// How the library is asked, and what it does not decide by itself.
struct FitOptions : Options {
  Limit limit = Limit::none;
  // The support of kernel sums; none: that of each target's fit.
  std::optional<double> sum_radius;
};

// A method by name and, where the user said so, its own degree: "imls", "imls:2".
struct Method {
  std::string name;
  int degree;
  Solver solver;
};

void add_fit_options(CLI::App& app, FitChoice& choice);

// What --method takes, and its help.
std::vector<std::string> method_names();
extern const char* const method_help;

// `text` is NAME or NAME:DEGREE; without a degree that of `choice` holds, else 1,
// and 0 for shepard.
Method read_method(const std::string& text, const FitChoice& choice);

// Leaves out the particles without a number in the column that weighs them. Ends with wrong_usage
// where there is no such column, with wrong_input for a number that is not positive.
void check_weight_by(const FitChoice& choice, Particles& particles);

// Refers to the particles.
FitOptions fit_options(const FitChoice& choice, const Method& method, const Particles& particles);

// "radius 2", "15 nearest particles", "12 nearest particles (chosen for degree 1; --k or --radius
// changes it)". kernel_sums: also the radius of these, where it differs.
std::string describe_support(const FitChoice& choice, const Method& method,
                             const Particles& particles, bool kernel_sums);

}  // namespace recon::program
