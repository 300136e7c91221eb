#include "particles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "frames.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/basis/monomials.hpp"
#include "recon/core/names.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"
#include "source.hpp"
#include "where.hpp"

namespace recon::program {

namespace {

constexpr std::array<const char*, max_dimension> axis_names{"x", "y", "z"};

// The least and the greatest number of a column of all particles; NaN where one is NaN.
struct ColumnRange {
  double least, greatest;
  bool is_one() const { return least == greatest; }
};
ColumnRange range_of_column(const Everyone& everyone, const std::vector<double>& values) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  ColumnRange range{infinity, -infinity};
  std::size_t not_numbers = 0;
  for (const double value : values) {
    range.least = std::min(range.least, value);
    range.greatest = std::max(range.greatest, value);
    not_numbers += std::isnan(value) ? 1 : 0;
  }
  range = {everyone.least(range.least), everyone.greatest(range.greatest)};
  if (everyone.sum(not_numbers) > 0) range = {std::nan(""), std::nan("")};
  return range;
}

std::vector<LeftOut> find_left_out(const Everyone& everyone, const ParticleTable& table,
                                   const std::vector<std::string>& all,
                                   const std::vector<std::string>& used) {
  std::vector<LeftOut> found;
  for (const std::string& name : all) {
    if (std::find(used.begin(), used.end(), name) != used.end()) continue;
    const ColumnRange range = range_of_column(everyone, table.raw_column(name));
    found.push_back({name, axis_of_coordinate(name), {}});
    if (range.is_one()) found.back().place = range.least;
  }
  return found;
}

void keep_where(const InputOptions& options, const Everyone& everyone, ParticleTable& table) {
  if (options.where.empty()) return;
  const std::size_t all = everyone.sum(table.size());
  everyone.together([&] { table.keep_rows(rows_where(options.where, table)); });
  const std::size_t kept = everyone.sum(table.size());
  everyone.together([&] {
    if (kept == 0)
      fail_usage("--where '" + options.where + "': is true of none of the " +
                 counted(all, "particle") + " of " + table.source);
  });
  table.remarks.push_back("where " + options.where + ": " + count(kept) + " of " +
                          counted(all, "particle"));
}

void choose_coordinates(const InputOptions& options, ParticleTable& table) {
  if (options.coordinates.empty()) return;
  const std::vector<std::string> columns = split(options.coordinates);
  for (const std::string& name : columns)
    if (!table.has(name))
      fail_usage("--coordinates: " + options.file + " has no column '" + name + "'; " +
                 suggest(name, table.names()));
  with_exit_code(wrong_usage, [&] { table.set_coordinates(columns); });
}

int choose_dimension(const InputOptions& options, const ParticleTable& table) {
  const int detected = with_exit_code(wrong_input, [&] { return table.dimension(); });
  if (options.dimension == 0) return detected;
  return with_exit_code(
      wrong_usage, [&] { return static_cast<int>(table.coordinates(options.dimension).size()); });
}

// The numbers of --bounds, or nothing where it is not given.
std::optional<Box<double>> read_bounds(const std::string& text, int dimension) {
  if (text.empty()) return {};
  const std::vector<std::string> words = split(text);
  if (words.size() != 2 * static_cast<std::size_t>(dimension))
    fail_usage("--bounds " + text + ": needs a lower and an upper bound for each of the " +
               std::to_string(dimension) + " axes, as in " +
               (dimension == 3   ? "0,1,0,1,0,1"
                : dimension == 2 ? "0,1,0,1"
                                 : "0,1"));
  Box<double> box = Box<double>::empty(dimension);
  for (int d = 0; d < dimension; ++d) {
    const auto lower = to_number(words[2 * d]), upper = to_number(words[2 * d + 1]);
    if (!lower || !upper || !(*lower < *upper))
      fail_usage("--bounds " + text + ": '" + words[2 * d] + "," + words[2 * d + 1] +
                 "' is not a lower and a greater upper bound");
    box.lower[d] = *lower;
    box.upper[d] = *upper;
  }
  return box;
}

PeriodicDomain<double> choose_domain(const InputOptions& options, const Particles& particles,
                                     const std::optional<Box<double>>& bounds) {
  PeriodicDomain<double> domain;
  if (options.periodic == "none") return domain;
  if (options.periodic == "from-file") return particles.table.domain(particles.dimension);
  const ParticleTable& table = particles.table;
  if (!table.has_box() && !bounds)
    fail_usage("--periodic " + options.periodic + ": " + options.file +
               " does not tell the box; say where the periods begin and end with --bounds");
  const PeriodicDomain<double> possible =
      table.has_box() ? table.possible_domain(particles.dimension)
                      : PeriodicDomain<double>{bounds->lower, bounds->upper};
  for (const std::string& name : split(options.periodic)) {
    const int axis = particles.axis(name, "--periodic");
    if (table.has_box() && !possible.periodic[axis])
      fail_usage("--periodic " + name + ": " + table.why_not_periodic(axis, particles.dimension));
    domain.periodic[axis] = true;
    domain.lower[axis] = possible.lower[axis];
    domain.upper[axis] = possible.upper[axis];
  }
  with_exit_code(wrong_usage, [&] { domain.validate(particles.dimension); });
  return domain;
}

// The spacing of a regular lattice that has as many points in this extent: along an axis of
// length L it has L / spacing of them where the axis is periodic, else one more. 0 for
// particles at one place.
double box_spacing(const Particles& particles) {
  const auto points = [&](double spacing) {
    double product = 1;
    for (int d = 0; d < particles.dimension; ++d)
      product *= particles.extent.extent(d) / spacing + (particles.domain.periodic[d] ? 0 : 1);
    return product;
  };
  double longest = 0;
  for (int d = 0; d < particles.dimension; ++d)
    longest = std::max(longest, particles.extent.extent(d));
  const double wanted = static_cast<double>(particles.in_all);
  if (!(longest > 0) || (wanted == 1 && !particles.domain.any())) return 0;
  double least = longest * 1e-12, greatest = longest * 2;
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(least) * std::sqrt(greatest);
    (points(middle) > wanted ? least : greatest) = middle;
  }
  return greatest;
}

