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
  // named: as on a file system that knows no unnamed files.
  explicit AtomicFile(const std::filesystem::path& target, bool named = false);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  void commit();

  // For another program that writes the file: what it writes follows what was written before.
  int descriptor() const { return descriptor_; }
  // Where this process can open the file until the commit, whether it has a name or not.
  std::filesystem::path open_path() const;
  // For libraries that want a name: gives the file one, which stays if the process is killed.
  const std::filesystem::path& temporary();

 private:
  void flush();
  void discard() noexcept;
  // Each false where it fails; errno says why.
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
