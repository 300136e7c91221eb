#include "source.hpp"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>

namespace recon::program {

namespace fs = std::filesystem;

namespace {

bool is_pipe(const std::string& file) {
  if (file == "-") return true;
  std::error_code ignored;
  return fs::is_fifo(file, ignored);
}

std::string called(const std::string& file) {
  return file == "-" ? "standard input" : file;
}

// All that a pipe gave, read when it is first asked for.
const std::string& bytes_of(const std::string& file) {
  static std::map<std::string, std::string> kept;
  const auto found = kept.find(file);
  if (found != kept.end()) return found->second;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> opened(
      file == "-" ? nullptr : std::fopen(file.c_str(), "rb"),
      [](std::FILE* stream) { return stream != nullptr ? std::fclose(stream) : 0; });
  std::FILE* const stream = file == "-" ? stdin : opened.get();
  const auto fail = [&] {
    throw FileError(called(file), 0, "cannot be read: " + std::generic_category().message(errno));
  };
  if (stream == nullptr) fail();
  std::string bytes;
  constexpr std::size_t block = 1 << 20;
  for (std::size_t got = 1; got > 0;) {
    const std::size_t before = bytes.size();
    bytes.resize(before + block);
    got = std::fread(bytes.data() + before, 1, block, stream);
    bytes.resize(before + got);
  }
  if (std::ferror(stream) != 0) fail();
  return kept.emplace(file, std::move(bytes)).first->second;
}

}  // namespace

std::vector<FrameInfo> list_source(const std::string& file, const ReadOptions& options) {
  return is_pipe(file) ? list_frames_of(bytes_of(file), options, called(file))
                       : list_frames(file, options);
}

ParticleTable read_source(const std::string& file, const ReadOptions& options) {
  return is_pipe(file) ? read_particles_of(bytes_of(file), options, called(file))
                       : read_particles(file, options);
}

FrameReader open_source(const std::string& file, const ReadOptions& options) {
  return is_pipe(file) ? FrameReader(bytes_of(file), options, called(file))
                       : FrameReader(file, options);
}

}  // namespace recon::program
