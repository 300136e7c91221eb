// recon-mpm compare PROBLEM: every method on one problem.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "commands.hpp"
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
using Row = mpm::ComparisonRow;

struct CompareCommand {
  ProblemOptions problem;
  std::string methods, cells, courants, out, picture, against;
  bool no_stability = false, quiet = false;
};

// What is measured: the name in the table file, a short one for the terminal, how to print it.
struct Column {
  const char *name, *brief, *format;
  double Row::*value;
};
constexpr Column columns[] = {
    {"courant", "courant", "%.3g", &Row::courant},
    {"displacement error", "u error", "%.2e", &Row::displacement_error},
    {"order", "order", "%.2f", &Row::displacement_order},
    {"velocity error", "v error", "%.2e", &Row::velocity_error},
    {"order of velocity", "order", "%.2f", &Row::velocity_order},
    {"largest displacement", "max u", "%.4g", &Row::displacement},
    {"largest displacement before", "before", "%.4g", &Row::displacement_before},
    {"momentum defect", "momentum", "%.1e", &Row::momentum_defect},
    {"angular defect", "angular", "%.1e", &Row::angular_defect},
    {"angular error", "ang error", "%.1e", &Row::angular_error},
    {"energy error", "energy", "%+.1e", &Row::energy_error},
    {"ns per particle and step", "ns", "%.0f", &Row::nanoseconds},
    {"largest stable step", "stable", "%.2f", &Row::stable},
};

std::string remark(const Row& row) {
  if (!row.refusal.empty()) return "refused: " + row.refusal;
  std::string text = row.failure.empty() ? "" : "stopped: " + row.failure;
  if (row.negative_nodes > 0)
    text += (text.empty() ? "" : "; ") + counted(row.negative_nodes, "node") + " of negative mass" +
            (row.sign_change ? ", some change sign" : "");
  return text;
}

void print_table(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Row& row : rows) names.push_back(row.method);
  const int width = name_width(20, names);
  std::printf("%-*s", width, "method");
  for (const Column& column : columns) std::printf(" %9s", column.brief);
  std::printf("\n");
  for (const Row& row : rows) {
    std::printf("%-*s", width, row.method.c_str());
    for (const Column& column : columns)
      std::printf(" %9s", or_dash(row.*column.value, column.format).c_str());
    const std::string text = remark(row);
    std::printf("%s%s\n", text.empty() ? "" : "  ", text.c_str());
  }
  std::printf(
      "\nu, v: l2 errors at the end on the finest grid; max u: largest displacement, there and on "
      "the grid before;\n"
      "momentum, angular: what the velocity map misses, at worst; ang error, energy: of angular "
      "momentum and of the\n"
      "energy balance at the end, over their largest size; ns: per particle and step; stable: "
      "largest c_p dt / h\n");
}

void write_table(const fs::path& path, const std::vector<Row>& rows) {
  AtomicFile file(path);
  std::string text = "method";
  for (const Column& column : columns) text += std::string(",") + column.name;
  file.write(text + ",remark\n");
  for (const Row& row : rows) {
    text = row.method;
    for (const Column& column : columns)
      text += "," + (std::isnan(row.*column.value) ? "" : number(row.*column.value, 6));
    std::string note = remark(row);
    std::replace(note.begin(), note.end(), '"', '\'');
    file.write(text + "," + (note.empty() ? "" : "\"" + note + "\"") + "\n");
  }
  file.commit();
}

// Families that a reader tells apart, each in its colour.
const char* family(const mpm::Method& method) {
  if (method.update == mpm::Update::pic || method.velocity == mpm::VelocityMap::taylor)
    return "taylor, affine, polynomial";
  if (method.update == mpm::Update::xpic || method.update == mpm::Update::fmpm) return "filtered";
  const bool fitted =
      method.velocity == mpm::VelocityMap::mls || method.velocity == mpm::VelocityMap::imls ||
      method.velocity == mpm::VelocityMap::cpls || method.quadrature != mpm::Quadrature::particles;
  return fitted ? "least squares" : "mass-weighted";
}

// An error over the cost, a point for each method: with the last of the courant numbers.
void draw_comparison(const fs::path& path, const std::vector<Row>& rows, const Column& against,
                     const std::string& title) {
  LinePlot plot;
  plot.title = title;
  plot.x_label = "nanoseconds per particle and step";
  plot.y_label = against.name;
  plot.log_x = plot.log_y = true;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    if (r + 1 < rows.size() && rows[r + 1].method == row.method) continue;
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

const Column& column_named(const std::string& name, const std::vector<Row>& rows) {
  const bool exact = std::any_of(
      rows.begin(), rows.end(), [](const Row& row) { return !std::isnan(row.displacement_error); });
  const std::string wanted = !name.empty() ? name : exact ? "displacement" : "energy";
  return *std::find_if(std::begin(columns), std::end(columns), [&](const Column& column) {
    return std::string(column.name) == wanted + " error";
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
  Progress progress("compare", study.methods.size(), options.quiet);
  std::size_t done = 0;
  const std::vector<Row> rows = mpm::compare(
      [&](std::span<const std::string> settings) {
        return options.problem.read({settings.begin(), settings.end()});
      },
      study,
      [&](const std::string&) {
        progress.advance(done);
        done = 1;
      });
  print_table(rows);
  with_exit_code(no_output, [&] {
    if (!options.out.empty()) write_table(options.out, rows);
    if (!options.picture.empty())
      draw_comparison(options.picture, rows, column_named(options.against, rows),
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
  command->add_option("--out", options->out, ".csv for the table")->type_name("FILE");
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
