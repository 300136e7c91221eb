// A file that appears complete or not at all.
//
// Bytes go to an unnamed file in the folder of the target; commit() writes what is buffered, checks
// that the disk took it, and puts it in place of the target in one step. Until then a file that was
// there before is untouched. Without a commit (an exception on the way, a signal, a crash) nothing
// is left, as the file never had a name. On file systems that know no unnamed files (NFS) it is
// called .recon-<process>-<number>.part; then it is removed unless the process is killed.
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
  // named: the file has a name from the start, as on file systems that know no unnamed files.
  explicit AtomicFile(const std::filesystem::path& target, bool named = false);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  void commit();

  // A descriptor for another program that writes the file; it continues what was written before.
  int descriptor() const { return descriptor_; }
  // The path by which this process can open the file before the commit, whether it
  // has a name or not.
  std::filesystem::path open_path() const;
  // Gives the file a name, for libraries that need one. It stays behind if the process is killed.
  const std::filesystem::path& temporary();

 private:
  void flush();
  void discard() noexcept;
  // Each returns false where it fails; errno says why.
  bool link_as(const std::filesystem::path& name) const noexcept;
  bool give_name() noexcept;
  bool put_in_place() noexcept;
  [[noreturn]] void fail(const std::string& action, int error);

  std::filesystem::path asked_, target_;
  std::filesystem::path temporary_;  // its name, if it has one
  int descriptor_ = -1;
  std::string buffer_;
};

}  // namespace recon
