#include "gnuplot.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <system_error>

#include "number_text.hpp"
#include "recon/core/error.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/picture.hpp"

extern char** environ;

namespace recon {

namespace {

namespace fs = std::filesystem;

struct CloseStream {
  void operator()(std::FILE* stream) const { std::fclose(stream); }
};
using Stream = std::unique_ptr<std::FILE, CloseStream>;

// A file without a name, gone when it is closed.
Stream nameless_file(const fs::path& picture) {
  Stream stream(std::tmpfile());
  if (!stream)
    throw FileError(picture, 0,
                    "no temporary file for gnuplot: " + std::generic_category().message(errno));
  fcntl(fileno(stream.get()), F_SETFD, FD_CLOEXEC);
  return stream;
}

// Exit status of gnuplot, which reads `input` and writes to `output` and `messages`.
int spawn_gnuplot(const fs::path& picture, int input, int output, int messages) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
  char name[] = "gnuplot", defaults[] = "-d";  // -d: without the user's own settings
  char* arguments[] = {name, defaults, nullptr};
  pid_t process = 0;
  const int error = posix_spawnp(&process, name, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    throw FileError(picture, 0,
                    "gnuplot, which draws the pictures, cannot be started (" +
                        std::generic_category().message(error) +
                        "); Debian: apt-get install gnuplot-nox");
  int status = 0;
  while (waitpid(process, &status, 0) < 0)
    if (errno != EINTR) return 0;  // someone else waits for all children: the picture will tell
  return status;
}

std::string contents(std::FILE* stream) {
  std::string text;
  std::rewind(stream);
  char block[4096];
  while (const std::size_t count = std::fread(block, 1, sizeof block, stream))
    text.append(block, count);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

// gnuplot does not notice a disk that is full: look at the end of what it wrote.
bool is_complete(const fs::path& file, bool svg) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (svg) return bytes.find("</svg>") != std::string::npos;
  return bytes.starts_with("\x89PNG\r\n\x1a\n") &&
         bytes.ends_with(std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12));
}

}  // namespace

namespace detail {

// In double quotes, with octal numbers for the signs that gnuplot expands there, and for digits
// that would be taken as part of such a number. (In single quotes two apostrophes in a row fail.)
std::string gnuplot_string(const std::string& text) {
  std::string quoted(1, '"');
  bool after_number = false;
  for (const char c : text) {
    const unsigned char byte = static_cast<unsigned char>(c);
    after_number = std::string_view("\"\\`@").find(c) != std::string_view::npos ||
                   (after_number && std::isdigit(byte) != 0);
    if (after_number) {
      quoted += '\\';
      for (const int shift : {6, 3, 0}) quoted += static_cast<char>('0' + ((byte >> shift) & 7));
    } else {
      quoted += byte < 0x20 || byte == 0x7f ? ' ' : c;
    }
  }
  quoted += '"';
  return quoted;
}

void run_gnuplot(const fs::path& path, int width, int height, double scale,
                 const std::string& script) {
  require_picture_extension(path);
  require(std::isfinite(scale) && scale >= 0.1 && scale <= 10, "scale of the picture", scale,
          "must be within 0.1 to 10");
  const bool svg = path.extension() == ".svg" || path.extension() == ".SVG";
  AtomicFile picture(path);
  const Stream input = nameless_file(path), messages = nameless_file(path);

  std::string text =
      join(svg ? "set terminal svg standalone" : "set terminal pngcairo", " size ",
           std::round(width * scale), ",", std::round(height * scale),
           " enhanced background '#ffffff' font 'Sans,12' fontscale ", scale, " linewidth ", scale);
  if (!svg) text += join(" pointscale ", scale);
  text += join("\nset encoding utf8\n", script);
  const bool written = std::fwrite(text.data(), 1, text.size(), input.get()) == text.size() &&
                       std::fflush(input.get()) == 0;
  if (!written) throw FileError(path, 0, "no room for gnuplot's script in the temporary folder");
  std::rewind(input.get());

  const int status =
      spawn_gnuplot(path, fileno(input.get()), picture.descriptor(), fileno(messages.get()));
  const bool succeeded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!succeeded) throw FileError(path, 0, "gnuplot failed; it said: " + contents(messages.get()));
  if (!is_complete(picture.open_path(), svg))
    throw FileError(path, 0,
                    "gnuplot wrote an incomplete picture (is the disk full?); it said: " +
                        contents(messages.get()));
  picture.commit();
}

}  // namespace detail

}  // namespace recon
