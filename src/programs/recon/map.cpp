// recon map FILE: fields at the nodes of a grid, or at points of one's own.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "csv_table.hpp"
#include "mapping.hpp"
#include "outputs.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "recon/io/read.hpp"
#include "recon/io/write.hpp"
#include "slice_picture.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

struct MapOptions {
  InputOptions input;
  FitChoice fit;
  PictureOptions picture;
  std::string method = "imls", fields, targets = "grid";
  std::vector<std::string> components, outputs;
  std::optional<double> spacing;
  bool gradient = false, quiet = false;
};

// Where the fields are wanted: a grid, or the points of a file.
struct Targets {
  bool is_grid = true;
  StructuredGrid<double> grid;
  StructuredGrid<double>::Nodes nodes;
  ParticleTable table;
  PointsView<double> points;  // refers to nodes or table
  std::string description;
};

// The results are kept until they are written: better to say so than to be ended by the system.
void check_memory(const StructuredGrid<double>& grid, const FieldPlan& plan, bool gradient) {
  double numbers = 2 * grid.dimension + 14;  // coordinates, reports
  for (const PlannedField& field : plan)
    numbers += 3 * std::max(1.0, static_cast<double>(field.columns.size())) *
               (gradient && !field.is_kernel_sum() ? 1 + grid.dimension : 1);
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
  check_memory(targets.grid, plan, options.gradient);
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

void read_targets(const MapOptions& options, const Particles& particles, Targets& targets) {
  targets.is_grid = false;
  targets.table = with_exit_code(wrong_input, [&] { return read_particles(options.targets); });
  if (targets.table.size() == 0) fail_input(targets.table.source + ": there are no targets");
  try {
    targets.points = targets.table.positions(particles.dimension);
  } catch (const InvalidArgument& error) {
    fail_input(options.targets + ": targets need coordinates in " +
               std::to_string(particles.dimension) + "-D, like the particles: " + error.what());
  }
  targets.description = counted(targets.points.size(), "point") + " of " + targets.table.source;
}

void check_options(const MapOptions& options) {
  if (options.outputs.empty() && options.picture.file.empty())
    fail_usage("nothing to write: name a file with --out (.vti, .vtp or .csv), --picture, or both");
  const bool grid = options.targets == "grid";
  if (!grid && options.spacing)
    fail_usage("--spacing is for a grid; --targets names points of a file");
  if (!grid && !options.picture.file.empty())
    fail_usage("--picture needs a grid of targets; --targets names points of a file");
  if (options.picture.file.empty() &&
      !(options.picture.slice.empty() && options.picture.fields.empty()))
    fail_usage("--slice and --show say what is drawn, but no file is named with --picture");
  std::vector<std::string> inputs{options.input.file};
  if (!grid) inputs.push_back(options.targets);
  check_outputs(options.outputs, options.picture.file, inputs, grid);
}

// What --show names must be among the fields that are written.
void check_shown(const MapOptions& options, const FieldPlan& plan, int dimension) {
  std::vector<std::string> names = report_names();
  for (const PlannedField& field : plan) {
    names.push_back(field.name);
    if (options.gradient)
      for (const std::string& gradient : gradient_names(field, dimension))
        names.push_back(gradient);
  }
  for (const std::string& name : split(options.picture.fields))
    if (const std::string wrong = one_of(names)(name); !wrong.empty())
      fail_usage("--show: " + wrong);
}

void write_outputs(const MapOptions& options, const Targets& targets, const Mapped& mapped) {
  for (const std::string& path : options.outputs) {
    if (path.ends_with(".csv"))
      write_csv_fields(path, targets.points, mapped.fields, mapped.reports);
    else if (targets.is_grid)
      write(path, targets.grid, mapped.fields);
    else
      write(path, targets.points, mapped.fields);
  }
}

void print_summary(const MapOptions& options, const Particles& particles, const FieldPlan& plan,
                   const Method& method, const Targets& targets, const Mapped& mapped,
                   double seconds) {
  std::printf("%s\n", particles.describe().c_str());
  print_remarks(particles.table);
  print_line("method", describe_method(method, options.fit));
  print_line("support", describe_support(options.fit, method, particles, has_sums(plan)));
  print_line("targets", targets.description);
  print_fit(mapped, options.fit);
  print_fields(mapped.fields);
  print_line("time", number(seconds, 2) + " s");
  std::string_view heading = "written";
  std::vector<std::string> files = options.outputs;
  if (!options.picture.file.empty()) files.push_back(options.picture.file);
  for (const std::string& path : files) {
    print_line(heading, path + " (" + file_size(path) + ")");
    heading = "";
  }
}

void run(const MapOptions& options) {
  if (options.input.file.empty()) fail_usage("map: the FILE is missing; see recon map --help");
  check_options(options);
  const Method method = read_method(options.method, options.fit);
  Particles particles = read_input(options.input);
  const FieldPlan plan = plan_fields(particles, options.fields, options.components);
  check_shown(options, plan, particles.dimension);
  const FitOptions fit = fit_options(options.fit, method, particles);
  Targets targets;
  if (options.targets == "grid")
    choose_grid(options, particles, plan, targets);
  else
    read_targets(options, particles, targets);
  Cut cut;
  if (!options.picture.file.empty()) cut = choose_cut(options.picture, particles, targets.grid);

  Progress progress("mapping", targets.points.size(), options.quiet);
  const Mapped mapped =
      map_fields(particles, plan, fit, targets.points, options.gradient, progress);
  with_exit_code(no_output, [&] {
    write_outputs(options, targets, mapped);
    if (!options.picture.file.empty())
      draw_fields(options.picture, cut, particles, targets.grid, mapped.fields);
  });
  if (!options.quiet)
    print_summary(options, particles, plan, method, targets, mapped, progress.seconds());
}

void add_target_options(CLI::App& app, MapOptions& options) {
  const std::string group = "Targets";
  app.add_option("--spacing", options.spacing,
                 "spacing of the grid, a length (default: near the mean spacing\n"
                 "of the particles). Nodes lie at whole multiples of it and\n"
                 "cover the particles; on periodic axes it is shrunk to fill the\n"
                 "period, and the last node, being the first again, is left out")
      ->type_name("H")
      ->check(positive_number())
      ->group(group);
  app.add_option("--bounds", options.input.bounds,
                 "the grid covers this box and not the particles'")
      ->type_name("XLO,XHI,...")
      ->group(group);
  app.add_option("--targets", options.targets,
                 "grid, or a file of points: x,y,z in columns as in FILE")
      ->type_name("FILE")
      ->capture_default_str()
      ->group(group);
}

void add_field_options(CLI::App& app, MapOptions& options) {
  const std::string group = "Fields";
  app.add_option("--fields", options.fields,
                 "columns to map, as in vx,vy,vz; all: every column but labels\n"
                 "and coordinates; and fields that are derived when no column\n"
                 "has the name:\n"
                 "velocity         vx,vy,vz as one vector\n"
                 "speed            of each particle, then mapped like a column\n"
                 "density          sum of mass * W over the particles, W the\n"
                 "                 weight with integral 1 over the support\n"
                 "number_density   the same with 1 for the mass\n"
                 "solid_fraction   the same with the volume of spheres (2-D:\n"
                 "                 discs) from the column radius or diameter\n"
                 "These sums are 0 where nothing is near; close to walls and\n"
                 "free surfaces they fall off over a support radius and are\n"
                 "not corrected for the empty part of the support")
      ->type_name("NAMES")
      ->join(',')
      ->group(group);
  app.add_option("--components", options.components,
                 "columns as one field of several components, as in\n"
                 "v=vx,vy,vz; may be given again")
      ->type_name("NAME=COLUMNS")
      ->allow_extra_args(false)
      ->group(group);
  app.add_flag("--gradient", options.gradient,
               "also the exact gradients: dvx_dx, dvx_dy, ... (not of the\n"
               "sums: density, number_density, solid_fraction)")
      ->group(group);
}

void add_output_options(CLI::App& app, MapOptions& options) {
  const std::string group = "Output";
  app.add_option("--out", options.outputs,
                 "file to write, may be given again: .vti (grid) or .vtp\n"
                 "(points) for ParaView, .csv for both. With the fields go\n"
                 "neighbours, rank, degree that is reproduced, status (full,\n"
                 "reduced, nearest, no_support, too_far; in VTK 0 to 4), and\n"
                 "limited: how many components of its values were limited")
      ->type_name("FILE")
      ->allow_extra_args(false)
      ->group(group);
  app.add_option("--picture", options.picture.file,
                 "draw a field: .png or .svg. A 3-D grid is cut by a plane")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--slice", options.picture.slice,
                 "the plane: the grid nodes nearest to it are drawn (default:\n"
                 "the middle of y, that is an x-z section)")
      ->type_name("AXIS=PLACE")
      ->group(group);
  app.add_option("--show", options.picture.fields,
                 "fields of the picture, side by side on one colour scale; also\n"
                 "degree, neighbours, ... (default: the first of --fields)")
      ->type_name("NAMES")
      ->group(group);
  app.add_flag("--quiet", options.quiet, "no summary and no progress")->group(group);
}

}  // namespace

Command add_map(CLI::App& app) {
  CLI::App* sub =
      app.add_subcommand("map", "Particle data to fields on a grid or at points of your own");
  const auto options = std::make_shared<MapOptions>();
  add_input_options(*sub, options->input);
  add_field_options(*sub, *options);
  add_target_options(*sub, *options);
  sub->add_option("--method", options->method, method_help)
      ->type_name("NAME")
      ->group("Reconstruction");
  add_fit_options(*sub, options->fit);
  add_output_options(*sub, *options);
  sub->footer(
      "Examples:\n"
      "  recon map examples/data/chute.dump.gz --fields vx,vy,vz --out chute.vti\n"
      "  recon map examples/data/chute.dump.gz --fields velocity,solid_fraction \\\n"
      "      --spacing 0.5 --radius 2 --out chute.vti --picture chute.png\n"
      "  recon map examples/data/chute.dump.gz --frame 0 --fields speed --method shepard \\\n"
      "      --slice z=3 --out speed.csv --picture speed.png");
  return [options] { run(*options); };
}

}  // namespace recon::program
