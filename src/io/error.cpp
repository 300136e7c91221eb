#include "recon/io/error.hpp"

namespace recon {

namespace {

std::string message(const std::filesystem::path& path, std::size_t line, const std::string& what) {
  std::string text = path.string();
  if (line > 0) text.append(":").append(std::to_string(line));
  return text.append(": ").append(what);
}

}  // namespace

FileError::FileError(const std::filesystem::path& path, std::size_t line, const std::string& what)
    : std::runtime_error(message(path, line, what)), path_(path), line_(line) {}

}  // namespace recon
