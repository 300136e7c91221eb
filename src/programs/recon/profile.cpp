// recon profile FILE: how fields change along an axis, by one method or several side by side.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "csv_table.hpp"
#include "json_summary.hpp"
#include "mapping.hpp"
#include "outputs.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "recon/io/picture.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

struct ProfileOptions {
  InputOptions input;
  FitChoice fit;
  std::string axis = "z", fields, methods = "imls", out, picture, levels;
  std::optional<double> spacing, across;
  bool quiet = false, json = false;
};

// Planes of targets normal to the axis.
struct Planes {
  int axis = 2;
  StructuredGrid<double> grid;
  std::size_t levels() const { return grid.counts[axis]; }
  std::size_t level_of(std::size_t node) const { return grid.index(node)[axis]; }
};

// A curve of the profile: one number per level, NaN where no target of the level has a value.
struct Column {
  std::string name;
  std::string label;  // in the picture; not drawn if empty
  std::vector<double> values;
};

Planes choose_planes(const ProfileOptions& options, const Particles& particles) {
  Planes planes;
  planes.axis = particles.axis(options.axis, "--axis");
  Box<double> region = particles.region;
  PeriodicDomain<double> domain = particles.grid_domain;
  if (!options.levels.empty()) {
    const std::vector<std::string> ends = split(options.levels);
    const auto lower = ends.size() == 2 ? to_number(ends[0]) : std::nullopt;
    const auto upper = ends.size() == 2 ? to_number(ends[1]) : std::nullopt;
    if (!lower || !upper || !(*lower < *upper))
      fail_usage("--range " + options.levels + ": two numbers are needed, as in 0,12");
    region.lower[planes.axis] = *lower;
    region.upper[planes.axis] = *upper;
    domain.periodic[planes.axis] = false;
  }
  const double suggested = options.spacing && options.across ? 0 : suggested_spacing(particles);
  with_exit_code(wrong_usage, [&] {
    planes.grid = covering_grid(region, options.across.value_or(suggested), domain);
    const auto along = covering_grid(region, options.spacing.value_or(suggested / 4), domain);
    planes.grid.origin[planes.axis] = along.origin[planes.axis];
    planes.grid.spacing[planes.axis] = along.spacing[planes.axis];
    planes.grid.counts[planes.axis] = along.counts[planes.axis];
    planes.grid.validate();
  });
  return planes;
}

// Means over the planes, of the numbers that are not NaN.
std::vector<double> plane_means(const Planes& planes, const FieldView<double>& values,
                                int component) {
  std::vector<double> sums(planes.levels(), 0.0), counts(planes.levels(), 0.0);
  for (std::size_t node = 0; node < values.size(); ++node) {
    const double value = values(node, component);
    if (std::isnan(value)) continue;
    sums[planes.level_of(node)] += value;
    counts[planes.level_of(node)] += 1;
  }
  for (std::size_t level = 0; level < sums.size(); ++level) sums[level] /= counts[level];
  return sums;
}

// The share of each plane's targets that `holds` is true of.
template <class Predicate>
std::vector<double> plane_shares(const Planes& planes, const FitReports& reports, Predicate holds) {
  std::vector<double> shares(planes.levels(), 0.0);
  for (std::size_t node = 0; node < reports.size(); ++node)
    if (holds(reports[node])) shares[planes.level_of(node)] += 1;
  for (double& share : shares) share /= static_cast<double>(planes.grid.size() / planes.levels());
  return shares;
}

std::string column_suffix(const Method& method, const std::string& text) {
  return text.find(':') == std::string::npos ? method.name
                                             : method.name + "_" + std::to_string(method.degree);
}

class ProfileTable {
 public:
  ProfileTable(const Planes& planes, const FieldPlan& plan) : planes_(planes), plan_(plan) {}

  void add(const Mapped& mapped, const Method& method, const std::string& suffix, bool first) {
    for (const PlannedField& planned : plan_) {
      if (planned.is_kernel_sum() && !first) continue;  // these do not depend on the method
      const NamedField& field = mapped.fields[planned.name];
      for (int c = 0; c < field.components; ++c) {
        const std::string name = field.name + component_suffix(field, c, planes_.grid.dimension);
        const std::string label = method.name + ", degree " + std::to_string(method.degree);
        const bool sum = planned.is_kernel_sum();
        columns_.push_back({sum ? name : name + "_" + suffix,
                            sum                        ? name
                            : columns_per_method() > 1 ? name + ", " + label
                                                       : label,
                            plane_means(planes_, field.view(), c)});
      }
    }
    const auto share = [&](const std::string& name, auto holds) {
      reports_.push_back({name, "", plane_shares(planes_, mapped.reports, holds)});
    };
    if (first)
      share("supported", [](const FitReport& r) {
        return r.status == FitStatus::full || r.status == FitStatus::reduced;
      });
    share("full_" + suffix, [](const FitReport& r) { return r.status == FitStatus::full; });
  }

