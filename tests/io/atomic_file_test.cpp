#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

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

// Files without a name until the commit, and with one as where the file system knows no others.
class AtomicFiles : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Named, AtomicFiles, testing::Bool());

TEST_P(AtomicFiles, AppearsAtCommit) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.txt", GetParam());
  file.write("one ");
  file.write("two");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
  file.commit();
  EXPECT_EQ(bytes_of(folder / "a.txt"), "one two");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST_P(AtomicFiles, WithoutCommitNothingChanges) {
  const TemporaryFolder folder;
  folder.file("a.txt", "old");
  {
    AtomicFile file(folder / "a.txt", GetParam());
    file.write(std::string(1 << 20, 'x'));
  }
  EXPECT_EQ(bytes_of(folder / "a.txt"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST_P(AtomicFiles, FullDisk) {
  const TemporaryFolder folder;
  folder.file("a.txt", "old");
  {
    const SmallDisk disk(100000);
    expect_file_error(
        [&] {
          AtomicFile file(folder / "a.txt", GetParam());
          for (int i = 0; i < 1000; ++i) file.write(std::string(1000, 'x'));
          file.commit();
        },
        0, "cannot write");
    expect_file_error(
        [&] {  // noticed only when the buffer is written out
          AtomicFile file(folder / "a.txt", GetParam());
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

TEST_P(AtomicFiles, TheTargetTurnsIntoAFolder) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a", GetParam());
  file.write("x");
  std::filesystem::create_directory(folder / "a");
  expect_file_error([&] { file.commit(); }, 0, "cannot put the file in place");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST_P(AtomicFiles, ReplacesWhatIsThere) {
  const TemporaryFolder folder;
  for (const char* text : {"one", "two", "three"}) {
    AtomicFile file(folder / "a", GetParam());
    file.write(text);
    file.commit();
    EXPECT_EQ(bytes_of(folder / "a"), text);
    EXPECT_EQ(folder.entries(), 1u);
  }
}

TEST_P(AtomicFiles, CanBeOpenedByItsPath) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a", GetParam());
  EXPECT_EQ(folder.entries(), GetParam() ? 1u : 0u);
  std::ofstream(file.open_path(), std::ios::binary) << "by another library";
  EXPECT_EQ(bytes_of(file.open_path()), "by another library");
  EXPECT_EQ(bytes_of(file.temporary()), "by another library");
  EXPECT_EQ(file.temporary().parent_path(), folder.path());  // has a name from here on
  EXPECT_EQ(folder.entries(), 1u);
  file.commit();
  EXPECT_EQ(bytes_of(folder / "a"), "by another library");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST_P(AtomicFiles, ANameThatWasAskedForGoesToo) {
  const TemporaryFolder folder;
  { EXPECT_NE(AtomicFile(folder / "a", GetParam()).temporary(), ""); }
  EXPECT_EQ(folder.entries(), 0u);
}

// A process that is killed while it writes leaves nothing.
TEST(AtomicFile, Signals) {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP, SIGKILL, SIGSEGV}) {
    const TemporaryFolder folder;
    folder.file("old", "old");
    const pid_t child = fork();
    if (child == 0) {
      AtomicFile fresh(folder / "new"), old(folder / "old");
      for (AtomicFile* file : {&fresh, &old}) file->write(std::string(1 << 20, 'x'));
      signal(signal_number, SIG_DFL);
      kill(getpid(), signal_number);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal_number);
    EXPECT_EQ(bytes_of(folder / "old"), "old");
    EXPECT_EQ(folder.entries(), 1u) << "signal " << signal_number;
  }
}

TEST_P(AtomicFiles, KeepsPermissionsAndLinks) {
  const TemporaryFolder folder;
  chmod(folder.file("a", "old").c_str(), 0640);
  std::filesystem::create_symlink("a", folder / "link");
  AtomicFile file(folder / "link", GetParam());
  file.write("new");
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(bytes_of(folder / "a"), "new");
  struct stat status {};
  stat((folder / "a").c_str(), &status);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

}  // namespace
