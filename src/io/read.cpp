#include "recon/io/read.hpp"

#include "formats.hpp"
#include "text_file.hpp"

namespace recon {

namespace {

bool is_lammps_dump(detail::TextFile& file) {
  const detail::TextFile::Mark start = file.mark();
  std::string_view line;
  bool lammps = false;
  while (file.next(line)) {
    if (detail::trim(line).empty()) continue;
    lammps = line.starts_with("ITEM:");
    break;
  }
  file.go_to(start);
  return lammps;
}

}  // namespace

namespace detail {

void fail_unknown_frame(const TextFile& file, int frame, std::size_t frames) {
  std::string text = "frame " + std::to_string(frame) + " was asked for, the file has " +
                     std::to_string(frames) + (frames == 1 ? " frame" : " frames");
  if (frames == 1) text += " (0, or -1 from the end)";
  if (frames > 1)
    text += " (0 to " + std::to_string(frames - 1) + ", or -1 to -" + std::to_string(frames) +
            " from the end)";
  throw FileError(file.path(), 0, text);
}

}  // namespace detail

std::vector<FrameInfo> list_frames(const std::filesystem::path& path) {
  detail::TextFile file(path);
  if (is_lammps_dump(file)) return detail::list_lammps_frames(file);
  return {detail::describe_delimited(file)};
}

ParticleTable read_particles(const std::filesystem::path& path, const ReadOptions& options) {
  detail::TextFile file(path);
  if (is_lammps_dump(file)) return detail::read_lammps_frame(file, options.frame);
  if (options.frame != 0 && options.frame != -1) detail::fail_unknown_frame(file, options.frame, 1);
  return detail::read_delimited(file);
}

}  // namespace recon
