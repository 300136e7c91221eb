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

enum class Content { text, legacy_vtk, xml_vtk, hdf5 };

// What a file begins with.
Content content_of(std::string_view start) {
  using namespace std::string_view_literals;
  if (start.starts_with("\x89HDF\r\n\x1a\n"sv)) return Content::hdf5;
  if (start.starts_with("# vtk DataFile"sv)) return Content::legacy_vtk;
  if (start.starts_with("\xef\xbb\xbf"sv)) start.remove_prefix(3);
  const bool xml = start.starts_with("<?xml"sv) || start.starts_with("<VTKFile"sv);
  if (xml && start.find("<VTKFile"sv) != std::string_view::npos) return Content::xml_vtk;
  return Content::text;
}

// All bytes of a source, with gzip undone.
std::string whole(detail::ByteSource& source) {
  constexpr std::size_t block = 1 << 20;
  std::string bytes;
  for (std::size_t got = 1; got > 0;) {
    const std::size_t before = bytes.size();
    bytes.resize(before + block);
    got = source.read(bytes.data() + before, block);
    bytes.resize(before + got);
  }
  return bytes;
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

bool TextFrames::next() {
  const TextFile::Mark begin = file_->mark();
  if (!find()) return false;
  begins_.push_back(begin);
  return true;
}

void TextFrames::go_to(std::size_t frame) {
  file_->go_to(begins_.at(frame));
  begins_.resize(frame);
}

bool is_orthogonal(const SimulationCell& cell) {
  for (int e = 0; e < max_dimension; ++e)
    for (int d = 0; d < max_dimension; ++d)
      if (!(d == e ? cell.edges[e][d] >= 0 : cell.edges[e][d] == 0)) return false;
  return true;
}

void set_cell_or_box(ParticleTable& table, const SimulationCell& cell,
                     std::array<bool, max_dimension> periodic) {
  if (!is_orthogonal(cell)) return table.set_cell(cell, periodic);
  Box<double> box = Box<double>::empty(max_dimension);
  for (int e = 0; e < max_dimension; ++e) {
    box.lower[e] = cell.origin[e];
    box.upper[e] = cell.origin[e] + cell.edges[e][e];
  }
  table.set_box(box, periodic);
}

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
  std::filesystem::path path;
  ReadOptions options;
  std::optional<detail::TextFile> text;  // of a format that is lines of text
  std::unique_ptr<detail::FrameSource> source;
  std::size_t position = 0;
  std::optional<FileError> cut;
  std::string cut_text;

  // `from`: a path; or bytes in memory, and their name.
  template <class... Source>
  explicit State(const ReadOptions& asked, const Source&... from) : options(asked) {
    for (const std::string& name : options.columns)
      require(!name.empty(), "name of a column", "''", "must not be empty");
    require(options.parts >= 1, "parts", options.parts, "must be at least 1");
    require(options.part >= 0 && options.part < options.parts, "part", options.part,
            "must be from 0 to parts - 1");
    detail::ByteSource bytes(from...);
    path = bytes.path();
    constexpr std::size_t enough = 1024;
    std::string start(enough, '\0');
    start.resize(bytes.read(start.data(), start.size()));
    const Content content = content_of(start);
    require(options.group.empty() || content == Content::hdf5, "group", options.group,
            "is for HDF5 files only");
    if (content == Content::text) {
      open_text(from...);
      return;
    }
    require(options.columns.empty() && options.skip_rows == 0, "options columns and skip_rows",
            "given", "are for delimited text and dumps only");
    bytes.go_to(0);
    if (content == Content::hdf5) {
      const bool by_path = sizeof...(from) == 1 && !bytes.is_gzip();
      source = detail::open_hdf5_particles(path, by_path ? "" : whole(bytes), options);
    } else {
      constexpr bool on_disk = (std::is_same_v<Source, std::filesystem::path> && ...);
      detail::OpenFile open;
      if (on_disk)
        open = [](const std::filesystem::path& piece) {
          detail::ByteSource file(piece);
          return whole(file);
        };
      source = detail::vtk_frame(content == Content::xml_vtk
                                     ? detail::read_xml_vtk(whole(bytes), path, open)
                                     : detail::read_legacy_vtk(whole(bytes), path),
                                 options);
    }
  }

  template <class... Source>
  void open_text(const Source&... from) {
    text.emplace(from...);
    detail::TextFile& file = *text;
    std::string_view line;
    for (std::size_t skipped = 0; skipped < options.skip_rows; ++skipped)
      if (!file.next(line))
        throw FileError(file.path(), 0,
                        "there is nothing behind the " + std::to_string(options.skip_rows) +
                            " rows to skip: the file has " + std::to_string(skipped) + " lines");
    if (is_lammps_dump(file))
      source = detail::lammps_frames(file, options);
    else if (options.columns.empty() && detail::is_xyz(file))
      source = detail::xyz_frames(file, options);
    else
      source = detail::delimited_frame(file, options);
  }

  // Calls use() on the next frame; false at the end of the file, or where it ends within a frame
  // that is not the first.
  template <class Use>
  bool with_next(const Use& use) {
    if (cut) return false;
    try {
      if (!source->next()) return false;
      use();
    } catch (const FileError& error) {
      if (position == 0 || !source->ended()) throw;
      cut = error;
      cut_text = std::string(error.what()) + ": frame " + std::to_string(position) +
                 " is cut off, the frames before it are whole";
      return false;
    }
    ++position;
    return true;
  }

  bool skip() {
    return with_next([&] { source->skip(); });
  }

  std::optional<ParticleTable> read() {
    std::optional<ParticleTable> table;
    const std::size_t number = position;
    const bool found = with_next([&] {
      try {
        table = source->read();
      } catch (const InvalidArgument& error) {  // a box or columns that no table can have
        throw FileError(path, source->info().line, error.what());
      }
      if (text && options.parts > 1) {
        std::vector<std::size_t> rows;
        for (std::size_t row = 0; rows.size() < table->size(); ++row)
          if (options.takes(row)) rows.push_back(row);
        table->set_source_rows(std::move(rows));
      } else if (options.parts > 1) {
        std::vector<bool> taken(table->size());
        for (std::size_t row = 0; row < taken.size(); ++row) taken[row] = options.takes(row);
        table->keep_rows(taken);
      }
      table->source = path.filename().string();
      if (source->is_series()) table->source += ", frame " + std::to_string(number);
      if (source->is_series() && table->step)
        table->source += ", step " + std::to_string(*table->step);
      if (source->ends_open())
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
    if (!source->is_series() && options.frame == -1) options.frame = 0;
    const bool look_at_all = options.step || options.time || options.frame < 0;
    const std::size_t number = look_at_all ? find() : static_cast<std::size_t>(options.frame);
    const std::optional<FileError> seen = std::exchange(cut, std::nullopt);
    if (look_at_all) {
      source->go_to(number);
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
      if (position == 21) there += ", ...";
      if (position >= 21) continue;
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
    throw FileError(path, 0, cut ? what + "; " + cut_text : what);
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
FrameReader::FrameReader(std::string_view bytes, const ReadOptions& options,
                         const std::string& name)
    : state_(std::make_unique<State>(options, bytes, std::filesystem::path(name))) {}
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
  return state_->source->progress();
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
