#include "recon/io/read.hpp"

#include <cmath>
#include <utility>

#include "formats.hpp"
#include "recon/core/error.hpp"
#include "recon/fields/utf8.hpp"
#include "text_file.hpp"

namespace recon {

namespace {

using detail::require;

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

std::string frames_there_are(std::size_t frames) {
  std::string text =
      "the file has " + std::to_string(frames) + (frames == 1 ? " frame" : " frames");
  if (frames == 1) text += " (0, or -1 from the end)";
  if (frames > 1)
    text += " (0 to " + std::to_string(frames - 1) + ", or -1 to -" + std::to_string(frames) +
            " from the end)";
  return text;
}

}  // namespace

namespace detail {

std::vector<std::string> to_utf8(const std::vector<std::string>& names,
                                 std::vector<std::string>& remarks) {
  std::vector<std::string> converted;
  bool all_are = true;
  for (const std::string& name : names) {
    all_are = all_are && is_utf8(name);
    converted.push_back(recon::to_utf8(name));
  }
  if (!all_are) remarks.push_back("names that are not UTF-8 are read as Latin-1 (Windows-1252)");
  return converted;
}

}  // namespace detail

struct FrameReader::State {
  detail::TextFile file;
  ReadOptions options;
  std::unique_ptr<detail::FrameSource> source;
  std::size_t position = 0;
  std::vector<detail::TextFile::Mark> begins;  // of the frames passed over
  std::optional<FileError> cut;
  std::string cut_text;
  bool has_steps = false;

  template <class... Source>
  explicit State(const ReadOptions& asked, const Source&... from) : file(from...), options(asked) {
    for (const std::string& name : options.columns)
      require(!name.empty(), "name of a column", "''", "must not be empty");
    std::string_view line;
    for (std::size_t skipped = 0; skipped < options.skip_rows; ++skipped)
      if (!file.next(line))
        throw FileError(file.path(), 0,
                        "there is nothing behind the " + std::to_string(options.skip_rows) +
                            " rows to skip: the file has " + std::to_string(skipped) + " lines");
    has_steps = is_lammps_dump(file);
    if (has_steps)
      source = std::make_unique<detail::LammpsFrames>(file, options);
    else
      source = std::make_unique<detail::DelimitedFrame>(file, options);
  }

  // Calls use() on the next frame; false at the end of the file, or where it ends within a frame
  // that is not the first.
  template <class Use>
  bool with_next(const Use& use) {
    if (cut) return false;
    const detail::TextFile::Mark begin = file.mark();
    try {
      if (!source->next()) return false;
      use();
    } catch (const FileError& error) {
      if (position == 0 || !file.ended()) throw;
      cut = error;
      cut_text = std::string(error.what()) + ": frame " + std::to_string(position) +
                 " is cut off, the frames before it are whole";
      return false;
    }
    ++position;
    begins.push_back(begin);
    return true;
  }

  bool skip() {
    return with_next([&] { source->skip(); });
  }

  std::optional<ParticleTable> read() {
    std::optional<ParticleTable> table;
    const std::size_t number = position;
    const bool found = with_next([&] {
      table = source->read();
      table->source = file.path().filename().string();
      if (has_steps)
        table->source += ", frame " + std::to_string(number) + ", step " +
                         std::to_string(table->step.value_or(0));
      if (!file.line_is_closed())
        table->remarks.push_back(
            "the last line of the file has no line break: if the file was cut, "
            "its last number lacks figures");
    });
    return found ? std::move(table) : std::nullopt;
  }