constexpr std::array<double, max_dimension> unit_ball{2, std::numbers::pi,
                                                      4 * std::numbers::pi / 3};

// The spacing of a lattice as dense as the particles are where they are: by the median over the
// particles of the distance to the k-th neighbour, k = D (D + 1), whose ball holds k spacings^D. 0
// where most coincide.
double local_spacing(const Particles& particles) {
  const int dimension = particles.dimension;
  const std::size_t k = static_cast<std::size_t>(dimension * (dimension + 1));
  if (particles.size() < 2) return 0;
  const PointCloud<double> cloud(particles.positions(), "particles", particles.domain);
  constexpr double factor = 2;
  auto reach = find_neighbours(cloud, cloud, Nearest{k + 1, factor}, particles.domain).support;
  const auto middle = reach.begin() + static_cast<std::ptrdiff_t>(reach.size() / 2);
  std::nth_element(reach.begin(), middle, reach.end());
  return *middle / factor *
         std::pow(unit_ball[dimension - 1] / static_cast<double>(k), 1.0 / dimension);
}

}  // namespace

int Particles::axis(std::string_view name, const std::string& option) const {
  for (int d = 0; d < dimension; ++d)
    if (axes[d] == name) return d;
  for (int d = 0; d < dimension; ++d)
    if (axis_names[d] == name) return d;
  fail_usage(option + ": '" + std::string(name) + "' is no axis of these particles; " +
             suggest(name, axes));
}

std::string Particles::describe() const {
  std::vector<std::string> periodic;
  for (int d = 0; d < dimension; ++d)
    if (domain.periodic[d]) periodic.push_back(axes[d]);
  std::string text = table.source;
  if (table.time) text += ", time " + number(*table.time, 10);
  text += ": " + counted(in_all, "particle") + " in " + std::to_string(dimension) + "-D";
  if (!left_out.empty()) {
    text += " (" + enumeration(axes);
    for (const LeftOut& each : left_out)
      text += "; " + each.name +
              (each.place ? " = " + number(*each.place, 10) + " for all" : " left out");
    text += ")";
  }
  return periodic.empty() ? text : text + ", periodic in " + enumeration(periodic);
}

