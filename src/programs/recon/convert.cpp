// recon convert FILE --out FILE: particles from any format that is read to any that is written.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "frames.hpp"
#include "outputs.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "recon/io/write_particles.hpp"
#include "source.hpp"
#include "summary.hpp"
#include "where.hpp"

namespace recon::program {

namespace {

struct ConvertOptions {
  InputOptions input;
  std::string out, format;
  bool quiet = false, frame_is_given = false;
};

// The rows that --where asks for.
void keep_asked(const InputOptions& options, ParticleTable& table) {
  if (!options.coordinates.empty())
    with_exit_code(wrong_usage, [&] { table.set_coordinates(split(options.coordinates)); });
  if (!options.where.empty()) table.keep_rows(rows_where(options.where, table));
}

void run(ConvertOptions options) {
  InputOptions& input = options.input;
  if (input.file.empty()) fail_usage("convert: the FILE is missing; see recon convert --help");
  if (options.out.empty()) fail_usage("nothing to write: name a file with --out, or - for a pipe");
  const bool to_pipe = options.out == "-";
  if (to_pipe && options.format.empty()) fail_usage("--out -: say in which format, with --format");
  const ParticleFormat format =
      options.format.empty()
          ? with_exit_code(wrong_usage, [&] { return particle_format_of(options.out); })
          : particle_format(options.format);
  std::vector<std::string> inputs{input.file};
  inputs.insert(inputs.end(), input.more_files.begin(), input.more_files.end());
  if (!to_pipe) check_files({options.out}, inputs);
  if (has_frames(format) && !options.frame_is_given) input.frames = "all";
  if (is_series(input) && !has_frames(format))
    fail_usage("a series of frames needs a format that has frames: xyz, dump or h5md");

  OutputPlace place(options.out);
  ParticleWriter writer =
      with_exit_code(no_output, [&] { return ParticleWriter(place.path(), format); });
  std::size_t frames = 0, particles = 0;
  std::vector<std::string> remarks;
  const auto add = [&](ParticleTable table, const FramePlace&) {
    keep_asked(input, table);
    for (const std::string& remark : table.remarks)
      if (std::find(remarks.begin(), remarks.end(), remark) == remarks.end())
        remarks.push_back(remark);
    particles += table.size();
    ++frames;
    with_exit_code(wrong_input, [&] { writer.add(table); });
  };
  const bool series = is_series(input);
  if (series)
    for (const std::string& remark : for_each_frame(input, add)) remarks.push_back(remark);
  else
    add(with_exit_code(wrong_input, [&] { return read_source(input.file, read_options(input)); }),
        {});
  with_exit_code(no_output, [&] { writer.commit(); });
  place.send();
  if (to_pipe || options.quiet) return;
  print_line("frames", count(frames));
  print_line("particles", series ? count(particles) + " in all" : count(particles));
  for (const std::string& remark : remarks) print_line("note", remark);
  for (const std::string& note : writer.notes()) print_line("note", note);
  print_line("written", options.out + " (" + file_size(options.out) + ")");
}

}  // namespace

Command add_convert(CLI::App& app) {
  CLI::App* sub = app.add_subcommand("convert", "Particles from one format to another");
  const auto options = std::make_shared<ConvertOptions>();
  add_file_options(*sub, options->input);
  const std::string group = "Output";
  sub->add_option("--out", options->out,
                  "file to write: .csv, .vtp (one frame), .xyz, .dump (LAMMPS),\n"
                  ".h5 (H5MD); - is the standard output, with --format")
      ->type_name("FILE")
      ->group(group);
  sub->add_option("--format", options->format,
                  "csv, vtp, xyz, dump or h5md, whatever the name says")
      ->type_name("NAME")
      ->check(one_of(particle_format_names()))
      ->group(group);
  sub->add_flag("--quiet", options->quiet, "no summary")->group(group);
  sub->footer(
      "All frames are written where the format has frames, else the last one; --frame\n"
      "chooses others. Coordinates, boxes and names are kept as far as the format has a\n"
      "place for them; what is left out is said.\n\n"
      "Examples:\n"
      "  recon convert examples/data/chute.dump.gz --out chute.h5\n"
      "  recon convert chute.h5 --frame 0 --out - --format csv | head");
  return [options, sub] {
    options->frame_is_given =
        sub->count("--frame") + sub->count("--step") + sub->count("--time") > 0;
    run(*options);
  };
}

}  // namespace recon::program
