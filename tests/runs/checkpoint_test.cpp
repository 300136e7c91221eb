// Checkpoints: to which problem they belong, damage, contents that no run can have, full disks.
#include <gmock/gmock.h>
#include <hdf5.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "recon/runs/run.hpp"
#include "runs/support.hpp"
#include "support/checkpoint_seal.hpp"

namespace recon::mpm::test {
namespace {

using recon::test::seal_size;
using recon::test::sealed;
using testing::AllOf;
using testing::HasSubstr;

const std::string base = R"(title = "t"
[constants]
A = 0.1
[grid]
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = 4
[material]
young = 1000
poisson = 0.3
density = 1
[[body]]
shape = "box"
lower = [0.25, 0.25]
upper = [0.75, 0.75]
velocity = ["A", 0]
[[boundary]]
axis = "x"
at = 0
kind = "roller"
[loads]
body_force = ["-A * x", 0]
[method]
name = "cpls"
[time]
end = 0.01
[output]
frames = 1
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = base;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

ProblemFile<2> file_of(const std::string& text, const std::vector<std::string>& settings = {}) {
  return std::get<ProblemFile<2>>(read_problem_text(text, "p.toml", settings));
}

class MpmCheckpoint : public InFolder {
 protected:
  MpmCheckpoint() { write(base, {}); }