void add_file_options(CLI::App& app, InputOptions& options) {
  const std::string group = "Particles";
  const auto take_files = [&options](const std::vector<std::string>& files) {
    options.file = files.front();
    options.more_files.assign(files.begin() + 1, files.end());
  };
  app.add_option_function<std::vector<std::string>>(
         "FILE", take_files,
         "LAMMPS text dump, delimited text with a line of column names,\n"
         "XYZ (plain or extended), VTK (legacy or XML), HDF5 (H5MD or\n"
         "openPMD); any may be gzipped; - is the standard input. Several\n"
         "files (of map and convert) make a series")
      ->type_name(" ");
  const auto take_frame = [&options](const std::string& text) {
    if (const auto number = to_number(text))
      options.frame = static_cast<int>(*number);
    else
      options.frames = text;
  };
  app.add_option_function<std::string>(
         "--frame", take_frame,
         "frame of the file, from 0; from the end -1, -2, ... (default\n"
         "-1). A series (of map): all, or FIRST:LAST, as in 0:10 or\n"
         "-5:, and 0:100:10 for every tenth")
      ->type_name("N")
      ->check(check_frame_text)
      ->group(group);
  app.add_option("--where", options.where,
                 "only particles of which this is true, as in\n"
                 "'type == 2 and z > 1': columns by name (in backticks where\n"
                 "needed), numbers, + - * / ^, comparisons, and, or, not, sqrt,\n"
                 "abs, min, max, sin, ...")
      ->type_name("CONDITION")
      ->group(group);
  app.add_option("--step", options.step, "or the frame of this step")
      ->type_name("STEP")
      ->excludes("--frame")
      ->check(whole_number(std::nullopt, 9e15))
      ->group(group);
  app.add_option("--time", options.time, "or the frame of this time")
      ->type_name("TIME")
      ->excludes("--frame")
      ->excludes("--step")
      ->check(finite_number())
      ->group(group);
  app.add_option("--group", options.group,
                 "in HDF5 the group of particles (openPMD: the species), where\n"
                 "there are several")
      ->type_name("NAME")
      ->group(group);
  app.add_option("--columns", options.columns,
                 "names of all columns, as in x,y,v, for a file without\n"
                 "names or in place of its own")
      ->type_name("NAMES")
      ->group(group);
  app.add_option("--skip-rows", options.skip_rows,
                 "lines at the beginning of the file to pass over")
      ->type_name("N")
      ->check(whole_number(0))
      ->group(group);
  app.add_option("--missing", options.missing,
                 "what stands for 'no value', as -9999 or NA or '' (an empty\n"
                 "cell); may be given again. Particles without a value in a\n"
                 "column that is used are left out, and counted in a note")
      ->type_name("TEXT")
      ->allow_extra_args(false)
      ->group(group);
  app.add_option("--coordinates", options.coordinates,
                 "columns that hold the coordinates, if not x,y,z")
      ->type_name("NAMES")
      ->group(group);
}

void add_input_options(CLI::App& app, InputOptions& options) {
  const std::string group = "Particles";
  add_file_options(app, options);
  app.add_option("--periodic", options.periodic,
                 "periodic axes: from-file (the boundary flags of LAMMPS),\n"
                 "none, or axes like x,y, whose periods are those of the\n"
                 "file's box or else of --bounds")
      ->type_name("AXES")
      ->capture_default_str()
      ->group(group);
  app.add_option("--dimension", options.dimension,
                 "2 or 3 (or 1), if not as detected: a coordinate that is the\n"
                 "same for all particles does not count; 2 leaves z out of\n"
                 "account, 3 takes all")
      ->type_name("D")
      ->check(digit('1', '3'))
      ->group(group);
}

namespace {

// Where the particles are, what is periodic, how dense they are.
void measure(Particles& particles) {
  const InputOptions& options = particles.options;
  const Everyone& everyone = *particles.everyone;
  particles.in_all = everyone.sum(particles.size());
  std::optional<Box<double>> bounds;
  everyone.together([&] {
    const auto positions = with_exit_code(wrong_input, [&] { return particles.positions(); });
    particles.extent = Box<double>::empty(particles.dimension);
    if (particles.size() > 0) particles.extent = bounding_box(positions, "particles");
    bounds = read_bounds(options.bounds, particles.dimension);
    particles.domain = choose_domain(options, particles, bounds);
  });
  for (int d = 0; d < particles.dimension; ++d) {
    particles.extent.lower[d] = everyone.least(particles.extent.lower[d]);
    particles.extent.upper[d] = everyone.greatest(particles.extent.upper[d]);
    if (!particles.domain.periodic[d]) continue;
    particles.extent.lower[d] = particles.domain.lower[d];
    particles.extent.upper[d] = particles.domain.upper[d];
  }
  if (everyone.size() == 1) {
    particles.spacing = particles.box_spacing = box_spacing(particles);
    // Where particles fill their box the two agree, up to what borders and chance do.
    if (const double local = local_spacing(particles); local > 0 && local < 0.8 * particles.spacing)
      particles.spacing = local;
  }
  particles.region = bounds.value_or(particles.extent);
  particles.grid_domain = particles.domain;
  for (int d = 0; d < particles.dimension; ++d)
    if (particles.region.lower[d] != particles.extent.lower[d] ||
        particles.region.upper[d] != particles.extent.upper[d])
      particles.grid_domain.periodic[d] = false;
}

// Whether any particle went.
bool drop_missing(const Everyone& everyone, ParticleTable& table,
                  const std::vector<std::string>& columns) {
  std::size_t dropped = 0;
  everyone.together([&] {
    dropped = with_exit_code(wrong_input, [&] { return table.leave_out_missing(columns); });
  });
  const std::size_t kept = everyone.sum(table.size());
  everyone.together([&] {
    if (kept == 0)
      fail_input(table.source + ": no particle has a value in " + enumeration(columns));
  });
  return everyone.sum(dropped) > 0;
}

// A coordinate that is the same for all particles does not count, though it may be another one in
// each part of them.
void choose_varying(const Everyone& everyone, int wanted, const std::vector<std::string>& all,
                    ParticleTable& table) {
  std::vector<std::string> varying;
  for (const std::string& name : all)
    if (!range_of_column(everyone, table.raw_column(name)).is_one()) varying.push_back(name);
  if (varying.empty() || (wanted > 0 && varying.size() != static_cast<std::size_t>(wanted)))
    varying = all;
  table.set_coordinates(varying);
}

}  // namespace

