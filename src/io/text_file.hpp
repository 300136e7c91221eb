// Lines of a text file, plain or gzip, one after another without holding the file in memory.
#pragma once

#include <zlib.h>

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

// Throws FileError for a file that cannot be opened or is not text, and for a damaged gzip stream.
class TextFile {
 public:
  // Where a line begins: to come back to it.
  struct Mark {
    std::int64_t offset;  // bytes, of the text after gzip is undone
    std::size_t line;     // number of the line before
  };

  explicit TextFile(const std::filesystem::path& path);

  // The next line, without its end (LF or CR LF); false at the end of the file. The view is valid
  // until the next call.
  bool next(std::string_view& line);

  const std::filesystem::path& path() const { return path_; }
  std::size_t line_number() const { return line_; }  // of the line read last
  Mark mark() const { return {block_offset_ + static_cast<std::int64_t>(at_), line_}; }
  void go_to(Mark mark);

  // Throws FileError at the line read last, or at `line`.
  [[noreturn]] void fail(const std::string& what) const { throw FileError(path_, line_, what); }
  [[noreturn]] void fail(std::size_t line, const std::string& what) const {
    throw FileError(path_, line, what);
  }

 private:
  struct Close {
    void operator()(gzFile_s* file) const { gzclose(file); }
  };
  bool refill();  // keeps buffer_ from at_ on; false at the end of the file
  void refuse_foreign_content();

  std::filesystem::path path_;
  std::unique_ptr<gzFile_s, Close> file_;
  std::string buffer_;
  std::size_t at_ = 0;             // where the next line begins in buffer_
  std::int64_t block_offset_ = 0;  // of buffer_ in the text
  std::size_t line_ = 0;
  bool ended_ = false;
};

// A number in decimal notation, nan and inf included; `text` must be nothing else. A leading '+' is
// allowed. Too large: infinity is not a substitute, so none; too small: 0.
std::optional<double> parse_number(std::string_view text);

std::optional<std::int64_t> parse_integer(std::string_view text);

// Appends to `cells` (after clearing it) the parts of the line between blanks and tabs.
void split_at_blanks(std::string_view line, std::vector<std::string_view>& cells);

std::string_view trim(std::string_view text);

// Text from a file in a message: quoted, cut to a bearable length, without control characters.
std::string quote(std::string_view text);

}  // namespace recon::detail
