// recon info FILE: what is in a file, and how it could be mapped.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "coincident.hpp"
#include "commands.hpp"
#include "field_plan.hpp"
#include "json_summary.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "source.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

void print_frames(const std::vector<FrameInfo>& frames) {
  std::string text = std::to_string(frames.size());
  if (frames.front().step) {
    text += frames.size() == 1 ? ", step " : ", steps ";
    text += std::to_string(*frames.front().step);
    if (frames.size() > 1) text += " to " + std::to_string(*frames.back().step);
  }
  if (frames.front().time) {
    text += frames.size() == 1 ? ", time " : ", times ";
    text += number(*frames.front().time, 10);
    if (frames.size() > 1 && frames.back().time) text += " to " + number(*frames.back().time, 10);
  }
  print_line("frames", text);
}

void print_axes(const Particles& particles) {
  const Box<double> extent = bounding_box(particles.positions());
  std::string_view heading = "coordinates";
  for (int d = 0; d < particles.dimension; ++d) {
    std::string text = particles.axes[d] + "  " + range(extent.lower[d], extent.upper[d]);
    if (particles.domain.periodic[d])
      text += ", periodic over " + range(particles.domain.lower[d], particles.domain.upper[d]);
    else if (particles.table.has_box())
      text += ", box " + range(particles.table.box(particles.dimension).lower[d],
                               particles.table.box(particles.dimension).upper[d]);
    print_line(heading, text);
    heading = "";
  }
}

struct Statistics {
  double least = HUGE_VAL, greatest = -HUGE_VAL, sum = 0;
  std::size_t finite = 0;
  explicit Statistics(const std::vector<double>& values) {
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      greatest = std::max(greatest, value);
      sum += value;
      ++finite;
    }
  }
};

// Of the columns that are no coordinates.
std::vector<std::string> field_columns(const Particles& particles) {
  std::vector<std::string> names;
  for (const std::string& name : particles.table.names()) {
    const auto is_this = [&](const LeftOut& each) { return each.name == name; };
    if (std::find(particles.axes.begin(), particles.axes.end(), name) == particles.axes.end() &&
        std::none_of(particles.left_out.begin(), particles.left_out.end(), is_this))
      names.push_back(name);
  }
  return names;
}

void print_columns(const Particles& particles) {
  std::size_t width = 5;
  for (const std::string& name : particles.table.names()) width = std::max(width, name.size());
  const auto row = [&](const std::string& heading, const std::string& name,
                       const std::string& least, const std::string& greatest,
                       const std::string& mean) {
    std::printf("%-13s %-*s %12s %12s %12s", heading.c_str(), static_cast<int>(width), name.c_str(),
                least.c_str(), greatest.c_str(), mean.c_str());
  };
  row("fields", "", "least", "greatest", "mean");
  std::printf("\n");
  for (const std::string& name : field_columns(particles)) {
    const Statistics all(particles.table.raw_column(name));
    if (all.finite == 0)
      row("", name, "nan", "nan", "nan");
    else
      row("", name, number_within(all.least, all.least, all.greatest),
          number_within(all.greatest, all.least, all.greatest),
          number_within(all.sum / static_cast<double>(all.finite), all.least, all.greatest));
    if (all.finite < particles.size())
      std::printf("   not finite at %s",
                  counted(particles.size() - all.finite, "particle").c_str());
    std::printf("\n");
  }
  const std::vector<std::string> derived = derivable_fields(particles);
  print_line("derived", enumeration(derived) + " (recon map computes them when asked)");
}

void print_coincident(const Particles& particles) {
  const Coincidence found = count_coincident(particles);
  if (found.places == 0) return;
  print_line("coincident", counted(found.particles, "particle") + " at " +
                               counted(found.places, "place") +
                               " that they share with others, to the last bit");
}

// As --fields takes it.
std::string field_word(const std::string& name) {
  if (name.find_first_of(",\" ") == std::string::npos) return name;
  std::string quoted(1, '"');
  for (const char c : name) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

// What else the command must say so that it means these particles.
std::string same_input(const InputOptions& options) {
  std::string text;
  const auto add = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) text += " " + name + " " + shell_word(value);
  };
  if (options.frame != InputOptions().frame) add("--frame", std::to_string(options.frame));
  if (options.step) add("--step", std::to_string(*options.step));
  if (options.time) add("--time", number(*options.time, 17));
  add("--group", options.group);
  add("--columns", options.columns);
  if (options.skip_rows > 0) add("--skip-rows", std::to_string(options.skip_rows));
  for (const std::string& missing : options.missing) text += " --missing=" + shell_word(missing);
  if (options.periodic != InputOptions().periodic) add("--periodic", options.periodic);
  if (options.dimension != 0) add("--dimension", std::to_string(options.dimension));
  add("--coordinates", options.coordinates);
  add("--where", options.where);
  return text;
}

