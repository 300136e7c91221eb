// recon-mpm stability: the largest stable step of each method, and its dispersion.
#include "recon/studies/stability.hpp"

#include <cmath>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "problem_options.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/io/picture.hpp"
#include "recon/runs/compose.hpp"
#include "recon/studies/step_waves.hpp"

namespace recon::program {
namespace {

struct StabilityCommand {
  std::string methods = "mpm,cpdi2,improved_cpdi,impm", particles = "1,2,4,8", picture;
  int dimension = 1;
};

void run(const StabilityCommand& options) {
  if (!options.picture.empty())
    with_exit_code(wrong_usage, [&] { require_picture_extension(options.picture); });
  std::vector<mpm::Method> methods;
  const std::vector<std::string> names = method_names(options.methods);
  for (const std::string& name : names) methods.push_back(mpm::composed(name));
  const int width = name_width(14, names);
  std::vector<int> counts;
  for (const std::string& word : split(options.particles)) {
    const auto count = to_number(word);
    if (!count || *count < 1 || *count > 32 || *count != std::floor(*count))
      fail_usage("--particles: '" + word + "' is no whole number from 1 to 32");
    counts.push_back(static_cast<int>(*count));
  }
  if (options.dimension > 1) {
    std::printf(
        "largest stable c_p dt / h in %d-D, measured and by eigenvalues\n%-*s %9s %9s %9s %9s "
        "%9s\n",
        options.dimension, name_width(20, names), "method", "particles", "measured", "eigen",
        "free", "default");
    for (const mpm::Method& method : methods)
      for (const int count : counts) {
        if (method.basis == mpm::Basis::q8 && options.dimension == 3) continue;
        std::printf("%-*s %9d %9.3f", name_width(20, names), method.name.c_str(), count,
                    mpm::stability_limit(method, count, options.dimension).measured);
        for (const bool free : {false, true})
          std::printf(" %9s", options.dimension == 3
                                  ? "-"
                                  : number(mpm::largest_step_by_eigenvalues(
                                               method, options.dimension, count, free),
                                           3)
                                        .c_str());
        std::printf(" %9.3f\n", method.default_courant(options.dimension));
        std::fflush(stdout);
      }
    return;
  }
  std::printf(
      "largest stable c_p dt / h in 1-D, measured, 1 / sqrt(Q (2 - W)), and by eigenvalues: "
      "without "
      "end, and free\n%-*s %9s %9s %9s %7s %7s %7s %7s\n",
      width, "method", "particles", "measured", "analytic", "W", "Q", "eigen", "free");
  for (const mpm::Method& method : methods)
    for (const int count : counts) {
      const auto limit = mpm::stability_limit(method, count);
      std::printf("%-*s %9d %9.3f %9.3f %7.4f %7.4f", width, limit.method.c_str(), count,
                  limit.measured, limit.analytic, limit.W, limit.Q);
      for (const bool free : {false, true})
        std::printf(" %7.3f", method.basis == mpm::Basis::q8
                                  ? std::nan("")
                                  : mpm::largest_step_by_eigenvalues(method, 1, count, free));
      std::printf("\n");
      std::fflush(stdout);
    }

  constexpr double courant = 0.4;
  constexpr int per_cell = 4;
  LinePlot plot;
  plot.title = "speed of waves over c_p, courant 0.4, 4 particles per cell";
  plot.x_label = "k h / pi";
  plot.y_label = "omega / (k c_p)";
  std::printf("\n%s\n%-14s", plot.title.c_str(), "k h / pi");
  std::vector<std::vector<mpm::DispersionPoint>> curves;
  for (const mpm::Method& method : methods) {
    curves.push_back(mpm::dispersion(method, per_cell, courant));
    std::printf(" %*s", name_width(13, {method.name}), method.name.c_str());
    auto& curve = plot.curves.emplace_back();
    curve.name = method.name;
    for (const auto& point : curves.back()) {
      curve.x.push_back(point.kh / 3.14159265358979);
      curve.y.push_back(point.measured);
    }
  }
  std::printf(" %13s\n", "analytic");
  auto& exact = plot.curves.emplace_back();
  exact.name = "sin(w dt/2) = C sin(kh/2)";
  exact.style = CurveStyle::line;
  for (std::size_t i = 0; i < curves.front().size(); ++i) {
    const auto& point = curves.front()[i];
    std::printf("%-14.3f", point.kh / 3.14159265358979);
    for (std::size_t m = 0; m < curves.size(); ++m)
      std::printf(" %*.4f", name_width(13, {names[m]}), curves[m][i].measured);
    std::printf(" %13.4f\n", point.analytic);
    exact.x.push_back(point.kh / 3.14159265358979);
    exact.y.push_back(point.analytic);
  }
  if (!options.picture.empty()) with_exit_code(no_output, [&] { draw(options.picture, plot); });
}

}  // namespace

Command add_stability(CLI::App& app) {
  auto* command =
      app.add_subcommand("stability", "the largest stable step of each method, and its dispersion");
  auto options = std::make_shared<StabilityCommand>();
  command->add_option("--methods", options->methods, "names, with commas")
      ->type_name("NAMES")
      ->capture_default_str();
  command->add_option("--particles", options->particles, "per cell, with commas")
      ->type_name("NUMBERS")
      ->capture_default_str();
  command
      ->add_option("--dimension", options->dimension,
                   "2 and 3: the stable step alone (3: measured)")
      ->type_name("D")
      ->check(CLI::Range(1, 3))
      ->capture_default_str();
  command->add_option("--picture", options->picture, ".png or .svg of the dispersion")
      ->type_name("FILE");
  return [options] { run(*options); };
}

}  // namespace recon::program
