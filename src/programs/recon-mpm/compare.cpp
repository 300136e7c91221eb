// recon-mpm compare PROBLEM: every method on one problem.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <sstream>

#include "commands.hpp"
#include "comparison_table.hpp"
#include "problem_options.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/progress.hpp"
#include "programs/common/text.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/picture.hpp"
#include "recon/runs/compose.hpp"
#include "recon/studies/comparison.hpp"

namespace recon::program {
namespace {

namespace fs = std::filesystem;

struct CompareCommand {
  ProblemOptions problem;
  std::string methods, cells, courants, out, picture, against;
  bool no_stability = false, resume = false, quiet = false;
};

// Families that a reader tells apart, each in its colour.
const char* family(const mpm::Method& method) {
  using mpm::VelocityMap;
  if (method.update == mpm::Update::pic || method.velocity == VelocityMap::taylor ||
      method.velocity == VelocityMap::affine || method.velocity == VelocityMap::polynomial)
    return "taylor, affine, polynomial";
  if (method.update == mpm::Update::xpic || method.update == mpm::Update::fmpm) return "filtered";
  const bool fitted =
      method.velocity == mpm::VelocityMap::mls || method.velocity == mpm::VelocityMap::imls ||
      method.velocity == mpm::VelocityMap::cpls || method.quadrature != mpm::Quadrature::particles;
  return fitted ? "least squares" : "mass-weighted";
}

// An error over the cost, a point for each method: with the last of the courant numbers.
void draw_comparison(const fs::path& path, const std::vector<TableRow>& rows,
                     const TableColumn& against, const std::string& title) {
  LinePlot plot;
  plot.title = title;
  plot.x_label = "nanoseconds per particle and step";
  plot.y_label = against.name;
  plot.log_x = plot.log_y = true;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const mpm::ComparisonRow& row = rows[r].numbers;
    if (r + 1 < rows.size() && rows[r + 1].numbers.method == row.method) continue;
    const double error = std::abs(row.*against.value);
    if (!(error > 0) || !(row.nanoseconds > 0)) continue;
    const char* name = family(mpm::composed(row.method));
    auto curve = std::find_if(plot.curves.begin(), plot.curves.end(),
                              [&](const Curve& each) { return each.name == name; });
    if (curve == plot.curves.end())
      curve = plot.curves.insert(plot.curves.end(), {name, {}, {}, CurveStyle::markers});
    curve->x.push_back(row.nanoseconds);
    curve->y.push_back(error);
    curve->labels.push_back(row.method);
  }
  if (plot.curves.empty())
    throw FileError(path, 0, std::string("no picture: no method has a ") + against.name);
  draw(path, plot);
}

// Without a choice: of the displacement, where some row has one.
const TableColumn& column_of_picture(const std::string& chosen, const std::vector<TableRow>& rows) {
  const bool exact = std::any_of(rows.begin(), rows.end(), [](const TableRow& row) {
    return !std::isnan(row.numbers.displacement_error);
  });
  return error_column(!chosen.empty() ? chosen : exact ? "displacement" : "energy");
}

// All that a row of a method rests on besides the method.
std::string run_of(const CompareCommand& options, const mpm::ComparisonStudy& study) {
  std::ifstream file(options.problem.file);
  std::ostringstream text;
  text << file.rdbuf();
  for (const std::string& setting : options.problem.settings) text << "\n" << setting;
  for (const auto& numbers : {study.cells, study.courants}) {
    text << "\n";
    for (const double each : numbers) text << number(each, 17) << " ";
  }
  text << "\n" << options.problem.threads << study.stable_steps;
  return hash(text.str());
}

// The rows that stand in the table already. Fails where they are not of this comparison.
std::vector<TableRow> kept_rows(const CompareCommand& options, const std::string& run) {
  if (!options.resume) return {};
  if (options.out.empty()) fail_usage("--resume: needs --out, the table to go on with");
  return with_exit_code(wrong_input, [&] {
    std::vector<TableRow> rows = read_table(options.out);
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows[r].run != run)
        throw FileError(options.out, r + 2,
                        "is of another problem file, other settings, cells, courant numbers or "
                        "threads; without --resume the table is made anew");
    return rows;
  });
}

