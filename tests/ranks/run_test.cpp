// A run on ranks leaves what one process leaves, and goes on from where it was stopped.
#include "recon/ranks/run.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "ranks/folder.hpp"
#include "support/disk_and_box.hpp"

namespace recon::mpm::test {
namespace {

using recon::testing::world;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

ProblemFile<2> problem(const std::vector<std::string>& settings = {}) {
  return disk_and_box("cpls", settings);
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(RunOnRanks, GoesOnToTheBit) {
  const Folder folder;
  const ProblemFile<2> file = problem();
  const RunResult whole = run(world(), file, {.folder = folder.path / "whole"});
  EXPECT_EQ(whole.frames, 5u);
  EXPECT_FALSE(whole.stopped);
  ASSERT_TRUE(whole.spread);
  EXPECT_EQ(whole.spread->ranks, world().size());
  EXPECT_LE(whole.spread->least, whole.spread->most);
  // The last rank alone asks for a stop, and what was saved is said on the first one alone.
  int asked = 0, saved = 0;
  RunOptions options{.folder = folder.path / "parts"};
  options.stop = [&] { return ++asked == 20 && world().rank() == world().size() - 1; };
  options.saved = [&](double, std::int64_t) { ++saved; };
  const RunResult stopped = run(world(), file, options);
  EXPECT_TRUE(stopped.stopped);
  EXPECT_EQ(stopped.steps, 19);
  EXPECT_EQ(saved > 0, world().rank() == 0);
  const RunResult end =
      run(world(), file,
          {.folder = folder.path / "parts", .restart = folder.path / "parts" / "checkpoint.h5"});
  EXPECT_EQ(end.steps, whole.steps);
  EXPECT_EQ(end.frames, whole.frames);
  MPI_Barrier(world().get());
  std::size_t files = 0;
  for (const auto& each : fs::directory_iterator(folder.path / "whole")) {
    const fs::path name = each.path().filename();
    EXPECT_TRUE(read(each.path()) == read(folder.path / "parts" / name)) << name;
    ++files;
  }
  // Tables and checkpoint, lists of frames, frames; those of several ranks with a piece of each.
  const auto ranks = static_cast<std::size_t>(world().size());
  EXPECT_EQ(files, 3 + 2 + 2 * 5 * (ranks > 1 ? 1 + ranks : 1));
}

// A problem that differs in a number, in a formula or in where it is to be written.
TEST(RunOnRanks, DifferentProblemsAreRefused) {
  if (world().size() == 1) GTEST_SKIP() << "one rank has one problem";
  const bool last = world().rank() == world().size() - 1;
  const Folder folder;
  for (const char* setting : {"gravity=[0,-10.000001]", "body.velocity=[0,0]", "time.end=0.2",
                              "output.frames=5", "method.name=impm"}) {
    const ProblemFile<2> file =
        problem(last ? std::vector<std::string>{setting} : std::vector<std::string>{});
    EXPECT_THAT(
        recon::testing::refusal([&] { run(world(), file, {.folder = folder.path / "out"}); }),
        HasSubstr("different on some ranks"))
        << setting;
  }
  EXPECT_THAT(recon::testing::refusal(
                  [&] { run(world(), problem(), {.folder = folder.path / (last ? "b" : "a")}); }),
              HasSubstr("different on some ranks"));
  EXPECT_TRUE(fs::is_empty(folder.path));
}

// What goes wrong on the first rank, which writes, has the same type on all.
TEST(RunOnRanks, TroubleWithFilesIsThatOfAll) {
  const Folder folder;
  const ProblemFile<2> file = problem();
  if (world().rank() == 0) fs::create_directories(folder.path / "out" / "checkpoint.h5" / "x");
  MPI_Barrier(world().get());
  EXPECT_THROW(run(world(), file, {.folder = folder.path / "out"}), OtherRun);
  try {
    run(world(), file, {.folder = folder.path / "out", .overwrite = true});
    ADD_FAILURE() << "a folder was written over";
  } catch (const FileError& error) {
    EXPECT_EQ(error.path(), folder.path / "out" / "checkpoint.h5");
  }
  EXPECT_THROW(
      run(world(), file, {.folder = folder.path / "b", .restart = folder.path / "none.h5"}),
      NoRestart);
  EXPECT_FALSE(fs::exists(folder.path / "b"));
  // And a call that throws where others do not.
  RunOptions options{.folder = folder.path / "c"};
  options.stop = []() -> bool {
    if (world().rank() == world().size() - 1) throw std::runtime_error("no more");
    return false;
  };
  try {
    run(world(), file, options);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    const std::string rank = "rank " + std::to_string(world().size() - 1) + ": ";
    EXPECT_EQ(error.what(), (world().size() > 1 ? rank : "") + "no more");
  }
}

}  // namespace
}  // namespace recon::mpm::test
