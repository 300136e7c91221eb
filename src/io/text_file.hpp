// Lines of a text file, plain or gzip, one after another without holding the file in memory.
#pragma once

#include <charconv>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recon/io/error.hpp"

namespace recon::detail {

// The bytes of a file or of memory, with gzip undone. A gzip file may have several members, one
// after another; anything else behind one is an error.
class ByteSource {
 public:
  explicit ByteSource(const std::filesystem::path& path);
  // Reads bytes in memory, which must outlive this object; `name` is for messages.
  ByteSource(std::string_view bytes, const std::filesystem::path& name);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Reads at most `count` of the next bytes; 0 at the end. Throws FileError for a damaged file.
  std::size_t read(char* to, std::size_t count);
  bool is_gzip() const { return inflater_ != nullptr; }
  // The next read() begins at this byte.
  void go_to(std::int64_t offset);
  // Whether the gzip stream ended too early; what was read until then is sound.
  bool cut() const { return cut_; }
  // The part of the bytes that has been read, from 0 to 1.
  double progress() const;

 private:
  struct Inflater;
  std::size_t read_raw(char* to, std::size_t count);
  void rewind_raw(std::int64_t offset);
  void detect_gzip();
  std::size_t inflate_some(char* to, std::size_t count);
  bool next_member();

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::string_view memory_;
  std::int64_t raw_at_ = 0, raw_size_ = 0, at_ = 0;
  std::unique_ptr<Inflater> inflater_;  // of a gzip file
  bool cut_ = false;
};

// Throws FileError for a file that cannot be opened or is not text, and for a damaged gzip stream.
class TextFile {
 public:
  // The place where a line begins, to come back to.
  struct Mark {
    std::int64_t offset;  // bytes, of the text after gzip is undone
    std::size_t line;     // number of the line before
    bool closed = true;   // whether a line break is behind that
  };

  explicit TextFile(const std::filesystem::path& path);
  TextFile(std::string_view bytes, const std::filesystem::path& name);

  // The next line, without its end (LF or CR LF); false at the end of the file. The view is valid
  // until the next call.
  bool next(std::string_view& line);

  // Whether the file has ended: next() found no line, or one without a line break, or the gzip
  // stream is cut off.
  bool ended() const { return at_end_ || source_.cut(); }
  // Whether the line read last has a line break behind it.
  bool line_is_closed() const { return closed_; }
  double progress() const { return source_.progress(); }

  const std::filesystem::path& path() const { return source_.path(); }
  std::size_t line_number() const { return line_; }  // of the line read last
  Mark mark() const { return {block_offset_ + static_cast<std::int64_t>(at_), line_, closed_}; }
  void go_to(Mark mark);

  // Throws FileError at the line read last, or at `line`.
  [[noreturn]] void fail(const std::string& what) const { throw FileError(path(), line_, what); }
  [[noreturn]] void fail(std::size_t line, const std::string& what) const {
    throw FileError(path(), line, what);
  }

 private:
  void start();
  bool refill();  // reads on, keeps buffer_ from at_ on; false at the end of the file
  void refuse_foreign_content();

  ByteSource source_;
  std::string buffer_;
  std::size_t at_ = 0;             // where the next line begins in buffer_
  std::int64_t block_offset_ = 0;  // of buffer_ in the text
  std::size_t line_ = 0;
  bool at_end_ = false, closed_ = true;
};

// A number in decimal notation, nan and inf included; `text` must be nothing else. A leading
// '+' is allowed. A number too large for double has no value (infinity is no substitute), one
// too small is 0.
std::optional<double> parse_number(std::string_view text);

std::optional<std::int64_t> parse_integer(std::string_view text);

// Appends to `cells` (after clearing it) the parts of the line between blanks and tabs.
void split_at_blanks(std::string_view line, std::vector<std::string_view>& cells);

std::string_view trim(std::string_view text);

// Text from a file as messages show it: quoted, shortened where it is long, without
// control characters.
std::string quote(std::string_view text);

}  // namespace recon::detail
