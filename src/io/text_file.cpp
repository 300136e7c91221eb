#include "text_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "recon/core/names.hpp"

namespace recon::detail {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t block_size = 1 << 18;
constexpr std::size_t longest_line = 1 << 26;

[[noreturn]] void fail_missing(const fs::path& path) {
  std::error_code ignored;
  const fs::path directory = path.has_parent_path() ? path.parent_path() : ".";
  if (!fs::is_directory(directory, ignored))
    throw FileError(path, 0, "no such file: there is no directory " + directory.string());
  std::vector<std::string> names;
  for (fs::directory_iterator entry(directory, ignored), end; entry != end;
       entry.increment(ignored)) {
    if (ignored || names.size() == 10000) break;
    if (!entry->is_directory(ignored)) names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const std::string name = path.filename().string();
  const std::vector<std::string> near = nearest_names(name, names);
  throw FileError(path, 0, near.empty() ? "no such file" : "no such file; " + suggest(name, near));
}

struct Foreign {
  std::string_view start;
  const char* what;
};
using namespace std::string_view_literals;
constexpr std::array foreign_contents{
    Foreign{"\xfd"
            "7zXZ"sv,
            "compressed with xz; undo that first, or use gzip"},
    Foreign{"\x28\xb5\x2f\xfd"sv, "compressed with zstd; undo that first, or use gzip"},
    Foreign{"BZh"sv, "compressed with bzip2; undo that first, or use gzip"},
    Foreign{"PK\x03\x04"sv, "a zip archive or a spreadsheet; save it as CSV"},
    Foreign{"<?xml"sv, "XML; a VTK file can be saved as CSV from ParaView (File > Save Data)"},
    Foreign{"<VTKFile"sv, "a VTK file; save it as CSV from ParaView (File > Save Data)"},
    Foreign{"# vtk DataFile"sv, "a VTK file; save it as CSV from ParaView (File > Save Data)"},
    Foreign{"\xff\xfe"sv, "UTF-16 text; save it as UTF-8"},
    Foreign{"\xfe\xff"sv, "UTF-16 text; save it as UTF-8"},
    Foreign{"\x89HDF"sv, "an HDF5 file"},
};

}  // namespace

TextFile::TextFile(const fs::path& path) : path_(path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) fail_missing(path);
  if (fs::is_directory(status)) throw FileError(path, 0, "is a directory, a file is needed");
  if (!error && !fs::is_regular_file(status))
    throw FileError(path, 0, "is no ordinary file, and a reader needs to go back in it");
  file_.reset(gzopen(path.c_str(), "rbe"));
  if (!file_)
    throw FileError(path, 0, "cannot be opened: " + std::generic_category().message(errno));
  gzbuffer(file_.get(), 1 << 17);
  refill();
  refuse_foreign_content();
  if (buffer_.starts_with("\xef\xbb\xbf")) at_ = 3;  // byte order mark of UTF-8
}

void TextFile::refuse_foreign_content() {
  constexpr const char* expected = " (a LAMMPS text dump or delimited text is needed)";
  if (buffer_.empty()) throw FileError(path_, 0, std::string("is empty") + expected);
  for (const Foreign& foreign : foreign_contents)
    if (buffer_.starts_with(foreign.start))
      throw FileError(path_, 0, std::string("is ") + foreign.what + expected);
}

bool TextFile::refill() {
  if (ended_) return false;
  block_offset_ += static_cast<std::int64_t>(at_);
  buffer_.erase(0, at_);
  at_ = 0;
  if (buffer_.size() > longest_line) {
    ++line_;
    fail("the line is longer than 64 MiB: this is no table of particles");
  }
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + block_size);
  errno = 0;
  const int count = gzread(file_.get(), buffer_.data() + kept, static_cast<unsigned>(block_size));
  buffer_.resize(kept + static_cast<std::size_t>(std::max(count, 0)));
  int code = Z_OK;
  const char* message = gzerror(file_.get(), &code);
  if (code == Z_ERRNO)
    throw FileError(path_, 0, "cannot be read: " + std::string(std::strerror(errno)));
  if (code == Z_BUF_ERROR)
    throw FileError(path_, 0, "the gzip stream is cut off: the file is incomplete");
  if (count < 0 || code != Z_OK)
    throw FileError(path_, 0, "the gzip stream is damaged (" + std::string(message) + ")");
  if (count == 0) ended_ = true;
  return count > 0;
}

bool TextFile::next(std::string_view& line) {
  std::size_t searched = at_;
  for (;;) {
    const std::size_t end = buffer_.find('\n', searched);
    if (end != std::string::npos) {
      line = std::string_view(buffer_).substr(at_, end - at_);
      at_ = end + 1;
      break;
    }
    const std::size_t pending = buffer_.size() - at_;
    if (refill()) {
      searched = pending;  // refill() moved the pending bytes to the front
      continue;
    }
    if (at_ == buffer_.size()) return false;
    line = std::string_view(buffer_).substr(at_);
    at_ = buffer_.size();
    break;
  }
  ++line_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line.find('\0') != std::string_view::npos)
    fail("holds a NUL byte: this is a binary file, text is needed (LAMMPS: a dump without .bin)");
  return true;
}

void TextFile::go_to(Mark mark) {
  gzclearerr(file_.get());
  if (gzseek(file_.get(), static_cast<z_off_t>(mark.offset), SEEK_SET) < 0)
    throw FileError(path_, 0, "cannot go back in the file");
  buffer_.clear();
  at_ = 0;
  block_offset_ = mark.offset;
  line_ = mark.line;
  ended_ = false;
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ptr != end || text.empty()) return std::nullopt;
  if (result.ec == std::errc()) return value;
  if (result.ec != std::errc::result_out_of_range) return std::nullopt;
  // Too large or too small? A negative exponent tells; figures without one are too small if they
  // begin with zero.
  const std::size_t exponent = text.find_first_of("eE");
  const bool small = exponent != std::string_view::npos
                         ? text.substr(exponent + 1).starts_with('-')
                         : text.starts_with("0.") || text.starts_with("-0.");
  if (!small) return std::nullopt;
  return text.starts_with('-') ? -0.0 : 0.0;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ptr != end || result.ec != std::errc() || text.empty()) return std::nullopt;
  return value;
}

void split_at_blanks(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  const char* at = line.data();
  const char* const end = at + line.size();
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  for (;;) {
    while (at < end && blank(*at)) ++at;
    if (at == end) return;
    const char* const begin = at;
    while (at < end && !blank(*at)) ++at;
    cells.emplace_back(begin, static_cast<std::size_t>(at - begin));
  }
}

std::string_view trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string quote(std::string_view text) {
  constexpr std::size_t most = 60;
  std::string quoted = "'";
  for (const char c : text.substr(0, most))
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return quoted + (text.size() > most ? "...'" : "'");
}

}  // namespace recon::detail
