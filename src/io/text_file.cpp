#include "text_file.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>
#include <system_error>

#include "recon/core/names.hpp"
#include "recon/fields/utf8.hpp"

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
    Foreign{"<?xml"sv, "XML, but no VTK file"},
    Foreign{"\xff\xfe"sv, "UTF-16 text; save it as UTF-8"},
    Foreign{"\xfe\xff"sv, "UTF-16 text; save it as UTF-8"},
};

}  // namespace

// --- bytes ---------------------------------------------------------------------------------------

struct ByteSource::Inflater {
  z_stream stream{};
  std::string input = std::string(1 << 17, '\0');
  bool ended = false;  // all members, and nothing behind them
  Inflater() {
    constexpr int gzip_window = 15 + 16;
    if (inflateInit2(&stream, gzip_window) != Z_OK) throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&stream); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
};

ByteSource::ByteSource(const fs::path& path) : path_(path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) fail_missing(path);
  if (fs::is_directory(status)) throw FileError(path, 0, "is a directory, a file is needed");
  if (!error && !fs::is_regular_file(status))
    throw FileError(path, 0, "is no ordinary file, and a reader needs to go back in it");
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw FileError(path, 0, "cannot be opened: " + std::generic_category().message(errno));
  raw_size_ = static_cast<std::int64_t>(fs::file_size(path, error));
  if (error) raw_size_ = 0;
  detect_gzip();
}

ByteSource::ByteSource(std::string_view bytes, const fs::path& name)
    : path_(name), memory_(bytes), raw_size_(static_cast<std::int64_t>(bytes.size())) {
  detect_gzip();
}

ByteSource::~ByteSource() {
  if (descriptor_ >= 0) close(descriptor_);
}

void ByteSource::detect_gzip() {
  char magic[2] = {};
  const std::size_t count = read_raw(magic, 2);
  rewind_raw(0);
  if (count == 2 && magic[0] == '\x1f' && magic[1] == '\x8b')
    inflater_ = std::make_unique<Inflater>();
}

