// recon map FILE: fields at the nodes of a grid, or at points of one's own.
#include <memory>

#include "commands.hpp"
#include "frames.hpp"
#include "json_summary.hpp"
#include "map_ranks.hpp"
#include "map_series.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

void run(const MapOptions& options, const Launch& launch) {
  Method method;
  launch.everyone().together([&] {
    if (options.input.file.empty()) fail_usage("map: the FILE is missing; see recon map --help");
    method = read_method(options.method, options.fit);
  });
  if (launch.has_ranks()) return map_on_ranks(options, method, launch);
  for (const std::string& out : options.outputs)
    if (out.ends_with(".pvti"))
      fail_usage("--out " + out +
                 ": several ranks write pieces and a file that names them, and this is one "
                 "process: name a .vti file");
  check_options(options);
  if (options.average) return map_average(options, method);
  if (is_series(options.input)) return map_series(options, method);
  const MapJob job = prepare(options, method, read_input(options.input));
  Progress progress("mapping", job.targets.points.size(), options.quiet);
  const Mapped mapped =
      map_fields(job.particles, job.plan, job.fit, job.targets.points, options.gradient, progress);
  const std::string beyond = write_outputs(options, job, mapped.fields, &mapped.reports);
  if (options.json) {
    Json summary = Json::object();
    set_summary(summary, options, method, job, mapped);
    summary.set("seconds", progress.seconds()).set("written", files_array(files_of(options)));
    summary.set("picture_note", beyond.empty() ? Json() : Json(beyond));
    return print_json(summary);
  }
  if (options.quiet || writes_to_pipe(options)) return;
  print_summary(options, method, job, mapped);
  print_line("time", number(progress.seconds(), 2) + " s");
  print_written(files_of(options), beyond);
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
                 "columns to map, as in vx,vy,vz (names with commas in double\n"
                 "quotes); all: every column but labels and coordinates; and\n"
                 "fields that are derived when no column has the name:\n"
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
                 "(points) for ParaView, .csv for both, - for CSV on the\n"
                 "standard output. With the fields go\n"
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
  app.add_option("--colours", options.picture.colours,
                 "ends of the colour scale, or all: the least and greatest value\n"
                 "(default: without a few outliers; what lies beyond is said)")
      ->type_name("LO,HI")
      ->group(group);
  app.add_flag("--average", options.average,
               "of several frames: the mean and the standard deviation of\n"
               "each field at each target (vx_mean, vx_std), over the frames\n"
               "in which it has a value (frames says how many), on the grid\n"
               "of the first frame or of --bounds. Without it each frame has\n"
               "its files, v_0000.vti, v_0001.vti, ... and v.pvd, which lists\n"
               "them for ParaView")
      ->group(group);
  app.add_flag("--quiet", options.quiet, "no summary and no progress")->group(group);
  add_json_option(app, options.json, group);
}

}  // namespace

Command add_map(CLI::App& app, const Launch& launch) {
  CLI::App* sub =
      app.add_subcommand("map", "Particle data to fields on a grid or at points of your own");
  const auto options = std::make_shared<MapOptions>();
  add_input_options(*sub, options->input);
  add_field_options(*sub, *options);
  add_target_options(*sub, *options);
  sub->add_option("--method", options->method, method_help)
      ->type_name("NAME")
      ->check(such_as(method_names()))
      ->group("Reconstruction");
  add_fit_options(*sub, options->fit);
  add_output_options(*sub, *options);
  sub->footer(
      "Examples:\n"
      "  recon map examples/data/chute.dump.gz --fields vx,vy,vz --out chute.vti\n"
      "  recon map examples/data/chute.dump.gz --fields velocity,solid_fraction \\\n"
      "      --spacing 0.5 --radius 2 --out chute.vti --picture chute.png\n"
      "  recon map examples/data/chute.dump.gz --frame 0 --fields speed --method shepard \\\n"
      "      --slice z=3 --out speed.csv --picture speed.png\n"
      "On several ranks, each of which reads a part of the particles (where the program was\n"
      "built with RECON_BUILD_PETSC):\n"
      "  mpirun -n 4 recon map FILE --fields vx --spacing H --k 20 \\\n"
      "      --max-distance none --out v.pvti");
  return [options, &launch] { run(*options, launch); };
}

}  // namespace recon::program