  // The levels, the fields by method, the shares of targets that are supported and fully fitted.
  void write(const std::string& path, const std::string& axis) const {
    std::vector<double> levels;
    for (std::size_t i = 0; i < planes_.levels(); ++i)
      levels.push_back(planes_.grid.coordinate(i, planes_.axis));
    std::vector<CsvColumn> columns{number_column(axis, levels)};
    for (const Column& column : columns_)
      columns.push_back(number_column(column.name, column.values));
    for (const Column& column : reports_)
      columns.push_back(number_column(column.name, column.values));
    write_csv_table(path, columns, levels.size());
  }

  // Values to the right, the axis upwards: as one looks at a depth profile.
  void draw_to(const std::string& path, const std::string& title, const std::string& axis) const {
    LinePlot plot;
    plot.title = title;
    plot.y_label = axis;
    plot.x_label = "mean over planes";
    if (columns_per_method() == 1) plot.x_label = plan_.front().name + ", mean over planes";
    for (const Column& column : columns_) {
      Curve curve;
      curve.name = column.label;
      for (std::size_t i = 0; i < column.values.size(); ++i) {
        curve.x.push_back(column.values[i]);  // NaN: a gap
        curve.y.push_back(planes_.grid.coordinate(i, planes_.axis));
      }
      plot.curves.push_back(std::move(curve));
    }
    draw(path, plot);
  }

  const std::vector<Column>& columns() const { return columns_; }

 private:
  std::size_t columns_per_method() const {
    std::size_t count = 0;
    for (const PlannedField& field : plan_) count += std::max<std::size_t>(1, field.columns.size());
    return count;
  }

  const Planes& planes_;
  const FieldPlan& plan_;
  std::vector<Column> columns_, reports_;
};

void print_ends(const Planes& planes, const ProfileTable& table, const std::string& axis) {
  std::size_t width = 0;
  for (const Column& column : table.columns()) width = std::max(width, column.name.size());
  std::string_view heading = "means";
  for (const Column& column : table.columns()) {
    std::string name = column.name;
    name.resize(width + 2, ' ');
    std::size_t first = 0, last = column.values.size();
    while (first < last && std::isnan(column.values[first])) ++first;
    while (last > first && std::isnan(column.values[last - 1])) --last;
    if (first == last) {
      print_line(heading, name + "no value on any level");
      continue;
    }
    const auto place = [&](std::size_t level) {
      return planes.grid.coordinate(level, planes.axis);
    };
    const auto at = [&](std::size_t level) {
      return number(column.values[level]) + " at " + axis + " = " +
             number_within(place(level), place(0), place(planes.levels() - 1));
    };
    std::size_t middle = (first + last - 1) / 2;
    while (std::isnan(column.values[middle])) --middle;
    print_line(heading, name + at(first) + ", " + at(middle) + ", " + at(last - 1));
    heading = "";
  }
}

Json levels_of(const Planes& planes) {
  Json levels = Json::array();
  for (std::size_t i = 0; i < planes.levels(); ++i)
    levels.push(planes.grid.coordinate(i, planes.axis));
  return levels;
}

// Of each column, a number for every level.
Json means_object(const ProfileTable& table) {
  Json means = Json::object();
  for (const Column& column : table.columns())
    means.set(column.name, Json::array_of(column.values));
  return means;
}

