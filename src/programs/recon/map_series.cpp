#include "map_series.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>

#include "average.hpp"
#include "frames.hpp"
#include "json_summary.hpp"
#include "outputs.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/io/write.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

namespace fs = std::filesystem;

// "out/v.vti" and 3: "out/v_0003.vti".
std::string numbered(const std::string& path, std::size_t number) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "_%04zu", number);
  fs::path name(path);
  const std::string extension = name.extension().string();
  name.replace_extension();
  return name.string() + digits + extension;
}

MapOptions with_numbers(const MapOptions& options, std::size_t number) {
  MapOptions frame = options;
  for (std::string& path : frame.outputs) path = numbered(path, number);
  if (!frame.picture.file.empty()) frame.picture.file = numbered(frame.picture.file, number);
  return frame;
}

std::string list_of(const std::string& output) {
  return fs::path(output).replace_extension(".pvd").string();
}

bool is_listed(const std::string& output) {
  return !output.ends_with(".csv");
}

// How far a walk through frames is.
class FrameProgress {
 public:
  explicit FrameProgress(bool quiet) : progress_("frames", parts, quiet) {}
  void reach(double part) {
    const auto done = static_cast<std::size_t>(part * parts);
    if (done > done_) progress_.advance(done - done_);
    done_ = std::max(done_, done);
  }
  double seconds() const { return progress_.seconds(); }

 private:
  static constexpr std::size_t parts = 10'000;
  Progress progress_;
  std::size_t done_ = 0;
};

// The particles of a frame, in the coordinates of the first one.
class LikeTheFirst {
 public:
  explicit LikeTheFirst(const InputOptions& options) : options_(options) {}

  Particles particles(ParticleTable table) {
    if (axes_.empty()) {
      Particles first = make_particles(std::move(table), options_);
      axes_ = first.axes;
      return first;
    }
    const std::string source = table.source;
    InputOptions options = options_;
    if (options.coordinates.empty() && options.dimension == 0) {
      for (const std::string& name :
           with_exit_code(wrong_input, [&] { return table.coordinates(); }))
        if (std::find(axes_.begin(), axes_.end(), name) == axes_.end() && table.size() > 1)
          fail_input(source + ": the coordinate " + name + " varies here, and not in the first " +
                     "frame; --dimension 3, or --coordinates, says what counts in all");
      for (const std::string& name : axes_)
        options.coordinates += (options.coordinates.empty() ? "\"" : ",\"") + name + "\"";
    }
    return make_particles(std::move(table), options);
  }

 private:
  const InputOptions& options_;
  std::vector<std::string> axes_;
};

// A number for each file of a list: the times, or else the steps, or else 0, 1, 2, ...
std::vector<double> list_times(const std::vector<std::optional<double>>& times,
                               const std::vector<std::optional<double>>& steps) {
  std::vector<double> numbers;
  for (const auto* each : {&times, &steps}) {
    numbers.clear();
    for (const auto& value : *each)
      if (value) numbers.push_back(*value);
    if (numbers.size() == each->size()) return numbers;
  }
  numbers.clear();
  for (std::size_t i = 0; i < times.size(); ++i) numbers.push_back(static_cast<double>(i));
  return numbers;
}

// The files of a series, for its lists.
struct Written {
  std::vector<std::optional<double>> times, steps;

  void add(const ParticleTable& table) {
    times.push_back(table.time);
    steps.emplace_back();
    if (table.step) steps.back() = static_cast<double>(*table.step);
  }
  void write_lists(const MapOptions& options) const {
    if (times.empty()) return;
    const std::vector<double> numbers = list_times(times, steps);
    for (const std::string& output : options.outputs) {
      if (!is_listed(output)) continue;
      std::vector<TimedFile> entries;
      for (std::size_t i = 0; i < numbers.size(); ++i)
        entries.push_back({numbers[i], fs::path(numbered(output, i)).filename()});
      with_exit_code(no_output, [&] { write_pvd(list_of(output), entries); });
    }
  }
};

