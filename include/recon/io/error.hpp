// Trouble with a file, answered with an exception that names the file, the line and the rule.
//
// what() reads "chute.dump:17: 'abc' is not a number: column vx needs one" or, where no line is to
// blame, "chute.dump: no such file". Wrong arguments of a call are InvalidArgument
// (core/error.hpp).
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace recon {

class FileError : public std::runtime_error {
 public:
  // The line is counted from 1; 0 where the trouble is not on a line.
  FileError(const std::filesystem::path& path, std::size_t line, const std::string& what);

  const std::filesystem::path& path() const { return path_; }
  std::size_t line() const { return line_; }

 private:
  std::filesystem::path path_;
  std::size_t line_;
};

}  // namespace recon
