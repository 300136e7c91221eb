// recon info FILE: what is in a file, and how it could be mapped.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "field_plan.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "recon/io/read.hpp"
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
  for (const std::string& name : particles.table.names()) {
    if (std::find(particles.axes.begin(), particles.axes.end(), name) != particles.axes.end())
      continue;
    const Statistics all(particles.table.raw_column(name));
    if (all.finite == 0)
      row("", name, "nan", "nan", "nan");
    else
      row("", name, number(all.least), number(all.greatest),
          number(all.sum / static_cast<double>(all.finite)));
    if (all.finite < particles.size())
      std::printf("   not finite at %s",
                  counted(particles.size() - all.finite, "particle").c_str());
    std::printf("\n");
  }
  const std::vector<std::string> derived = derivable_fields(particles);
  print_line("derived", enumeration(derived) + " (recon map computes them when asked)");
}

// As a shell takes it.
std::string quoted(const std::string& path) {
  return path.find(' ') == std::string::npos ? path : "'" + path + "'";
}

void print_suggestion(const Particles& particles, const std::string& file) {
  if (!(particles.spacing > 0)) {
    print_line("suggested", "nothing: all particles are at one place");
    return;
  }
  const double spacing = suggested_spacing(particles);
  const auto grid = covering_grid(particles.region, spacing, particles.grid_domain);
  std::string nodes;
  for (int d = 0; d < particles.dimension; ++d)
    nodes += (d > 0 ? " x " : "") + std::to_string(grid.counts[d]);
  std::vector<std::string> fields = mappable_columns(particles);
  std::string names;
  for (const char* name : {"vx", "vy", "vz"})
    if (particles.table.has(name)) names += (names.empty() ? "" : ",") + std::string(name);
  if (names.empty()) names = fields.empty() ? "number_density" : fields.front();
  print_line("mean spacing", number(particles.spacing, 3));
  print_line("suggested", "spacing " + number(spacing) + " (" + nodes + " nodes):");
  std::printf("  recon map %s --fields %s --spacing %s --out fields.vti\n", quoted(file).c_str(),
              names.c_str(), number(spacing).c_str());
}

void run(const InputOptions& options) {
  if (options.file.empty()) fail_usage("info: the FILE is missing; see recon info --help");
  const std::vector<FrameInfo> frames =
      with_exit_code(wrong_input, [&] { return list_frames(options.file, read_options(options)); });
  const Particles particles = read_input(options);
  std::printf("%s\n", particles.describe().c_str());
  print_frames(frames);
  print_axes(particles);
  print_columns(particles);
  print_remarks(particles.table);
  print_suggestion(particles, options.file);
}

}  // namespace

Command add_info(CLI::App& app) {
  CLI::App* sub =
      app.add_subcommand("info", "What is in a file: frames, particles, fields; a suggested grid");
  const auto options = std::make_shared<InputOptions>();
  add_input_options(*sub, *options);
  sub->footer("Example:\n  recon info examples/data/chute.dump.gz");
  return [options] { run(*options); };
}

}  // namespace recon::program
