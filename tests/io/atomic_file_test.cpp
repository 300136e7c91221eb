#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "recon/io/atomic_file.hpp"
#include "temporary.hpp"

namespace {

using recon::AtomicFile;
using test::bytes_of;
using test::expect_file_error;
using test::TemporaryFolder;

// While it lives, files cannot grow beyond a size: as on a full disk, a write fails.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    handler_ = signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit small{bytes, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &old_);
    signal(SIGXFSZ, handler_);
  }

 private:
  rlimit old_{};
  void (*handler_)(int);
};

TEST(AtomicFile, AppearsAtCommit) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.txt");
  file.write("one ");
  file.write("two");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
  file.commit();
  EXPECT_EQ(bytes_of(folder / "a.txt"), "one two");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, WithoutCommitNothingChanges) {
  const TemporaryFolder folder;
  folder.file("a.txt", "old");
  {
    AtomicFile file(folder / "a.txt");
    file.write(std::string(1 << 20, 'x'));
  }
  EXPECT_EQ(bytes_of(folder / "a.txt"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, FullDisk) {
  const TemporaryFolder folder;
  folder.file("a.txt", "old");
  {
    const SmallDisk disk(100000);
    expect_file_error(
        [&] {
          AtomicFile file(folder / "a.txt");
          for (int i = 0; i < 1000; ++i) file.write(std::string(1000, 'x'));
          file.commit();
        },
        0, "cannot write");
    expect_file_error(
        [&] {  // noticed only when the buffer is written out
          AtomicFile file(folder / "a.txt");
          file.write(std::string(150000, 'x'));
          file.commit();
        },
        0, "cannot write");
  }
  EXPECT_EQ(bytes_of(folder / "a.txt"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, PlacesThatCannotBeWritten) {
  const TemporaryFolder folder;
  expect_file_error([&] { AtomicFile(folder.path() / "none" / "a"); }, 0, "there is no directory");
  expect_file_error([&] { AtomicFile file(folder.path()); }, 0, "ordinary file");
  expect_file_error([&] { AtomicFile file("/dev/full"); }, 0, "ordinary file");
  expect_file_error([&] { AtomicFile file("/proc/recon.csv"); }, 0, "cannot create a file");
  expect_file_error([&] { AtomicFile file(""); }, 0, "file name");
  if (geteuid() != 0) {  // root may write anywhere
    std::filesystem::create_directory(folder / "locked");
    chmod((folder / "locked").c_str(), 0555);
    expect_file_error([&] { AtomicFile(folder.path() / "locked" / "a"); }, 0, "cannot create");
    chmod(folder.file("b", "old").c_str(), 0444);
    expect_file_error([&] { AtomicFile file(folder / "b"); }, 0, "write-protected");
  }
}

TEST(AtomicFile, TheTargetTurnsIntoAFolder) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a");
  file.write("x");
  std::filesystem::create_directory(folder / "a");
  expect_file_error([&] { file.commit(); }, 0, "cannot put the file in place");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, KeepsPermissionsAndLinks) {
  const TemporaryFolder folder;
  chmod(folder.file("a", "old").c_str(), 0640);
  std::filesystem::create_symlink("a", folder / "link");
  AtomicFile file(folder / "link");
  file.write("new");
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(bytes_of(folder / "a"), "new");
  struct stat status {};
  stat((folder / "a").c_str(), &status);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

}  // namespace