// A map to begin with.
struct Suggestion {
  double spacing;
  StructuredGrid<double> grid;
  std::string command;
};

// None where all particles are at one place.
std::optional<Suggestion> suggest_map(const Particles& particles, const InputOptions& options) {
  if (!(particles.spacing > 0)) return {};
  const double spacing = suggested_spacing(particles);
  std::vector<std::string> fields = mappable_columns(particles);
  std::string names;
  for (const char* name : {"vx", "vy", "vz"})
    if (particles.table.has(name)) names += (names.empty() ? "" : ",") + std::string(name);
  if (names.empty()) names = fields.empty() ? "number_density" : field_word(fields.front());
  return Suggestion{spacing, covering_grid(particles.region, spacing, particles.grid_domain),
                    "recon map " + shell_word(options.file) + same_input(options) + " --fields " +
                        shell_word(names) + " --spacing " + number(spacing) +
                        " --out fields.vti --picture fields.png"};
}

void print_suggestion(const Particles& particles, const InputOptions& options) {
  const std::optional<Suggestion> suggestion = suggest_map(particles, options);
  if (!suggestion) {
    print_line("suggested", "nothing: all particles are at one place");
    return;
  }
  std::string nodes;
  for (int d = 0; d < particles.dimension; ++d)
    nodes += (d > 0 ? " x " : "") + std::to_string(suggestion->grid.counts[d]);
  print_line("mean spacing", number(particles.spacing, 3));
  print_line("suggested", "spacing " + number(suggestion->spacing) + " (" + nodes + " nodes):");
  std::printf("  %s\n", suggestion->command.c_str());
}

Json summary_object(const Particles& particles, const std::vector<FrameInfo>& frames,
                    const InputOptions& options) {
  Json summary = Json::object(), all = Json::array(), fields = Json::array();
  set_particles(summary, particles);
  for (const FrameInfo& frame : frames) {
    Json one = Json::object().set("particles", frame.particles);
    one.set("step", frame.step ? Json(*frame.step) : Json());
    all.push(one.set("time", frame.time ? Json(*frame.time) : Json()));
  }
  for (const std::string& name : field_columns(particles)) {
    const Statistics of(particles.table.raw_column(name));
    const bool any = of.finite > 0;
    Json one = Json::object().set("name", name);
    one.set("least", any ? Json(of.least) : Json())
        .set("greatest", any ? Json(of.greatest) : Json());
    one.set("mean", any ? Json(of.sum / static_cast<double>(of.finite)) : Json());
    fields.push(one.set("not_finite", particles.size() - of.finite));
  }
  const Coincidence coincident = count_coincident(particles);
  summary.set("frames", all).set("fields", fields);
  summary.set("derived", Json::array_of(derivable_fields(particles)));
  summary.set(
      "coincident",
      Json::object().set("particles", coincident.particles).set("places", coincident.places));
  summary.set("mean_spacing", particles.spacing);
  const std::optional<Suggestion> suggestion = suggest_map(particles, options);
  return summary.set("suggested", suggestion ? Json::object()
                                                   .set("spacing", suggestion->spacing)
                                                   .set("nodes", suggestion->grid.size())
                                                   .set("command", suggestion->command)
                                             : Json());
}

struct InfoOptions {
  InputOptions input;
  bool json = false;
};

void run(const InfoOptions& asked) {
  const InputOptions& options = asked.input;
  if (options.file.empty()) fail_usage("info: the FILE is missing; see recon info --help");
  const std::vector<FrameInfo> frames =
      with_exit_code(wrong_input, [&] { return list_source(options.file, read_options(options)); });
  const Particles particles = read_input(options);
  if (asked.json) return print_json(summary_object(particles, frames, options));
  std::printf("%s\n", particles.describe().c_str());
  print_frames(frames);
  if (!particles.table.units.empty()) print_line("units", particles.table.units);
  print_axes(particles);
  print_coincident(particles);
  print_columns(particles);
  print_remarks(particles.table);
  print_suggestion(particles, options);
}

}  // namespace

Command add_info(CLI::App& app) {
  CLI::App* sub =
      app.add_subcommand("info", "What is in a file: frames, particles, fields; a suggested grid");
  const auto options = std::make_shared<InfoOptions>();
  add_input_options(*sub, options->input);
  add_json_option(*sub, options->json, "Output");
  sub->footer("Example:\n  recon info examples/data/chute.dump.gz");
  return [options] { run(*options); };
}

}  // namespace recon::program