void run(const ProfileOptions& options) {
  if (options.input.file.empty())
    fail_usage("profile: the FILE is missing; see recon profile --help");
  if (options.out.empty() && options.picture.empty())
    fail_usage("nothing to write: name a file with --out (.csv), --picture, or both");
  std::vector<std::string> outputs;
  if (!options.out.empty()) outputs.push_back(options.out);
  check_outputs(outputs, options.picture, {options.input.file}, true, true);
  std::vector<Method> methods;
  const std::vector<std::string> texts = split(options.methods);
  for (const std::string& text : texts) {
    // --degree is meant for the methods that have one
    methods.push_back(text == "shepard" ? Method{text, 0, Solver::gram_schmidt}
                                        : read_method(text, options.fit));
    for (std::size_t i = 0; i + 1 < methods.size(); ++i)
      if (texts[i] == text) fail_usage("--methods names " + text + " twice");
  }
  Particles particles = read_input(options.input);
  check_weight_by(options.fit, particles);
  const FieldPlan plan = plan_fields(particles, options.fields, {});
  const Planes planes = choose_planes(options, particles);
  const auto nodes = planes.grid.nodes();
  const std::string axis = particles.axes[planes.axis];

  const bool prints = !options.quiet && !options.json;
  if (prints) {
    std::printf("%s\n", particles.describe().c_str());
    print_remarks(particles.table);
    print_line("targets", counted(planes.levels(), "level") + " along " + axis + ", spacing " +
                              number(planes.grid.spacing[planes.axis]) + ", each with " +
                              counted(planes.grid.size() / planes.levels(), "target"));
  }
  Progress progress("profile", planes.grid.size() * methods.size(), options.quiet);
  ProfileTable table(planes, plan);
  Json fits = Json::array();
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const FitOptions fit = fit_options(options.fit, methods[m], particles);
    const Mapped mapped = map_fields(particles, plan, fit, nodes.view(), false, progress);
    table.add(mapped, methods[m], column_suffix(methods[m], texts[m]), m == 0);
    const std::string support =
        describe_support(options.fit, methods[m], particles, has_sums(plan));
    Json one = Json::object().set("method", method_object(methods[m], options.fit, support));
    set_fit(one, mapped, options.fit);
    fits.push(one);
    if (!prints) continue;
    std::printf("\n");
    print_line("method", describe_method(methods[m], options.fit));
    print_line("support", support);
    print_fit(mapped, options.fit);
  }
  with_exit_code(no_output, [&] {
    if (!options.out.empty()) table.write(options.out, axis);
    if (!options.picture.empty()) table.draw_to(options.picture, particles.table.source, axis);
  });
  std::vector<std::string> files;
  for (const std::string& file : {options.out, options.picture})
    if (!file.empty()) files.push_back(file);
  if (options.json) {
    Json summary = Json::object();
    set_particles(summary, particles);
    summary.set("axis", axis).set("levels", levels_of(planes));
    summary.set("spacing", planes.grid.spacing[planes.axis]);
    summary.set("targets_per_level", planes.grid.size() / planes.levels());
    summary.set("methods", fits).set("means", means_object(table));
    summary.set("seconds", progress.seconds()).set("written", files_array(files));
    return print_json(summary);
  }
  if (!prints) return;
  std::printf("\n");
  print_ends(planes, table, axis);
  print_line("time", number(progress.seconds(), 2) + " s");
  print_written(files, "");
}

void add_profile_options(CLI::App& app, ProfileOptions& options) {
  app.add_option("--fields", options.fields,
                 "columns or derived fields, as in vx,solid_fraction; see\n"
                 "recon map --help")
      ->type_name("NAMES")
      ->join(',')
      ->group("Fields");
  const std::string group = "Targets";
  app.add_option("--axis", options.axis, "the axis of the profile")
      ->type_name("AXIS")
      ->capture_default_str()
      ->group(group);
  app.add_option("--spacing", options.spacing,
                 "distance of the planes along the axis (default: a quarter of\n"
                 "the mean spacing of the particles)")
      ->type_name("H")
      ->check(positive_number())
      ->group(group);
  app.add_option("--across", options.across,
                 "spacing of the targets in a plane (default: near the mean\n"
                 "spacing)")
      ->type_name("H")
      ->check(positive_number())
      ->group(group);
  app.add_option("--range", options.levels,
                 "planes from LO to HI (default: where the particles are)")
      ->type_name("LO,HI")
      ->group(group);
  app.add_option("--bounds", options.input.bounds,
                 "the planes cover this box and not the particles'")
      ->type_name("XLO,XHI,...")
      ->group(group);
}

}  // namespace

Command add_profile(CLI::App& app) {
  CLI::App* sub = app.add_subcommand(
      "profile", "Fields along an axis, averaged over planes, by several methods");
  const auto options = std::make_shared<ProfileOptions>();
  add_input_options(*sub, options->input);
  add_profile_options(*sub, *options);
  sub->add_option("--methods", options->methods,
                  "methods to compare, as in shepard,mls,imls or, with degrees\n"
                  "of their own, imls:1,imls:2\n" +
                      std::string(method_help))
      ->type_name("NAMES")
      ->capture_default_str()
      ->group("Reconstruction");
  // A profile is read at walls, where no value lies between its data.
  options->fit.limit = "none";
  options->fit.leverage = 5;
  add_fit_options(*sub, options->fit);
  const std::string group = "Output";
  sub->add_option("--out", options->out,
                  ".csv with a line per plane: its place, each field by each\n"
                  "method (vx_imls), the share of targets with support, and for\n"
                  "each method the share that reaches the full degree. A mean is\n"
                  "over the targets that have a value; nan where none has")
      ->type_name("FILE")
      ->group(group);
  sub->add_option("--picture", options->picture, "draw the curves: .png or .svg")
      ->type_name("FILE")
      ->group(group);
  sub->add_flag("--quiet", options->quiet, "no summary and no progress")->group(group);
  add_json_option(*sub, options->json, group);
  sub->footer(
      "Example:\n"
      "  recon profile examples/data/chute.dump.gz --fields vx --methods shepard,mls,imls \\\n"
      "      --radius 2 --range 0,8 --out profile.csv --picture profile.png");
  return [options] { run(*options); };
}

}  // namespace recon::program
