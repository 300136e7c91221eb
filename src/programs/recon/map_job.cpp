#include "map_job.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <variant>

#include "csv_table.hpp"
#include "embedding.hpp"
#include "frames.hpp"
#include "json_summary.hpp"
#include "outputs.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "source.hpp"
#include "sum_check.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

// The results are kept until they are written: better to say so than to be ended by the system.
void check_memory(const StructuredGrid<double>& grid, const FieldPlan& plan,
                  const MapOptions& options) {
  double numbers = 2 * grid.dimension + 18;  // coordinates, reports
  for (const PlannedField& field : plan)
    numbers += 3 * std::max(1.0, static_cast<double>(field.columns.size())) *
               (options.gradient && !field.is_kernel_sum() ? 1 + grid.dimension : 1) *
               (options.average ? 2 : 1);
  const double needed = numbers * sizeof(double) * static_cast<double>(grid.size());
  const double there =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (needed > there)
    fail_usage("a grid of " + counted(grid.size(), "node") + " needs about " +
               number(needed / 1e9, 2) + " GB of memory, this machine has " +
               number(there / 1e9, 2) + " GB; a larger --spacing or narrower --bounds needs less");
}

void choose_grid(const MapOptions& options, const Particles& particles, const FieldPlan& plan,
                 Targets& targets) {
  const double spacing = options.spacing ? *options.spacing : suggested_spacing(particles);
  targets.grid = with_exit_code(
      wrong_usage, [&] { return covering_grid(particles.region, spacing, particles.grid_domain); });
  check_memory(targets.grid, plan, options);
  targets.nodes = targets.grid.nodes();
  targets.points = targets.nodes.view();
  std::string counts, spacings;
  bool same = true;
  for (int d = 0; d < targets.grid.dimension; ++d) {
    counts += (d > 0 ? " x " : "") + std::to_string(targets.grid.counts[d]);
    spacings += (d > 0 ? " x " : "") + number(targets.grid.spacing[d]);
    same = same && targets.grid.spacing[d] == targets.grid.spacing[0];
  }
  targets.description = "grid of " + counts + " = " + counted(targets.points.size(), "node") +
                        ", spacing " + (same ? number(targets.grid.spacing[0]) : spacings);
  if (!options.spacing) targets.description += " (chosen; --spacing changes it)";
}

// Targets have their coordinates in columns of the same names as the particles or, if these are
// not there, along the same axes.
void choose_like(const Particles& particles, ParticleTable& targets) {
  std::vector<std::string> columns;
  for (const std::string& name : particles.axes)
    if (targets.has(name)) columns.push_back(name);
  if (columns.size() != particles.axes.size()) {
    columns.clear();
    for (const char letter : particles.letters)
      for (const std::string& name : targets.all_coordinates())
        if (axis_of_coordinate(name) == letter - 'x') columns.push_back(name);
  }
  if (columns.size() == particles.axes.size()) targets.set_coordinates(columns);
}

void read_targets(const MapOptions& options, const Particles& particles, Targets& targets) {
  targets.is_grid = false;
  targets.table = with_exit_code(wrong_input, [&] { return read_source(options.targets, {}); });
  if (targets.table.size() == 0) fail_input(targets.table.source + ": there are no targets");
  try {
    choose_like(particles, targets.table);
    targets.points = targets.table.positions(particles.dimension);
  } catch (const InvalidArgument& error) {
    fail_input(options.targets + ": targets need coordinates in " +
               std::to_string(particles.dimension) + "-D, like the particles: " + error.what());
  }
  targets.description = counted(targets.points.size(), "point") + " of " + targets.table.source;
}

// What --show names must be among the fields that are written.
void check_shown(const MapOptions& options, const FieldPlan& plan, const std::string& letters) {
  std::vector<std::string> names = report_names();
  if (options.average) names = {"frames", "frames_full"};
  const auto add = [&](const std::string& name) {
    if (!options.average) return names.push_back(name);
    for (const char* part : {"_mean", "_std"}) names.push_back(name + part);
  };
  for (const PlannedField& field : plan) {
    add(field.name);
    if (options.gradient)
      for (const std::string& gradient : gradient_names(field, letters)) add(gradient);
  }
  for (const std::string& name : split(options.picture.fields))
    if (const std::string wrong = one_of(names)(name); !wrong.empty())
      fail_usage("--show: " + wrong);
}

}  // namespace

void check_options(const MapOptions& options) {
  if (options.outputs.empty() && options.picture.file.empty())
    fail_usage("nothing to write: name a file with --out (.vti, .vtp or .csv), --picture, or both");
  const bool grid = options.targets == "grid";
  if (!grid && options.spacing)
    fail_usage("--spacing is for a grid; --targets names points of a file");
  if (!grid && !options.picture.file.empty())
    fail_usage("--picture needs a grid of targets; --targets names points of a file");
  if (options.picture.file.empty() &&
      !(options.picture.slice.empty() && options.picture.fields.empty() &&
        options.picture.colours.empty()))
    fail_usage(
        "--slice, --show and --colours say what is drawn, but no file is named with --picture");
  const bool to_pipe = writes_to_pipe(options);
  if (to_pipe && is_series(options.input) && !options.average)
    fail_usage("--out -: a series of frames has a file for each; choose one frame, or --average");
  if (to_pipe && options.json)
    fail_usage("--out - and --json both write to the standard output: choose one");
  if (options.average && !is_series(options.input))
    fail_usage("--average needs several frames: --frame all, a range of frames, or several files");
  check_outputs(options.outputs, options.picture.file, inputs_of(options), grid);
}

