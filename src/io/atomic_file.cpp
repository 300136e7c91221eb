#include "recon/io/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <system_error>

namespace recon {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t buffer_size = 1 << 18;

// A name that no other file of this process has; other processes have another number.
std::string unique_name() {
  static std::atomic<unsigned> count{0};
  return ".recon-" + std::to_string(getpid()) + "-" + std::to_string(count++) + ".part";
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& target) : asked_(target), target_(target) {
  std::error_code ignored;
  if (target.filename().empty()) throw FileError(asked_, 0, "a file name is needed");
  if (fs::is_symlink(target, ignored)) target_ = fs::weakly_canonical(target, ignored);
  if (target_.empty()) throw FileError(asked_, 0, "the symbolic link cannot be followed");
  const fs::path directory = target_.has_parent_path() ? target_.parent_path() : ".";
  if (!fs::is_directory(directory, ignored))
    throw FileError(asked_, 0, "there is no directory " + directory.string() + " to write it to");

  struct stat old {};
  const bool replaces = stat(target_.c_str(), &old) == 0;
  if (replaces && !S_ISREG(old.st_mode))
    throw FileError(asked_, 0, "only an ordinary file can be replaced, and this is none");
  if (replaces && access(target_.c_str(), W_OK) != 0)
    throw FileError(asked_, 0, "the file is write-protected");

  do {
    temporary_ = directory / unique_name();
    descriptor_ = open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) fail("cannot create a file in " + directory.string(), errno);
  if (replaces && fchmod(descriptor_, old.st_mode & 07777) != 0)
    fail("cannot keep the permissions", errno);
}

AtomicFile::~AtomicFile() {
  discard();
}

void AtomicFile::discard() noexcept {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(temporary_.c_str());
  descriptor_ = -1;
}

void AtomicFile::fail(const std::string& action, int error) {
  discard();
  throw FileError(asked_, 0, action + ": " + std::generic_category().message(error));
}

void AtomicFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= buffer_size) flush();
}

void AtomicFile::flush() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t count = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("cannot write", count < 0 ? errno : EIO);
    done += static_cast<std::size_t>(count);
  }
  buffer_.clear();
}

void AtomicFile::commit() {
  flush();
  if (fsync(descriptor_) != 0 && errno != EINVAL) fail("cannot write", errno);
  const int descriptor = descriptor_;
  descriptor_ = -1;
  const bool closed = close(descriptor) == 0;
  if (closed && rename(temporary_.c_str(), target_.c_str()) == 0) return;
  const int error = errno;
  unlink(temporary_.c_str());
  throw FileError(asked_, 0,
                  (closed ? "cannot put the file in place: " : "cannot write: ") +
                      std::generic_category().message(error));
}

}  // namespace recon
