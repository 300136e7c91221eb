// recon-mpm converge PROBLEM: errors and orders of convergence.
#include "recon/studies/convergence.hpp"

#include <cmath>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "problem_options.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/progress.hpp"
#include "programs/common/text.hpp"
#include "recon/core/names.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/picture.hpp"

namespace recon::program {
namespace {

namespace fs = std::filesystem;

struct ConvergeCommand {
  ProblemOptions problem;
  std::string methods = "mpm,cpdi1,impm,cpls", cells = "8,16,32,64", times = "T", norm = "l2", out,
              picture;
  bool quiet = false;
};

// "T/4", "3T/8", "T", "0.5T", as parts of T.
double part_of_end(const std::string& text) {
  const std::size_t T = text.find('T'), slash = text.find('/');
  const auto value = [](const std::string& word, double otherwise) {
    return word.empty() ? std::optional<double>(otherwise) : to_number(word);
  };
  if (T != std::string::npos) {
    const std::string factor = text.substr(0, T), rest = text.substr(T + 1);
    const auto top = value(factor.ends_with('*') ? factor.substr(0, factor.size() - 1) : factor, 1);
    const auto bottom = slash == T + 1 ? to_number(text.substr(slash + 1))
                        : rest.empty() ? std::optional<double>(1)
                                       : std::nullopt;
    if (top && bottom && *top > 0 && *bottom > 0 && *top <= *bottom) return *top / *bottom;
  }
  fail_usage("--times " + text +
             ": needs parts of the problem's end T, as in T/4,3T/8,T; none beyond T");
}

mpm::ConvergenceStudy study_of(const ConvergeCommand& options) {
  mpm::ConvergenceStudy study;
  study.methods = method_names(options.methods);
  for (const std::string& word : split(options.cells)) {
    const auto cells = to_number(word);
    if (!cells || *cells < 1 || *cells > 1e6 || *cells != std::floor(*cells))
      fail_usage("--cells: '" + word + "' is no whole number above 0");
    study.cells.push_back(static_cast<int>(*cells));
  }
  for (const std::string& word : split(options.times)) study.times.push_back(part_of_end(word));
  std::sort(study.cells.begin(), study.cells.end());
  std::sort(study.times.begin(), study.times.end());
  if (study.methods.empty() || study.cells.empty() || study.times.empty())
    fail_usage("--methods, --cells and --times need at least one each");
  return study;
}

// A block for each time: a line for each method and grid, a pair of columns for each field.
void print_table(const std::vector<mpm::ConvergenceRow>& rows, const std::string& norm) {
  const auto find = [&](const mpm::ConvergenceRow& like, const char* field) {
    return *std::find_if(rows.begin(), rows.end(), [&](const mpm::ConvergenceRow& row) {
      return row.method == like.method && row.cells == like.cells && row.time == like.time &&
             row.field == field && row.norm == norm;
    });
  };
  double time = -1;
  std::vector<double> times;
  std::vector<std::string> names;
  for (const auto& row : rows) {
    times.push_back(row.time);
    names.push_back(row.method);
  }
  const int width = name_width(14, names);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (const double t : times) {
    std::printf("%stime %s, %s norm\n%-*s %6s", time < 0 ? "" : "\n", number(t).c_str(),
                norm.c_str(), width, "method", "cells");
    time = t;
    for (const char* field : mpm::error_fields) std::printf("  %12s order", field);
    std::printf("\n");
    for (const auto& row : rows) {
      if (row.time != t || row.norm != norm || row.field != mpm::error_fields[0]) continue;
      std::printf("%-*s %6d", width, row.method.c_str(), row.cells);
      for (const char* field : mpm::error_fields) {
        const auto at = find(row, field);
        std::printf("  %12s %5s", or_dash(at.error, "%.3e").c_str(),
                    or_dash(at.order, "%.2f").c_str());
      }
      std::printf("%s%s\n", row.failure.empty() ? "" : "  ", row.failure.c_str());
    }
  }
}

void write_table(const fs::path& path, const std::vector<mpm::ConvergenceRow>& rows) {
  AtomicFile file(path);
  file.write("method,cells,h,time,field,norm,error,order,failure\n");
  const auto number_or_empty = [](double value) {
    return std::isnan(value) ? std::string() : number(value, 17);
  };
  for (const auto& row : rows) {
    std::string reason = row.failure;
    std::replace(reason.begin(), reason.end(), '"', '\'');
    file.write(row.method + "," + std::to_string(row.cells) + "," + number(row.h, 17) + "," +
               number(row.time, 17) + "," + row.field + "," + row.norm + "," +
               number_or_empty(row.error) + "," + number_or_empty(row.order) + "," +
               (reason.empty() ? "" : "\"" + reason + "\"") + "\n");
  }
  file.commit();
}

// Errors of the last time over h: a curve for each method and field.
void draw_errors(const fs::path& path, const std::vector<mpm::ConvergenceRow>& rows,
                 const std::string& norm, const std::string& title) {
  double last = 0;
  for (const auto& row : rows) last = std::max(last, row.time);
  LinePlot plot;
  plot.title = title;
  plot.x_label = "cell size";
  plot.y_label = "displacement error, " + norm;
  plot.log_x = plot.log_y = true;
  plot.reference_slope = 2;
  for (const auto& row : rows) {
    if (row.time != last || row.norm != norm || row.field != "displacement") continue;
    if (plot.curves.empty() || plot.curves.back().name != row.method)
      plot.curves.push_back({row.method, {}, {}, CurveStyle::line_and_markers});
    plot.curves.back().x.push_back(row.h);
    plot.curves.back().y.push_back(row.error);
  }
  draw(path, plot);
}

void run(const ConvergeCommand& options) {
  const mpm::ConvergenceStudy study = study_of(options);
  if (!options.out.empty()) with_exit_code(no_output, [&] { const AtomicFile probe(options.out); });
  if (!options.picture.empty())
    with_exit_code(wrong_usage, [&] { require_picture_extension(options.picture); });
  options.problem.read({"method.name=" + study.methods.front(),
                        "grid.cells=" + std::to_string(study.cells.front())});  // before any work
  // A run's cost grows with the cells of all axes and with the steps.
  std::size_t total = 0, done = 0;
  const auto cost = [](int cells) {
    return static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells);
  };
  for (const int cells : study.cells) total += cost(cells) * study.methods.size();
  Progress progress("converge", total, options.quiet);
  const auto rows = with_exit_code(wrong_input, [&] {
    return mpm::converge(
        [&](std::span<const std::string> settings) {
          return options.problem.read({settings.begin(), settings.end()});
        },
        study,
        [&](const std::string&, int cells) {
          progress.advance(done);
          done = cost(cells);
        });
  });
  print_table(rows, options.norm);
  with_exit_code(no_output, [&] {
    if (!options.out.empty()) write_table(options.out, rows);
    if (!options.picture.empty())
      draw_errors(options.picture, rows, options.norm,
                  fs::path(options.problem.file).stem().string());
  });
}

}  // namespace

Command add_converge(CLI::App& app) {
  auto* command =
      app.add_subcommand("converge", "errors and orders of convergence against the exact solution");
  auto options = std::make_shared<ConvergeCommand>();
  options->problem.add_to(*command, false);
  command->add_option("--methods", options->methods, "names, with commas")
      ->type_name("NAMES")
      ->capture_default_str();
  command->add_option("--cells", options->cells, "cells per unit length, with commas")
      ->type_name("NUMBERS")
      ->capture_default_str();
  command->add_option("--times", options->times, "parts of the problem's end T, as in T/4,3T/8,T")
      ->type_name("PARTS")
      ->capture_default_str();
  command->add_option("--norm", options->norm, "of the table and the picture: l2 or rms")
      ->type_name("NORM")
      ->check(one_of({"l2", "rms"}))
      ->capture_default_str();
  command->add_option("--out", options->out, ".csv for all numbers, in both norms")
      ->type_name("FILE");
  command->add_option("--picture", options->picture, ".png or .svg of the displacement errors")
      ->type_name("FILE");
  command->add_flag("--quiet", options->quiet, "no progress");
  return [options] { run(*options); };
}

}  // namespace recon::program
