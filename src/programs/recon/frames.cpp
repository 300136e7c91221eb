#include "frames.hpp"

#include <filesystem>
#include <limits>

#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "source.hpp"

namespace recon::program {

namespace {

struct FrameRange {
  std::optional<long> first, last;  // negative: from the end
  long step = 1;
};

std::optional<long> whole(const std::string& text) {
  const auto value = to_number(text);
  if (!value || *value != static_cast<double>(static_cast<long>(*value))) return {};
  return static_cast<long>(*value);
}

// Nothing where the text is no range.
std::optional<FrameRange> read_range(const std::string& text) {
  FrameRange range;
  if (text == "all") return range;
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() < 2 || parts.size() > 3) return {};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].empty() && i < 2) continue;
    const auto value = whole(parts[i]);
    if (!value) return {};
    if (i == 0) range.first = value;
    if (i == 1) range.last = value;
    if (i == 2) range.step = *value;
  }
  if (range.step < 1) return {};
  return range;
}

// The frames first, first + step, ... up to last of a file.
struct Chosen {
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max(), step = 1;
};

// Counts the frames of the file only where the range asks for it.
Chosen choose(const std::string& file, const std::string& text, const ReadOptions& options) {
  const FrameRange range = *read_range(text);
  Chosen chosen;
  chosen.step = static_cast<std::size_t>(range.step);
  if (!range.first && !range.last) return chosen;
  const std::size_t frames = list_source(file, options).size();
  const auto place = [&](std::optional<long> asked, std::size_t otherwise) {
    if (!asked) return otherwise;
    const long at = *asked < 0 ? *asked + static_cast<long>(frames) : *asked;
    if (at < 0 || at >= static_cast<long>(frames))
      fail_input("--frame " + text + ": " + file + " has " + counted(frames, "frame") +
                 ", counted from 0; there is no frame " + std::to_string(*asked));
    return static_cast<std::size_t>(at);
  };
  chosen.first = place(range.first, 0);
  chosen.last = place(range.last, frames - 1);
  if (chosen.last < chosen.first)
    fail_usage("--frame " + text + ": the last frame is before the first");
  return chosen;
}

}  // namespace

bool is_series(const InputOptions& options) {
  return !options.frames.empty() || !options.more_files.empty();
}

std::string check_frame_text(const std::string& text) {
  if (whole(text) || read_range(text)) return "";
  return "'" + text + "' is no frame; a number, all, or FIRST:LAST (as in 0:10 or -5:) is needed";
}

std::vector<std::string> for_each_frame(
    const InputOptions& options, const std::function<void(ParticleTable, const FramePlace&)>& use) {
  std::vector<std::string> files{options.file}, remarks;
  files.insert(files.end(), options.more_files.begin(), options.more_files.end());
  for (const std::string& file : options.more_files)
    if (file != "-" && !std::filesystem::exists(file))
      fail_usage("'" + file + "': no such file (several files make a series; lists are written " +
                 "with commas and without blanks, as in vx,vy,vz)");
  std::vector<Chosen> chosen;
  with_exit_code(wrong_input, [&] {
    if (!options.frames.empty())
      for (const std::string& file : files)
        chosen.push_back(choose(file, options.frames, read_options(options)));
  });
  FramePlace place;
  const auto pass_on = [&](ParticleTable table, double progress) {
    place.progress = progress;
    place.description = table.source;
    use(std::move(table), place);
    ++place.number;
  };
  const double parts = static_cast<double>(files.size());
  for (std::size_t f = 0; f < files.size(); ++f) {
    const double before = static_cast<double>(f);
    if (options.frames.empty()) {
      pass_on(
          with_exit_code(wrong_input, [&] { return read_source(files[f], read_options(options)); }),
          (before + 1) / parts);
      continue;
    }
    FrameReader reader =
        with_exit_code(wrong_input, [&] { return open_source(files[f], read_options(options)); });
    while (reader.position() <= chosen[f].last) {
      const std::size_t at = reader.position();
      if (at < chosen[f].first || (at - chosen[f].first) % chosen[f].step != 0) {
        if (!with_exit_code(wrong_input, [&] { return reader.skip(); })) break;
        continue;
      }
      auto table = with_exit_code(wrong_input, [&] { return reader.next(); });
      if (!table) break;
      pass_on(std::move(*table), (before + reader.progress()) / parts);
    }
    if (!reader.cut().empty()) remarks.push_back(reader.cut());
  }
  return remarks;
}

}  // namespace recon::program