ReadOptions read_options(const InputOptions& options) {
  return {.frame = options.frame,
          .step = options.step,
          .time = options.time,
          .columns = split(options.columns),
          .skip_rows = options.skip_rows,
          .missing = options.missing,
          .group = options.group};
}

Particles read_input(const InputOptions& options) {
  if (options.file.empty()) fail_usage("the file with the particles is missing");
  if (!options.more_files.empty())
    fail_usage("too many arguments: '" + options.more_files.front() +
               "' (only recon map and convert take several files; lists are written with commas "
               "and without "
               "blanks, as in vx,vy,vz)");
  if (!options.frames.empty())
    fail_usage("--frame " + options.frames +
               ": one frame is needed here; only recon map and convert take several");
  return make_particles(
      with_exit_code(wrong_input, [&] { return read_source(options.file, read_options(options)); }),
      options);
}

Particles make_particles(ParticleTable read, const InputOptions& options,
                         const Everyone& everyone) {
  Particles particles;
  particles.options = options;
  particles.everyone = &everyone;
  particles.table = std::move(read);
  ParticleTable& table = particles.table;
  particles.in_all = everyone.sum(table.size());
  everyone.together([&] {
    if (particles.in_all == 0) fail_input(table.source + ": there are no particles");
  });
  keep_where(options, everyone, table);
  std::vector<std::string> all, chosen;
  everyone.together([&] {
    choose_coordinates(options, table);
    all = with_exit_code(wrong_input, [&] { return table.all_coordinates(); });
  });
  const bool detect = options.coordinates.empty() && everyone.size() > 1;
  if (detect) choose_varying(everyone, options.dimension, all, table);
  // A coordinate that is missing somewhere is no constant: without those particles it may be one.
  everyone.together(
      [&] { chosen = with_exit_code(wrong_input, [&] { return table.coordinates(); }); });
  drop_missing(everyone, table, chosen);
  if (detect) choose_varying(everyone, options.dimension, all, table);
  everyone.together([&] {
    particles.dimension = choose_dimension(options, table);
    particles.axes = table.coordinates(particles.dimension);
  });
  drop_missing(everyone, table, particles.axes);
  for (const int axis : table.axes(particles.dimension)) particles.letters += axis_names[axis];
  particles.left_out = find_left_out(everyone, table, all, particles.axes);
  measure(particles);
  return particles;
}

void leave_out_missing(Particles& particles, const std::vector<std::string>& columns) {
  if (drop_missing(*particles.everyone, particles.table, columns)) measure(particles);
}

double suggested_spacing(const Particles& particles) {
  if (!(particles.spacing > 0))
    fail_usage("all particles are at one place, so no spacing can be suggested: say --spacing");
  const double wanted = std::max(particles.spacing, particles.box_spacing / 2);
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  double best = power;
  for (const double step : {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0})
    if (std::abs(std::log(step * power / wanted)) < std::abs(std::log(best / wanted)))
      best = step * power;
  return best;
}

double suggested_radius(const Particles& particles, int degree) {
  if (!(particles.spacing > 0))
    fail_usage(
        "all particles are at one place, so no support can be suggested: say --radius or --k");
  const int terms = static_cast<int>(monomial_count(particles.dimension, degree));
  const double enough =
      std::pow((2 * terms + 1) / unit_ball[particles.dimension - 1], 1.0 / particles.dimension);
  const double radius = particles.spacing * std::max(2.0, enough);
  const double power = std::pow(10.0, std::floor(std::log10(radius)) - 1);
  return std::ceil(radius / power * (1 - 1e-9)) * power;  // two digits
}

}  // namespace recon::program