  // A checkpoint of this problem after three steps.
  void write(const std::string& text, const std::vector<std::string>& settings) {
    const ProblemFile<2> file = file_of(text, settings);
    Simulation<2> simulation(file.problem);
    for (int s = 0; s < 3; ++s) simulation.step(simulation.choose_step().dt);
    write_checkpoint(path(), simulation, file.formulas,
                     {.start = {}, .frame_times = {0, simulation.time() / 2}});
    whole_ = contents(path());
  }
  // What reading it for this problem says; nothing where it is accepted.
  std::string refusal(const std::string& text, const std::vector<std::string>& settings = {}) {
    const ProblemFile<2> file = file_of(text, settings);
    Simulation<2> simulation(file.problem);
    try {
      read_checkpoint(path(), simulation, file.formulas);
    } catch (const FileError& error) {
      EXPECT_EQ(simulation.steps(), 0);
      return error.what();
    }
    EXPECT_EQ(simulation.steps(), 3);
    return "";
  }
  std::string refusal_of(const std::string& bytes) {
    std::ofstream(path(), std::ios::binary) << bytes;
    return refusal(base);
  }
  // After `change` by the HDF5 library, with a new seal.
  template <class Change>
  std::string refusal_after(const Change& change) {
    std::ofstream(path(), std::ios::binary) << whole_;
    const hid_t file = H5Fopen(path().c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    EXPECT_GE(file, 0);
    change(file);
    EXPECT_GE(H5Fclose(file), 0);
    return refusal_of(sealed(contents(path())));
  }
  std::filesystem::path path() const { return folder_ / "checkpoint.h5"; }

  std::string whole_;
};

// A run through the end of a period goes on from a checkpoint to the last bit.
TEST_F(MpmCheckpoint, GoesOnThroughAPeriod) {
  const auto text = [&](const std::string& periodic) {
    std::string of = changed("[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"roller\"\n", "");
    of.replace(of.find("[\"-A * x\", 0]"), 13, "[\"-A * sin(2*pi*x)\", 0]");
    of.replace(of.find("[\"A\", 0]"), 8, "[30, 0]");
    of.replace(of.find("cells = 4"), 9, "cells = 4\nperiodic = " + periodic);
    return of.replace(of.find("cpls"), 4, "cpdi2");
  };
  const ProblemFile<2> file = file_of(text("[true, false]"));
  Simulation<2> whole(file.problem), second(file.problem);
  for (int s = 0; s < 3; ++s) whole.step(0.003);
  write_checkpoint(path(), whole, file.formulas, {.start = {}, .frame_times = {0}});
  for (int s = 0; s < 3; ++s) whole.step(0.003);
  read_checkpoint(path(), second, file.formulas);
  for (int s = 0; s < 3; ++s) second.step(0.003);
  double least = 1;
  for (std::size_t p = 0; p < whole.particles().size(); ++p) {
    EXPECT_EQ(whole.particles().x[p], second.particles().x[p]);
    EXPECT_EQ(whole.particles().X[p], second.particles().X[p]);
    EXPECT_EQ(whole.particles().corners[p], second.particles().corners[p]);
    EXPECT_EQ(whole.particles().stress[p], second.particles().stress[p]);
    least = std::min(least, whole.particles().x[p][0]);
  }
  EXPECT_LT(least, 0.25);  // some have come in at the other end
  EXPECT_THAT(refusal(text("[false, false]")), HasSubstr("grid.lower is -1, 0 in the checkpoint"));
}

// The text of a formula that a boundary holds is a part of the problem.
TEST_F(MpmCheckpoint, KnowsTheVelocitiesOfItsBoundaries) {
  const auto text = [&](const std::string& velocity) {
    return changed("kind = \"roller\"", "kind = \"velocity\"\nvelocity = [" + velocity + ", 0]");
  };
  write(text("\"0.1 * t\""), {});
  EXPECT_EQ(refusal(text("\"0.1 * t\"")), "");
  EXPECT_THAT(refusal(text("\"0.2 * t\"")),
              AllOf(HasSubstr("boundary 1.velocity is"), HasSubstr("0.1 * t"),
                    HasSubstr("in the checkpoint"), HasSubstr("0.2 * t")));
  EXPECT_THAT(refusal(text("0.1")),
              AllOf(HasSubstr("boundary 1.velocity is"), HasSubstr("0.1, 0 now")));
}

TEST_F(MpmCheckpoint, BelongsToItsProblem) {
  EXPECT_EQ(refusal(base), "");
  // What may differ.
  for (const char* setting : {"title=u", "threads=2", "end=3", "rule=p_wave", "courant=0.1",
                              "frames=7", "ledger=false", "output.fields=[]"})
    EXPECT_EQ(refusal(base, {setting}), "") << setting;
  EXPECT_EQ(refusal(changed("[\"A\", 0]", "[\"A\", 0.0]")), "");

  struct Case {
    const char *setting, *difference;
  };
  for (const auto& [setting, difference] : {
           Case{"young=9999", "body 1.young is 1000 in the checkpoint, 9999 now"},
           Case{"poisson=0.2", "body 1.poisson is 0.3 in the checkpoint, 0.2 now"},
           Case{"density=2", "body 1.density is 1 in the checkpoint, 2 now"},
           Case{"material.kind=linear_elastic",
                "body 1.kind is neo_hookean in the checkpoint, linear_elastic now"},
           Case{"cells=8", "grid.cells is 4 in the checkpoint, 8 now"},
           Case{"grid.upper=[2.0, 1.0]", "grid.upper is 1, 1 in the checkpoint, 2, 1 now"},
           Case{"name=mpm", "method.domain is cpdi1 in the checkpoint, point now"},
           Case{"degree=2", "method.degree is 1 in the checkpoint, 2 now"},
           Case{"momentum_correction=true",
                "method.momentum_correction is false in the checkpoint, true now"},
           Case{"negative_mass=stop", "method.negative_mass is report in the checkpoint, stop now"},
           Case{"particles=3", "body 1.number of particles is 16 in the checkpoint, 36 now"},
           Case{"body.layout=jittered", "its place at the start or its size is another one"},
           Case{"gravity=[0, -1]", "loads.gravity is 0, 0 in the checkpoint, 0, -1 now"},
           Case{"boundary.kind=fixed",
                "boundary 1.velocity is 0, free in the checkpoint, 0, 0 now"},
           Case{"boundary.at=1", "boundary 1.at is 0 in the checkpoint, 1 now"},
           Case{"constants.A=0.2", "constants.A is 0.1 in the checkpoint, 0.2 now"},
           Case{"body.velocity=[1, 0]",
                "body 1.velocity is ['A', 0] in the checkpoint, [1, 0] now"},
           Case{"loads.body_force=[0, 0]",
                "loads.body_force is ['-A * x', 0] in the checkpoint, [0, 0] now"},
       })
    EXPECT_THAT(refusal(base, {setting}),
                AllOf(HasSubstr("checkpoint.h5: "), HasSubstr(difference)))
        << setting;

  EXPECT_THAT(
      refusal(changed("[[boundary]]",
                      "[[pressure]]\nside = \"x_upper\"\nmagnitude = \"2 * t\"\n[[boundary]]")),
      HasSubstr("the number of loaded particles is 0 in the checkpoint, 4 now"));
  EXPECT_THAT(refusal(changed("[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"roller\"", "")),
              HasSubstr("the number of boundaries is 1 in the checkpoint, 0 now"));
  // The same particles as two bodies.
  EXPECT_THAT(
      refusal(changed("upper = [0.75, 0.75]\nvelocity = [\"A\", 0]",
                      "upper = [0.5, 0.75]\nvelocity = [\"A\", 0]\n[[body]]\nshape = \"box\"\n"
                      "lower = [0.5, 0.25]\nupper = [0.75, 0.75]")),
      HasSubstr("the number of bodies is 1 in the checkpoint, 2 now"));
  Simulation<1> other(block<1>(10, 0.2, 0.4));
  try {
    read_checkpoint(path(), other, {});
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the number of dimensions is 2 in the checkpoint, 1 now"));
  }
}

// Numbers of loads count, and formulas that no number shows.
TEST_F(MpmCheckpoint, LoadsAndSolutionsCount) {
  const std::string pressed = changed(
      "[[boundary]]", "[[pressure]]\nside = \"x_upper\"\nmagnitude = \"2 * t\"\n[[boundary]]");
  write(pressed, {});
  EXPECT_EQ(refusal(pressed), "");
  EXPECT_THAT(refusal(pressed, {"pressure.magnitude=3"}),
              HasSubstr("pressure 1.magnitude is '2 * t' in the checkpoint, 3 now"));
  EXPECT_THAT(refusal(pressed, {"pressure.side=x_lower"}), HasSubstr("load 1 is particle"));
}

TEST_F(MpmCheckpoint, DamageIsFound) {
  EXPECT_EQ(refusal_of(whole_), "");
  EXPECT_EQ(refusal_of(sealed(whole_)), "");
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    std::string bytes = whole_;
    const std::size_t at = random() % bytes.size();
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
    EXPECT_NE(refusal_of(bytes), "") << at;
    if (at >= seal_size) {
      EXPECT_THAT(refusal_of(bytes), HasSubstr("is damaged")) << at;
    }
  }
  EXPECT_THAT(refusal_of(whole_.substr(0, whole_.size() - 1)), HasSubstr("is damaged"));
  EXPECT_THAT(refusal_of(whole_ + "x"), HasSubstr("is damaged"));
  EXPECT_THAT(refusal_of(whole_.substr(0, 100)), HasSubstr("is damaged"));
  EXPECT_THAT(refusal_of(""), HasSubstr("is no checkpoint"));
  EXPECT_THAT(refusal_of("not HDF5"), HasSubstr("is no checkpoint"));
  EXPECT_THAT(refusal_of(whole_.substr(seal_size)), HasSubstr("earlier version"));
  std::string later = whole_;
  EXPECT_THAT(refusal_of(later.replace(later.find("format 3"), 8, "format 7")),
              HasSubstr("is a checkpoint of format 7, this version reads format 3"));
  EXPECT_THAT(refusal_of(sealed(whole_.substr(0, seal_size) + "no HDF5")), HasSubstr("not HDF5"));
  std::filesystem::remove(path());
  EXPECT_THAT(refusal(base), HasSubstr("no such file"));
  std::filesystem::create_directory(path());
  EXPECT_THAT(refusal(base), HasSubstr("is no file"));
}

void replace_attribute(hid_t file, const char* name, hid_t type, int rank, hsize_t count) {
  ASSERT_GE(H5Adelete(file, name), 0);
  const hid_t space = rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr);
  const hid_t at = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(at, 0);
  const std::vector<char> zeros(static_cast<std::size_t>(count) * H5Tget_size(type));
  EXPECT_GE(H5Awrite(at, type, zeros.data()), 0);
  H5Aclose(at);
  H5Sclose(space);
}

void replace_set(hid_t file, const char* name, hid_t type, std::vector<hsize_t> size) {
  ASSERT_GE(H5Ldelete(file, name, H5P_DEFAULT), 0);
  const hid_t space = H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
  const hid_t set = H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_GE(set, 0);
  H5Dclose(set);
  H5Sclose(space);
}

template <class Number>
void put_number(hid_t file, const char* name, hid_t type, std::size_t at, Number value) {
  const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
  ASSERT_GE(set, 0);
  std::vector<Number> all(H5Dget_storage_size(set) / sizeof(Number));
  EXPECT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
  all.at(at) = value;
  EXPECT_GE(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
  H5Dclose(set);
}

TEST_F(MpmCheckpoint, ContentsAreCheckedBeforeTheyAreUsed) {
  EXPECT_EQ(refusal_after([](hid_t) {}), "");
  const auto no_number = HasSubstr("'time' is no number");
  EXPECT_THAT(
      refusal_after([](hid_t file) { replace_attribute(file, "time", H5T_IEEE_F64LE, 1, 1000); }),
      no_number);
  EXPECT_THAT(
      refusal_after([](hid_t file) { replace_attribute(file, "time", H5T_IEEE_F32LE, 0, 1); }),
      no_number);
  EXPECT_THAT(refusal_after([](hid_t file) {
                const hid_t text = H5Tcopy(H5T_C_S1);
                H5Tset_size(text, 2000);
                replace_attribute(file, "time", text, 0, 1);
                H5Tclose(text);
              }),
              no_number);
  EXPECT_THAT(refusal_after([](hid_t file) { EXPECT_GE(H5Adelete(file, "steps"), 0); }),
              HasSubstr("has no attribute 'steps'"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal_after([&](hid_t file) { put_number(file, "F", H5T_NATIVE_DOUBLE, 9, nan); }),
              HasSubstr("particle 2: F is not finite"));
  EXPECT_THAT(refusal_after([&](hid_t file) { put_number(file, "F", H5T_NATIVE_DOUBLE, 8, -1.0); }),
              HasSubstr("particle 2: det F is not positive"));
  EXPECT_THAT(refusal_after([&](hid_t file) { put_number(file, "x", H5T_NATIVE_DOUBLE, 3, 7.0); }),
              HasSubstr("particle 1: it is outside of the grid"));
  EXPECT_THAT(
      refusal_after([&](hid_t file) { put_number(file, "mass", H5T_NATIVE_DOUBLE, 3, 7.0); }),
      HasSubstr("particle 3: its mass or volume"));
  for (const int body : {-1, 1, 2147483647, -2147483647 - 1})
    EXPECT_THAT(
        refusal_after([&](hid_t file) { put_number(file, "body", H5T_NATIVE_INT, 5, body); }),
        HasSubstr("particle 5: is of body " + std::to_string(std::int64_t{body} + 1)));
  EXPECT_THAT(refusal_after(
                  [&](hid_t file) { put_number(file, "frame_times", H5T_NATIVE_DOUBLE, 0, 1.0); }),
              HasSubstr("times out of order"));
  EXPECT_THAT(refusal_after([](hid_t file) {
                replace_set(file, "v", H5T_IEEE_F64LE, {15, 2});
              }),
              HasSubstr("'v' is 15 x 2, not 16 x 2"));
  EXPECT_THAT(refusal_after([](hid_t file) {
                replace_set(file, "v", H5T_IEEE_F64LE, {16, 2, 1});
              }),
              HasSubstr("'v' is no table"));
  EXPECT_THAT(refusal_after([](hid_t file) {
                replace_set(file, "v", H5T_IEEE_F32LE, {16, 2});
              }),
              HasSubstr("'v' is of a type that no checkpoint has"));
  EXPECT_THAT(refusal_after([](hid_t file) {
                replace_set(file, "problem", H5T_STD_U8LE, {hsize_t{1} << 50, 1});
              }),
              HasSubstr("'problem' is"));
  EXPECT_THAT(refusal_after([](hid_t file) {
                H5Ldelete(file, "v", H5P_DEFAULT);
                H5Lcreate_external("/etc/hostname", "/v", file, "v", H5P_DEFAULT, H5P_DEFAULT);
              }),
              HasSubstr("has no data set 'v'"));
}

// Reads it as a restart does and makes two steps, in a process of its own. True where that ends in
// an error that says what is wrong, or in steps.
bool survives(const std::filesystem::path& path) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    int code = 0;
    try {
      const ProblemFile<2> file = file_of(base);
      Simulation<2> simulation(file.problem);
      read_checkpoint(path, simulation, file.formulas);
      for (int s = 0; s < 2; ++s) simulation.step(simulation.choose_step().dt);
    } catch (const FileError&) {
    } catch (const Failure&) {
    } catch (...) {
      code = 1;
    }
    _exit(code);
  }
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// Bytes changed, cut out, doubled; each with the seal repaired, so that all else is what answers.
void expect_no_crash(const std::filesystem::path& path, const std::string& whole, int copies) {
  std::mt19937 random(7);
  const auto below = [&](std::size_t bound) { return random() % bound; };
  for (int i = 0; i < copies; ++i) {
    std::string bytes = whole;
    const std::size_t changes = 1 + below(4);
    for (std::size_t c = 0; c < changes; ++c) {
      const std::size_t at = seal_size + below(bytes.size() - seal_size);
      const std::size_t length = std::min<std::size_t>(1 + below(64), bytes.size() - at);
      switch (below(6)) {
        case 0:
          bytes.erase(at, length);
          break;
        case 1:
          bytes.insert(at, bytes.substr(at, length));
          break;
        case 2:
          bytes.replace(at, length, length, below(2) ? '\0' : '\xff');
          break;
        default:
          bytes[at] = static_cast<char>(below(256));
      }
    }
    std::ofstream(path, std::ios::binary) << sealed(bytes);
    if (survives(path)) continue;
    ADD_FAILURE() << "copy " << i;
  }
}

TEST_F(MpmCheckpoint, ChangedCopiesDoNotCrash) {
  EXPECT_TRUE(survives(path()));
  expect_no_crash(path(), whole_, 60);
}

TEST_F(MpmCheckpoint, SlowManyChangedCopiesDoNotCrash) {
  expect_no_crash(path(), whole_, 500);
}

// To be run in a process of its own, which may write files up to a size. Ends it with 7 where
// writing is answered with the right error.
[[noreturn]] void write_with_limit(const std::filesystem::path& path, rlim_t limit) {
  signal(SIGXFSZ, SIG_IGN);
  const rlimit size{limit, limit};
  setrlimit(RLIMIT_FSIZE, &size);
  const ProblemFile<2> file = file_of(base);
  Simulation<2> simulation(file.problem);
  try {
    write_checkpoint(path, simulation, file.formulas, {});
  } catch (const FileError& error) {
    std::exit(std::string(error.what()).find("File too large") != std::string::npos ? 7 : 8);
  }
  std::exit(0);
}

// An error, the old checkpoint whole, nothing left beside it, and an orderly end of
// the HDF5 library.
TEST_F(MpmCheckpoint, AFullDiskLeavesTheOldOne) {
  for (const rlim_t limit : {rlim_t{100}, rlim_t{1500}, rlim_t{3000}, rlim_t{5000}}) {
    EXPECT_EXIT(write_with_limit(path(), limit), testing::ExitedWithCode(7), "") << limit;
    EXPECT_TRUE(contents(path()) == whole_);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_),
                            std::filesystem::directory_iterator()),
              1);
  }
  EXPECT_EXIT(write_with_limit(path(), 100000), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace recon::mpm::test