  // The frame that the options ask for.
  ParticleTable read_asked() {
    const int given = (options.frame != -1) + options.step.has_value() + options.time.has_value();
    require(given <= 1, "options that choose a frame", given,
            "must be at most one of frame, step and time");
    if (!has_steps && options.frame == -1) options.frame = 0;
    const bool look_at_all = options.step || options.time || options.frame < 0;
    const std::size_t number = look_at_all ? find() : static_cast<std::size_t>(options.frame);
    const std::optional<FileError> seen = std::exchange(cut, std::nullopt);
    if (look_at_all) {
      file.go_to(begins[number]);
      position = number;
    }
    while (position < number)
      if (!skip()) fail_number();
    std::optional<ParticleTable> table = read();
    if (!table) fail_number();
    if (seen) table->remarks.push_back(cut_text);
    return std::move(*table);
  }

 private:
  // Number of the frame that the options ask for, after a look at all.
  std::size_t find() {
    std::vector<std::size_t> numbers;
    std::string there;
    while (skip()) {
      const FrameInfo& info = source->info();
      if (options.step ? info.step == options.step
                       : options.time && info.time &&
                             std::abs(*info.time - *options.time) <= 1e-9 * std::abs(*options.time))
        numbers.push_back(position - 1);
      if (options.step ? !info.step : !info.time) continue;
      if (begins.size() == 20) there += ", ...";
      if (begins.size() >= 20) continue;
      there += (there.empty() ? "" : ", ") +
               (options.step ? std::to_string(*info.step) : detail::to_text(*info.time));
    }
    if (!options.step && !options.time) {
      const std::int64_t number = static_cast<std::int64_t>(position) + options.frame;
      if (number < 0) fail_number();
      return static_cast<std::size_t>(number);
    }
    const std::string asked = options.step ? "step " + std::to_string(*options.step)
                                           : "time " + detail::to_text(*options.time);
    if (numbers.empty())
      fail(asked + " was asked for, the file " + (there.empty() ? "tells none" : "has " + there));
    if (numbers.size() == 1) return numbers.front();
    std::string several;
    for (const std::size_t number : numbers)
      several += (several.empty() ? "" : ", ") + std::to_string(number);
    fail(asked + " is that of frames " + several + ": say which by its number");
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(file.path(), 0, cut ? what + "; " + cut_text : what);
  }
  // The frame with the number asked for is not there, or cut off.
  [[noreturn]] void fail_number() const {
    if (cut && options.frame == static_cast<int>(position)) throw *cut;
    fail("frame " + std::to_string(options.frame) + " was asked for, " +
         frames_there_are(position));
  }
};

FrameReader::FrameReader(const std::filesystem::path& path, const ReadOptions& options)
    : state_(std::make_unique<State>(options, path)) {}
FrameReader::~FrameReader() = default;
FrameReader::FrameReader(FrameReader&&) noexcept = default;
FrameReader& FrameReader::operator=(FrameReader&&) noexcept = default;

std::optional<ParticleTable> FrameReader::next() {
  return state_->read();
}

std::optional<FrameInfo> FrameReader::skip() {
  if (!state_->skip()) return std::nullopt;
  return state_->source->info();
}

std::size_t FrameReader::position() const {
  return state_->position;
}

const std::string& FrameReader::cut() const {
  return state_->cut_text;
}

double FrameReader::progress() const {
  return state_->file.progress();
}

std::vector<FrameInfo> FrameReader::list(State& state) {
  std::vector<FrameInfo> frames;
  while (state.skip()) frames.push_back(state.source->info());
  return frames;
}

std::vector<FrameInfo> list_frames(const std::filesystem::path& path, const ReadOptions& options) {
  FrameReader::State state(options, path);
  return FrameReader::list(state);
}

ParticleTable read_particles(const std::filesystem::path& path, const ReadOptions& options) {
  return FrameReader::State(options, path).read_asked();
}

std::vector<FrameInfo> list_frames_of(std::string_view bytes, const ReadOptions& options,
                                      const std::string& name) {
  FrameReader::State state(options, bytes, std::filesystem::path(name));
  return FrameReader::list(state);
}

ParticleTable read_particles_of(std::string_view bytes, const ReadOptions& options,
                                const std::string& name) {
  return FrameReader::State(options, bytes, std::filesystem::path(name)).read_asked();
}

}  // namespace recon