MapJob prepare(const MapOptions& options, const Method& method, Particles particles) {
  MapJob job;
  job.particles = std::move(particles);
  check_weight_by(options.fit, job.particles);
  job.plan = plan_fields(job.particles, options.fields, options.components);
  check_shown(options, job.plan, job.particles.letters);
  job.fit = fit_options(options.fit, method, job.particles);
  if (options.targets == "grid")
    choose_grid(options, job.particles, job.plan, job.targets);
  else
    read_targets(options, job.particles, job.targets);
  if (!options.picture.file.empty())
    job.cut = choose_cut(options.picture, job.particles, job.targets.grid);
  return job;
}

std::string write_outputs(const MapOptions& options, const MapJob& job, const FieldSet& fields,
                          const FitReports* reports) {
  const std::string& letters = job.particles.letters;
  return with_exit_code(no_output, [&]() -> std::string {
    for (const std::string& output : options.outputs) {
      OutputPlace place(output);
      const std::string path = place.path();
      const bool csv = output == "-" || output.ends_with(".csv");
      if (csv && reports != nullptr)
        write_csv_fields(path, job.targets.points, letters, fields, *reports);
      else if (csv)
        write_csv_fields(path, job.targets.points, letters, fields);
      else if (job.targets.is_grid)
        write_embedded(path, job.particles, job.targets.grid, fields);
      else
        write_embedded(path, job.particles, job.targets.points, fields);
      place.send();
    }
    if (options.picture.file.empty()) return "";
    return draw_fields(options.picture, job.cut, job.particles, job.targets.grid, fields);
  });
}

bool writes_to_pipe(const MapOptions& options) {
  return std::find(options.outputs.begin(), options.outputs.end(), "-") != options.outputs.end();
}

std::vector<std::string> inputs_of(const MapOptions& options) {
  std::vector<std::string> inputs{options.input.file};
  inputs.insert(inputs.end(), options.input.more_files.begin(), options.input.more_files.end());
  if (options.targets != "grid") inputs.push_back(options.targets);
  return inputs;
}

std::vector<std::string> files_of(const MapOptions& options) {
  std::vector<std::string> files = options.outputs;
  if (!options.picture.file.empty()) files.push_back(options.picture.file);
  return files;
}

namespace {

// The radius of kernel sums, where it is the same at all targets.
std::optional<double> sum_radius(const FitOptions& fit) {
  const auto* rule = std::get_if<Radius>(&*fit.neighbours);
  return rule == nullptr ? fit.sum_radius : rule->radius;
}

std::vector<SumCheck> sums_of(const MapJob& job, const Mapped& mapped) {
  return check_sums(job.plan, job.particles, job.targets.grid, mapped.fields, sum_radius(job.fit));
}

}  // namespace

void print_summary(const MapOptions& options, const Method& method, const MapJob& job,
                   const Mapped& mapped) {
  std::printf("%s\n", job.particles.describe().c_str());
  print_remarks(job.particles.table);
  print_line("method", describe_method(method, options.fit));
  print_line("support", describe_support(options.fit, method, job.particles, has_sums(job.plan)));
  print_line("targets", job.targets.description);
  print_fit(mapped, options.fit);
  print_fields(mapped.fields);
  if (job.targets.is_grid) print_sums(sums_of(job, mapped), job.targets.grid, sum_radius(job.fit));
}

void set_summary(Json& object, const MapOptions& options, const Method& method, const MapJob& job,
                 const Mapped& mapped) {
  set_particles(object, job.particles);
  object.set("method", method_object(method, options.fit,
                                     describe_support(options.fit, method, job.particles,
                                                      has_sums(job.plan))));
  object.set("targets", targets_object(job.targets));
  set_fit(object, mapped, options.fit);
  object.set("fields", fields_array(mapped.fields));
  if (!job.targets.is_grid) return;
  Json sums = Json::array();
  for (const SumCheck& check : sums_of(job, mapped)) {
    Json one = Json::object().set("name", check.name);
    one.set("over_grid", check.over_grid ? Json(*check.over_grid) : Json());
    one.set("of_particles", check.of_particles ? Json(*check.of_particles) : Json());
    sums.push(one.set("small_support", check.small_support));
  }
  object.set("sums", sums);
}

void print_written(const std::vector<std::string>& files, const std::string& beyond) {
  std::string_view heading = "written";
  for (const std::string& path : files) {
    print_line(heading, path + " (" + file_size(path) + ")");
    heading = "";
  }
  if (!beyond.empty()) print_line("", beyond);
}

}  // namespace recon::program