// A file of the series must not be one of those that are read.
void check_inputs(const MapOptions& options, const MapOptions& frame) {
  check_outputs(frame.outputs, frame.picture.file, inputs_of(options), options.targets == "grid");
}

void print_frame(const MapOptions& frame, const MapJob& job, const Mapped& mapped,
                 const std::string& beyond) {
  const FitSummary& summary = mapped.reports.summary();
  const double full =
      100.0 * static_cast<double>(summary.full) / static_cast<double>(summary.targets);
  std::string files;
  for (const std::string& file : files_of(frame)) files += (files.empty() ? "" : ", ") + file;
  std::printf("%s\n", job.particles.describe().c_str());
  print_line("", counted(summary.targets, "target") + ", full degree at " + number(full, 3) +
                     " %: " + files);
  if (!beyond.empty()) print_line("", beyond);
}

// Particles outside the nodes' cells, along axes that are not periodic.
std::size_t count_outside(const Particles& particles, const StructuredGrid<double>& grid) {
  const PointsView<double> positions = particles.positions();
  std::size_t outside = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    bool inside = true;
    for (int d = 0; d < grid.dimension; ++d) {
      const double half = grid.spacing[d] / 2;
      const double last = grid.coordinate(grid.counts[d] - 1, d);
      inside =
          inside && (particles.domain.periodic[d] ||
                     (positions(i, d) >= grid.origin[d] - half && positions(i, d) <= last + half));
    }
    outside += inside ? 0 : 1;
  }
  return outside;
}

bool same_box(const PeriodicDomain<double>& a, const PeriodicDomain<double>& b) {
  for (int d = 0; d < max_dimension; ++d)
    if (a.periodic[d] != b.periodic[d] ||
        (a.periodic[d] && (a.lower[d] != b.lower[d] || a.upper[d] != b.upper[d])))
      return false;
  return true;
}

// What an average should tell its reader about frames unlike the first.
struct Differences {
  std::size_t most_outside = 0;
  std::string where_outside, where_box;

  void look_at(const Particles& particles, const MapJob& first) {
    if (first.targets.is_grid) {
      const std::size_t outside = count_outside(particles, first.targets.grid);
      if (outside > most_outside) where_outside = particles.table.source;
      most_outside = std::max(most_outside, outside);
    }
    if (where_box.empty() && !same_box(particles.domain, first.particles.domain))
      where_box = particles.table.source;
  }
  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    if (most_outside > 0)
      notes.push_back(counted(most_outside, "particle") +
                      " outside the grid of the first frame in " + where_outside +
                      "; --bounds says what it covers");
    if (!where_box.empty())
      notes.push_back("the periodic box is another one in " + where_box +
                      "; the grid is that of the first frame");
    return notes;
  }
};

}  // namespace

void map_series(const MapOptions& options, const Method& method) {
  FrameProgress progress(options.quiet);
  LikeTheFirst like(options.input);
  Written written;
  MapOptions chosen = options;
  Json frames = Json::array();
  const auto map_frame = [&](ParticleTable table, const FramePlace& place) {
    Particles particles = like.particles(std::move(table));
    if (place.number == 0 && options.targets == "grid" && !options.spacing)
      chosen.spacing = suggested_spacing(particles);
    const MapOptions frame = with_numbers(chosen, place.number);
    check_inputs(options, frame);
    const MapJob job = prepare(frame, method, std::move(particles));
    Progress silent("", 0, true);
    const Mapped mapped =
        map_fields(job.particles, job.plan, job.fit, job.targets.points, options.gradient, silent);
    const std::string beyond = write_outputs(frame, job, mapped.fields, &mapped.reports);
    written.add(job.particles.table);
    progress.reach(place.progress);
    if (options.json) {
      Json one = Json::object();
      set_summary(one, frame, method, job, mapped);
      one.set("written", files_array(files_of(frame)));
      one.set("picture_note", beyond.empty() ? Json() : Json(beyond));
      frames.push(one);
    } else if (!options.quiet) {
      print_frame(frame, job, mapped, beyond);
    }
  };
  std::vector<std::string> remarks;
  try {
    remarks = for_each_frame(options.input, map_frame);
  } catch (...) {
    written.write_lists(options);  // of what there is
    throw;
  }
  written.write_lists(options);
  std::vector<std::string> lists;
  for (const std::string& output : options.outputs)
    if (is_listed(output)) lists.push_back(list_of(output));
  if (options.json) {
    Json summary = Json::object().set("frames", frames).set("notes", Json::array_of(remarks));
    summary.set("seconds", progress.seconds()).set("written", files_array(lists));
    return print_json(summary);
  }
  if (options.quiet) return;
  for (const std::string& remark : remarks) print_line("note", remark);
  print_line("method", describe_method(method, options.fit));
  print_line("frames", count(written.times.size()));
  print_line("time", number(progress.seconds(), 2) + " s");
  print_written(lists, "");
}

