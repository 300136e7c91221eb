// A file that appears complete or not at all.
//
// Bytes go to a temporary file beside the target; commit() writes what is buffered, checks that the
// disk took it, and renames the temporary file to the target in one step. Until then a file that
// was there before is untouched. Without a commit (an exception on the way) the temporary file is
// removed.
//
// A symbolic link is followed, and the permissions of a file that is replaced are kept. Refused
// with FileError: a directory that is missing or not writable, a target that is a directory, a
// device or write-protected, a disk that is full; nothing is left behind.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "recon/io/error.hpp"

namespace recon {

class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  void commit();

  // For another program that writes the file: what it writes follows what was written before.
  int descriptor() const { return descriptor_; }
  const std::filesystem::path& temporary() const { return temporary_; }

 private:
  void flush();
  void discard() noexcept;
  [[noreturn]] void fail(const std::string& action, int error);

  std::filesystem::path asked_, target_, temporary_;
  int descriptor_ = -1;
  std::string buffer_;
};

}  // namespace recon