std::vector<double> numbers_above_zero(const char* option, const std::string& list) {
  std::vector<double> numbers;
  for (const std::string& word : split(list)) {
    const auto value = to_number(word);
    if (!value || *value <= 0)
      fail_usage(std::string(option) + ": '" + word + "' is no number above 0");
    numbers.push_back(*value);
  }
  return numbers;
}

void run(const CompareCommand& options) {
  mpm::ComparisonStudy study;
  study.stable_steps = !options.no_stability;
  study.methods = method_names(options.methods);
  study.cells = numbers_above_zero("--cells", options.cells);
  study.courants = numbers_above_zero("--courant", options.courants);
  std::sort(study.cells.begin(), study.cells.end());
  if (!options.out.empty()) with_exit_code(no_output, [&] { const AtomicFile probe(options.out); });
  if (!options.picture.empty())
    with_exit_code(wrong_usage, [&] { require_picture_extension(options.picture); });
  const mpm::AnyProblem problem = options.problem.read();  // before any work
  const bool fixed = std::visit(
      [](const auto& file) { return file.problem.time.rule == mpm::StepRule::fixed; }, problem);
  if (fixed && !study.courants.empty())
    fail_usage(
        "--courant: the problem's time.rule is fixed; another, as with --set "
        "time.rule=bar_wave, makes steps of a courant number");
  if (study.cells.empty()) {
    const double own =
        1 / std::visit([](const auto& file) { return file.problem.grid.h(); }, problem);
    study.cells = {own, 2 * own};
  }
  const std::string run = run_of(options, study);
  std::vector<TableRow> rows, kept = kept_rows(options, run);
  Progress progress("compare", study.methods.size(), options.quiet);
  for (const std::string& method : study.methods) {
    const auto own = std::stable_partition(kept.begin(), kept.end(), [&](const TableRow& row) {
      return row.numbers.method != method;
    });
    if (own != kept.end()) {
      rows.insert(rows.end(), own, kept.end());
      kept.erase(own, kept.end());
    } else {
      mpm::ComparisonStudy alone = study;
      alone.methods = {method};
      for (mpm::ComparisonRow& row : mpm::compare(
               [&](std::span<const std::string> settings) {
                 return options.problem.read({settings.begin(), settings.end()});
               },
               alone))
        rows.push_back(table_row(std::move(row), run));
    }
    progress.advance(1);
    if (options.out.empty()) continue;
    // What is done is there when a later method takes too long; and what others asked for stays.
    std::vector<TableRow> all = rows;
    all.insert(all.end(), kept.begin(), kept.end());
    with_exit_code(no_output, [&] { write_table(options.out, all); });
  }
  print_table(rows);
  if (!options.picture.empty())
    with_exit_code(no_output, [&] {
      draw_comparison(options.picture, rows, column_of_picture(options.against, rows),
                      fs::path(options.problem.file).stem().string());
    });
}

}  // namespace

Command add_compare(CLI::App& app) {
  auto* command = app.add_subcommand("compare", "every method on one problem, side by side");
  auto options = std::make_shared<CompareCommand>();
  options->problem.add_to(*command, false);
  command->add_option("--methods", options->methods, "names, with commas (default: all)")
      ->type_name("NAMES");
  command
      ->add_option("--cells", options->cells,
                   "cells per unit length, with commas (default: the problem's, and twice that)")
      ->type_name("NUMBERS");
  command
      ->add_option("--courant", options->courants,
                   "numbers of Courant, with commas: a row of each method for each (default: the "
                   "problem's)")
      ->type_name("NUMBERS");
  command->add_option("--out", options->out, ".csv for the table, written after each method")
      ->type_name("FILE");
  command->add_flag("--resume", options->resume,
                    "rows of this comparison that stand in the table are not made again");
  command
      ->add_option(
          "--picture", options->picture,
          ".png or .svg: an error over the cost, a point for each method (with the last of "
          "--courant)")
      ->type_name("FILE");
  command
      ->add_option("--against", options->against,
                   "the error of the picture: displacement, velocity, angular or energy (default: "
                   "displacement, or energy where no exact solution is known)")
      ->type_name("ERROR")
      ->check(one_of({"displacement", "velocity", "angular", "energy"}));
  command->add_flag("--no-stability", options->no_stability,
                    "do not look for the largest stable steps");
  command->add_flag("--quiet", options->quiet, "no progress");
  return [options] { run(*options); };
}

}  // namespace recon::program