void map_average(const MapOptions& options, const Method& method) {
  FrameProgress progress(options.quiet);
  LikeTheFirst like(options.input);
  std::optional<MapJob> first;
  FrameAverage average;
  Differences differences;
  double fill = std::numeric_limits<double>::quiet_NaN();
  const auto add_frame = [&](ParticleTable table, const FramePlace& place) {
    Particles particles = like.particles(std::move(table));
    check_weight_by(options.fit, particles);
    const FieldPlan plan = plan_fields(particles, options.fields, options.components);
    auto fit = fit_options(options.fit, method, particles);
    if (!first) {
      first = prepare(options, method, particles);
      fill = fit.fill_value;
    } else {
      fit.neighbours = first->fit.neighbours;
      fit.sum_radius = first->fit.sum_radius;
      differences.look_at(particles, *first);
    }
    fit.fill_value = std::numeric_limits<double>::quiet_NaN();
    Progress silent("", 0, true);
    const Mapped mapped =
        map_fields(particles, plan, fit, first->targets.points, options.gradient, silent);
    average.add(mapped.fields, mapped.reports);
    progress.reach(place.progress);
  };
  const std::vector<std::string> remarks = for_each_frame(options.input, add_frame);
  const FieldSet result = average.result(fill);
  const std::string beyond = write_outputs(options, *first, result, nullptr);
  const std::string support =
      describe_support(options.fit, method, first->particles, has_sums(first->plan));
  if (options.json) {
    std::vector<std::string> notes = remarks;
    for (const std::string& note : differences.notes()) notes.push_back(note);
    Json of_first = Json::object(), summary = Json::object();
    set_particles(of_first, first->particles);
    summary.set("frames", average.frames()).set("first", of_first);
    summary.set("notes", Json::array_of(notes));
    summary.set("method", method_object(method, options.fit, support));
    summary.set("targets", targets_object(first->targets));
    summary.set("sometimes_missing", average.sometimes_missing());
    summary.set("always_missing", average.always_missing());
    summary.set("fields", fields_array(result)).set("seconds", progress.seconds());
    summary.set("written", files_array(files_of(options)));
    summary.set("picture_note", beyond.empty() ? Json() : Json(beyond));
    return print_json(summary);
  }
  if (options.quiet) return;
  std::printf("%s\n", first->particles.describe().c_str());
  print_remarks(first->particles.table);
  for (const std::string& remark : remarks) print_line("note", remark);
  print_line("frames", count(average.frames()) + ", the first of which is this");
  for (const std::string& note : differences.notes()) print_line("note", note);
  print_line("method", describe_method(method, options.fit));
  print_line("support", support);
  print_line("targets", first->targets.description);
  if (average.sometimes_missing() + average.always_missing() > 0)
    print_line("no value", counted(average.sometimes_missing(), "target") + " in some frames, " +
                               count(average.always_missing()) + " in all");
  print_fields(result);
  print_line("time", number(progress.seconds(), 2) + " s");
  print_written(files_of(options), beyond);
}

}  // namespace recon::program