std::size_t ByteSource::read_raw(char* to, std::size_t count) {
  std::size_t done = 0;
  if (descriptor_ < 0) {
    done = std::min(count, memory_.size() - static_cast<std::size_t>(raw_at_));
    std::copy_n(memory_.data() + raw_at_, done, to);
  }
  while (descriptor_ >= 0 && done < count) {
    const ssize_t got = ::read(descriptor_, to + done, count - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw FileError(path_, 0, "cannot be read: " + std::generic_category().message(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  raw_at_ += static_cast<std::int64_t>(done);
  return done;
}

void ByteSource::rewind_raw(std::int64_t offset) {
  if (descriptor_ >= 0 && lseek(descriptor_, offset, SEEK_SET) < 0)
    throw FileError(path_, 0, "cannot go back in the file");
  raw_at_ = std::min(offset, descriptor_ < 0 ? raw_size_ : offset);
}

// Whether another member follows the one that ended. Zeros behind the last one are the padding of a
// tape; anything else would be lost.
bool ByteSource::next_member() {
  Inflater& gzip = *inflater_;
  z_stream& stream = gzip.stream;
  bool zeros = false;
  for (;;) {
    if (stream.avail_in < 2) {
      if (stream.avail_in == 1) gzip.input[0] = static_cast<char>(*stream.next_in);
      const std::size_t kept = stream.avail_in;
      const std::size_t got = read_raw(gzip.input.data() + kept, gzip.input.size() - kept);
      stream.next_in = reinterpret_cast<Bytef*>(gzip.input.data());
      stream.avail_in = static_cast<uInt>(kept + got);
      if (stream.avail_in == 0) return false;
    }
    if (!zeros && stream.avail_in >= 2 && stream.next_in[0] == 0x1f && stream.next_in[1] == 0x8b)
      return inflateReset(&stream) == Z_OK;
    zeros = true;
    for (; stream.avail_in > 0; --stream.avail_in)
      if (*stream.next_in++ != 0)
        throw FileError(path_, 0,
                        "the gzip data is followed by other bytes (text appended without gzip?): "
                        "the file is damaged");
  }
}

std::size_t ByteSource::inflate_some(char* to, std::size_t count) {
  Inflater& gzip = *inflater_;
  z_stream& stream = gzip.stream;
  if (cut_) throw FileError(path_, 0, "the gzip stream is cut off: the file is incomplete");
  stream.next_out = reinterpret_cast<Bytef*>(to);
  stream.avail_out = static_cast<uInt>(count);
  while (stream.avail_out > 0 && !gzip.ended) {
    if (stream.avail_in == 0) {
      const std::size_t got = read_raw(gzip.input.data(), gzip.input.size());
      stream.next_in = reinterpret_cast<Bytef*>(gzip.input.data());
      stream.avail_in = static_cast<uInt>(got);
      if (got == 0) {
        cut_ = true;
        if (stream.avail_out < count) break;  // the next call says it
        throw FileError(path_, 0, "the gzip stream is cut off: the file is incomplete");
      }
    }
    const int code = inflate(&stream, Z_NO_FLUSH);
    if (code == Z_STREAM_END) {
      gzip.ended = !next_member();
    } else if (code == Z_MEM_ERROR) {
      throw std::bad_alloc();
    } else if (code != Z_OK && code != Z_BUF_ERROR) {
      throw FileError(path_, 0,
                      "the gzip stream is damaged (" +
                          std::string(stream.msg ? stream.msg : "needs a dictionary") + ")");
    }
  }
  return count - stream.avail_out;
}

std::size_t ByteSource::read(char* to, std::size_t count) {
  const std::size_t got = inflater_ ? inflate_some(to, count) : read_raw(to, count);
  at_ += static_cast<std::int64_t>(got);
  return got;
}

void ByteSource::go_to(std::int64_t offset) {
  if (!inflater_) {
    rewind_raw(offset);
    at_ = offset;
    return;
  }
  if (offset < at_) {
    rewind_raw(0);
    inflater_->ended = cut_ = false;
    inflater_->stream.avail_in = 0;
    inflateReset(&inflater_->stream);
    at_ = 0;
  }
  std::string skipped(block_size, '\0');
  while (at_ < offset) {
    const auto left = static_cast<std::size_t>(offset - at_);
    if (read(skipped.data(), std::min(left, skipped.size())) == 0)
      throw FileError(path_, 0, "cannot go back in the file");
  }
}

double ByteSource::progress() const {
  return raw_size_ > 0 ? static_cast<double>(raw_at_) / static_cast<double>(raw_size_) : 1.0;
}

// --- lines ---------------------------------------------------------------------------------------

TextFile::TextFile(const fs::path& path) : source_(path) {
  start();
}

TextFile::TextFile(std::string_view bytes, const fs::path& name) : source_(bytes, name) {
  start();
}

void TextFile::start() {
  refill();
  refuse_foreign_content();
  if (buffer_.starts_with("\xef\xbb\xbf")) at_ = 3;  // byte order mark of UTF-8
}

void TextFile::refuse_foreign_content() {
  constexpr const char* expected =
      " (a LAMMPS text dump, delimited text, XYZ, VTK or HDF5 is needed)";
  if (buffer_.empty()) throw FileError(path(), 0, std::string("is empty") + expected);
  for (const Foreign& foreign : foreign_contents)
    if (buffer_.starts_with(foreign.start))
      throw FileError(path(), 0, std::string("is ") + foreign.what + expected);
}

bool TextFile::refill() {
  block_offset_ += static_cast<std::int64_t>(at_);
  buffer_.erase(0, at_);
  at_ = 0;
  if (buffer_.size() > longest_line) {
    ++line_;
    fail("the line is longer than 64 MiB: this is no table of particles");
  }
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + block_size);
  std::size_t count = 0;
  try {
    count = source_.read(buffer_.data() + kept, block_size);
  } catch (...) {
    buffer_.resize(kept);
    throw;
  }
  buffer_.resize(kept + count);
  return count > 0;
}

bool TextFile::next(std::string_view& line) {
  std::size_t searched = at_;
  for (;;) {
    const std::size_t end = buffer_.find('\n', searched);
    if (end != std::string::npos) {
      line = std::string_view(buffer_).substr(at_, end - at_);
      at_ = end + 1;
      closed_ = true;
      break;
    }
    const std::size_t pending = buffer_.size() - at_;
    if (refill()) {
      searched = pending;  // refill() moved the pending bytes to the front
      continue;
    }
    at_end_ = true;
    if (at_ == buffer_.size()) return false;
    closed_ = false;
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
  const std::int64_t in_buffer = mark.offset - block_offset_;
  if (in_buffer >= 0 && in_buffer <= static_cast<std::int64_t>(buffer_.size())) {
    at_ = static_cast<std::size_t>(in_buffer);
  } else {
    source_.go_to(mark.offset);
    buffer_.clear();
    at_ = 0;
    block_offset_ = mark.offset;
  }
  line_ = mark.line;
  at_end_ = false;
  closed_ = mark.closed;
}

// --- numbers and words ---------------------------------------------------------------------------

namespace {

// The power of ten of the first figure of a decimal number, for one that double cannot hold: beyond
// 300 it is too large, below -300 too small.
std::int64_t power_of_ten(std::string_view text) {
  constexpr std::int64_t bound = std::int64_t{1} << 60;
  const std::size_t letter = std::min(text.find_first_of("eE"), text.size());
  std::string_view figures = text.substr(0, letter);
  std::int64_t exponent = 0;
  if (letter < text.size()) {
    std::string_view digits = text.substr(letter + 1);
    if (digits.starts_with('+')) digits.remove_prefix(1);
    if (std::from_chars(digits.data(), digits.data() + digits.size(), exponent).ec != std::errc())
      exponent = digits.starts_with('-') ? -bound : bound;  // of more figures than 64 bits hold
    exponent = std::clamp(exponent, -bound, bound);
  }
  const auto point = static_cast<std::int64_t>(std::min(figures.find('.'), figures.size()));
  const auto first =
      static_cast<std::int64_t>(std::min(figures.find_first_of("123456789"), figures.size()));
  return exponent + (first < point ? point - first - 1 : point - first);
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ptr != end || text.empty()) return std::nullopt;
  if (result.ec == std::errc()) return value;
  if (result.ec != std::errc::result_out_of_range || power_of_ten(text) > 0) return std::nullopt;
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
  std::size_t most = 60;
  const std::string known = recon::to_utf8(text);
  while (most < known.size() && (static_cast<unsigned char>(known[most]) & 0xC0) == 0x80) --most;
  std::string quoted = "'";
  for (const char c : std::string_view(known).substr(0, most))
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return quoted + (known.size() > most ? "...'" : "'");
}

}  // namespace recon::detail
