// `mpirun recon-mpm run` from end to end: what it leaves is what a run without ranks leaves, and
// whatever goes wrong ends all ranks with one message.
#include <map>
#include <numeric>
#include <set>

#include "on_ranks/mpirun.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A block that hangs from a plate which swings, pulled at its foot, and a disk that flies past it,
// through boxes of several ranks. Steps of one length: runs in pieces have those of a whole one.
constexpr const char* hanging = R"TOML(
[grid]
lower = [0.0, 0.0]
upper = [2.0, 2.0]
cells = 10
[material]
kind = "neo_hookean"
young = 1000
poisson = 0.3
density = 10
[[body]]
shape = "box"
lower = [0.5, 1.2]
upper = [1.3, 2.0]
[[body]]
shape = "disk"
centre = [0.4, 0.5]
radius = 0.22
particles = 3
velocity = [9, 1]
[[boundary]]
axis = "y"
at = 2
kind = "velocity"
velocity = ["0.1 * sin(20 * t)", 0]
[[traction]]
body = 1
side = "y_lower"
traction = ["30 * t", "-20 * t"]
[loads]
gravity = [0, -10]
[method]
name = "cpdi1"
[time]
end = 0.12
rule = "fixed"
step = 0.001
[[probe]]
kind = "reaction"
name = "plate"
boundary = 1
[[probe]]
kind = "section"
name = "neck"
axis = "y"
at = 1.7
[[probe]]
kind = "particle"
name = "flier"
at = [0.45, 0.45]
fields = ["velocity", "displacement"]
[[probe]]
kind = "particle"
name = "foot"
at = [0.9, 1.25]
fields = ["displacement", "stress", "id"]
[[probe]]
kind = "point"
name = "middle"
at = [0.9, 1.6]
radius = 0.25
fields = ["velocity", "pressure"]
[output]
frames = 3
)TOML";

// A body at rest, for as long as one likes.
constexpr const char* still = R"TOML(
[grid]
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = 4
[material]
young = 1000
poisson = 0.3
density = 1000
[[body]]
shape = "box"
lower = [0.25, 0.25]
upper = [0.75, 0.75]
[method]
name = "mpm"
[time]
end = 1
[output]
frames = 1
)TOML";

class OnRanks : public OnRanksTest {
 protected:
  OnRanks() : OnRanksTest("recon-mpm", RECON_MPM_PROGRAM) {
    write("hanging.toml", hanging);
    write("still.toml", still);
  }

  std::string succeed_on(int ranks, const std::string& arguments) const {
    const Outcome outcome = on(ranks, arguments);
    EXPECT_EQ(outcome.code, 0) << ranks << " ranks: " << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.err, "") << ranks << " ranks: " << arguments;
    return outcome.out;
  }
  // What the program says, and not mpirun: once.
  static std::string said(const Outcome& outcome) {
    const std::string name = "recon-mpm: ";
    const std::size_t at = outcome.err.find(name);
    EXPECT_NE(at, std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find(name, at + 1), std::string::npos) << outcome.err;
    return outcome.err.substr(std::min(at, outcome.err.size()));
  }
  void expect_failure_on(int ranks, const std::string& arguments, int code,
                         const testing::Matcher<const std::string&>& message) const {
    const std::vector<std::string> before = files();
    const Outcome outcome = on(ranks, arguments);
    EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.err;
    EXPECT_THAT(said(outcome), message) << arguments;
    EXPECT_EQ(files(), before) << arguments;
  }

  void copy_example(const std::string& name) const {
    std::filesystem::copy(std::string(RECON_SOURCE_DIR) + "/examples/mpm/" + name + ".toml",
                          folder());
  }
  // The rows of a table in the order of its ids, if it has any: pieces of frames have another one.
  static std::vector<std::size_t> in_order(const ParticleTable& of) {
    std::vector<std::size_t> rows(of.size());
    std::iota(rows.begin(), rows.end(), std::size_t{0});
    if (of.has("id"))
      std::sort(rows.begin(), rows.end(),
                [ids = of.column("id")](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
    return rows;
  }
  // A frame has every particle once.
  void expect_all_ids(const std::string& frame, std::size_t count) const {
    const ParticleTable seen = table(frame);
    std::vector<double> ids, wanted(count);
    std::iota(wanted.begin(), wanted.end(), 0.0);
    for (const std::size_t row : in_order(seen)) ids.push_back(seen.column("id")[row]);
    EXPECT_EQ(ids, wanted) << frame;
  }

  // Two tables have the same columns, each to 1e-12 of the largest number in it, in the others that
  // have its name up to the axes, and of `scales` for those that begin so.
  void expect_same(const std::string& one, const std::string& other,
                   const std::map<std::string, double>& scales = {}) const {
    const ParticleTable a = table(one), b = table(other);
    ASSERT_EQ(a.names(), b.names()) << other;
    ASSERT_EQ(a.size(), b.size()) << other;
    ASSERT_GT(a.size(), 0u);
    static const std::regex axes("_[xyz]+$");
    std::map<std::string, double> largest;
    for (const std::string& name : a.names()) {
      double& most = largest[std::regex_replace(name, axes, "")];
      for (const double value : a.column(name))
        if (std::isfinite(value)) most = std::max(most, std::abs(value));
      for (const auto& [begin, scale] : scales)
        if (name.rfind(begin, 0) == 0) most = std::max(most, scale);
    }
    const std::vector<std::size_t> rows = in_order(a), rows_of_other = in_order(b);
    for (const std::string& name : a.names()) {
      const double most = largest[std::regex_replace(name, axes, "")];
      double off = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        const double x = a.column(name)[rows[i]], y = b.column(name)[rows_of_other[i]];
        ASSERT_EQ(std::isfinite(x), std::isfinite(y)) << other << ": " << name;
        if (std::isfinite(x)) off = std::max(off, std::abs(x - y));
      }
      EXPECT_LE(off, 1e-12 * most) << other << ": " << name << ", of " << most;
    }
  }
  // Ledgers: momenta to that of all energy, and energies to the largest one.
  void expect_same_ledger(const std::string& one, const std::string& other) const {
    const ParticleTable ledger = table(one);
    double energy = 0;
    for (const char* name : {"kinetic", "strain"})
      for (const double value : ledger.column(name)) energy = std::max(energy, value);
    const double momentum = std::sqrt(2 * ledger.column("mass")[0] * energy);
    expect_same(one, other,
                {{"momentum", momentum},
                 {"node_momentum", momentum},
                 {"angular", momentum},
                 {"node_angular", momentum},
                 {"strain", energy},
                 {"linear_strain", energy},
                 {"interpolation", energy},
                 {"algorithmic", energy},
                 {"work", energy},
                 {"balance", energy}});
  }
};

using OnRanksSlow = OnRanks;

TEST_F(OnRanks, LeavesTheFilesOfOneProcess) {
  succeed("run hanging.toml --quiet --out one");
  for (const int ranks : {1, 2, 3, 4}) {
    const std::string out = "on" + std::to_string(ranks);
    const std::string summary = succeed_on(ranks, "run hanging.toml --quiet --out " + out);
    const std::string line = "\nranks          " + std::to_string(ranks) + ", with ";
    EXPECT_EQ(summary.find(line) != std::string::npos, ranks > 1) << summary;
    std::set<std::string> names[2];
    for (const auto& each : {std::pair("one", 0), std::pair(out.c_str(), 1)})
      for (const auto& file : std::filesystem::directory_iterator(folder() / each.first))
        names[each.second].insert(file.path().filename().string());
    if (ranks == 1) {  // to the bit
      EXPECT_EQ(names[0], names[1]);
      for (const std::string& name : names[0])
        EXPECT_TRUE(read("one/" + name) == read(out + "/" + name)) << name;
      continue;
    }
    // Frames in pieces are there in the place of those in one.
    std::set<std::string> wanted;
    for (const std::string& name : names[0]) {
      const bool frame = name.ends_with(".vtp") || name.ends_with(".vti");
      wanted.insert(frame ? std::regex_replace(name, std::regex("[.]vt"), ".pvt") : name);
      for (int r = 0; r < ranks && frame; ++r)
        wanted.insert(
            std::regex_replace(name, std::regex("[.]vt"), "_" + std::to_string(r) + ".vt"));
    }
    // A rank without particles has no piece of them.
    std::erase_if(wanted, [&](const std::string& name) {
      return std::regex_search(name, std::regex("particles_[0-9]+_[0-9]+[.]vtp$")) &&
             !names[1].contains(name);
    });
    EXPECT_EQ(names[1], wanted);
    expect_same_ledger("one/ledger.csv", out + "/ledger.csv");
    expect_same("one/probes.csv", out + "/probes.csv");
    for (int frame = 0; frame < 4; ++frame) {
      const std::string name = "/hanging_particles_000" + std::to_string(frame);
      expect_same("one" + name + ".vtp", out + name + ".pvtp");
      expect_all_ids(out + name + ".pvtp", 396);
    }
  }
}

TEST_F(OnRanks, VibratesAsOneProcess) {
  copy_example("vibration_2d");
  const std::string command = "run vibration_2d.toml --cells 8 --set frames=2 --quiet --out ";
  succeed(command + "one");
  succeed_on(4, command + "on4");
  expect_same_ledger("one/ledger.csv", "on4/ledger.csv");
  for (const char* frame : {"0001", "0002"}) {
    const std::string name = std::string("/vibration_2d_particles_") + frame;
    expect_same("one" + name + ".vtp", "on4" + name + ".pvtp");
  }
}

// No particle is lost or there twice after 10,000 steps in which they go round.
TEST_F(OnRanksSlow, AVortexKeepsItsParticles) {
  copy_example("vortex");
  succeed_on(4,
             "run vortex.toml --set rule=fixed --set time.step=1e-4 --set frames=4 --quiet "
             "--out out");
  const ParticleTable ledger = table("out/ledger.csv");
  ASSERT_EQ(ledger.size(), 10001u);
  const auto mass = ledger.column("mass");
  for (const double each : mass) ASSERT_NEAR(each, mass[0], 1e-12 * mass[0]);
  for (int frame = 0; frame < 5; ++frame)
    expect_all_ids("out/vortex_particles_000" + std::to_string(frame) + ".pvtp", 720);
}

TEST_F(OnRanks, IsAtRestWhenOneProcessIs) {
  copy_example("column_rest");
  const std::string command = "run column_rest.toml --quiet --out ";
  EXPECT_THAT(succeed(command + "one"), HasSubstr("rest           reached"));
  EXPECT_THAT(succeed_on(3, command + "on3"), HasSubstr("rest           reached"));
  EXPECT_EQ(table("one/ledger.csv").size(), table("on3/ledger.csv").size());
}

// Two ranks, then three, then one process: the run that nothing has stopped.
TEST_F(OnRanks, GoesOnWithAnyNumberOfRanks) {
  const std::string command = "run hanging.toml --quiet";
  succeed(command + " --out whole");
  const std::string end = " --set frames=0 --set end=";
  succeed_on(2, command + " --out parts" + end + "0.04");
  succeed_on(3, command + " --out parts --restart parts/checkpoint.h5" + end + "0.08");
  succeed(command + " --out parts --restart parts/checkpoint.h5" + end + "0.12");
  expect_same_ledger("whole/ledger.csv", "parts/ledger.csv");
  expect_same("whole/probes.csv", "parts/probes.csv");

  // A checkpoint of one process on two ranks.
  succeed(command + " --out serial" + end + "0.04");
  succeed_on(2, command + " --out serial --restart serial/checkpoint.h5" + end + "0.12");
  expect_same_ledger("whole/ledger.csv", "serial/ledger.csv");

  // Frames before a restart may have another form than those after it; lists have all.
  const std::string half = " --set end=0.08", frames = " --set frames=4";
  const auto listed = [&](const std::string& list) {
    std::vector<std::string> found;
    const std::string text = read(list);
    static const std::regex file("file=\"([^\"]*)\"");
    for (std::sregex_iterator at(text.begin(), text.end(), file), last; at != last; ++at) {
      found.push_back((*at)[1]);
      EXPECT_TRUE(std::filesystem::exists(folder() / "forms" / found.back())) << found.back();
    }
    return found;
  };
  const auto forms = [&](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += name.ends_with(".pvtp") ? 'p' : 'v';
    return text;
  };
  const std::string list = "forms/hanging_particles.pvd";
  succeed_on(2, command + " --out forms" + frames + half);
  EXPECT_EQ(forms(listed(list)), "ppppp");
  succeed(command + " --out forms --restart forms/checkpoint.h5 --set frames=6 --set end=0.12");
  EXPECT_EQ(forms(listed(list)), "pppppvv");
  // And a run in the place of another leaves none of its frames behind in the other form.
  succeed(command + " --out forms --overwrite" + frames + half);
  EXPECT_EQ(forms(listed(list)), "vvvvv");
  EXPECT_FALSE(std::filesystem::exists(folder() / "forms/hanging_particles_0003.pvtp"));
}

// Neither the pieces of more ranks nor later frames.
TEST_F(OnRanks, NothingOfTheRunBeforeIsLeft) {
  const auto left = [&](const std::string& of_another) {
    std::string names;
    for (const auto& entry : std::filesystem::directory_iterator(folder() / "out")) {
      const std::string name = entry.path().filename().string();
      if (std::regex_search(name, std::regex(of_another))) names += " " + name;
    }
    return names;
  };
  const std::string command = "run hanging.toml --quiet --out out", end = " --set end=";
  succeed_on(4, command + end + "0.12 --set frames=6");
  EXPECT_THAT(left("_0005_3[.]"), HasSubstr("hanging_nodes_0005_3.vti"));
  succeed_on(2, command + end + "0.04 --set frames=2 --overwrite");
  EXPECT_EQ(left("_[0-9]{4}_[23][.]|_000[3-9]"), "");
  // What a checkpoint does not know of is of a run that went on from it: as if that had been killed.
  const std::string checkpoint = read("out/checkpoint.h5");
  succeed_on(3, command + end + "0.12 --set frames=6 --restart out/checkpoint.h5");
  EXPECT_NE(left("_0006_2[.]"), "");
  write("out/checkpoint.h5", checkpoint);
  succeed(command + end + "0.08 --set frames=4 --restart out/checkpoint.h5");
  EXPECT_EQ(left("_000[3-9]_|_000[5-9]"), "");
  EXPECT_NE(left("_0002_1[.]"), "") << "frames before the restart stay";
}

// A particle that leaves the grid on one rank.
TEST_F(OnRanks, AFailureOfOneEndsAll) {
  const std::string command = "run hanging.toml --quiet --out out --set end=1 --set frames=50";
  const Outcome outcome = on(3, command);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(said(outcome), AllOf(HasSubstr("particle "), HasSubstr(": rank "),
                                   HasSubstr("out/checkpoint.h5 holds its state at time ")));
  const ParticleTable ledger = table("out/ledger.csv");
  EXPECT_GT(ledger.size(), 10u);
  const std::string before = read("out/checkpoint.h5");
  const Outcome one = run(command + " --overwrite");
  EXPECT_EQ(one.code, 4);
  // The same particle, at the same step.
  static const std::regex place("step [0-9]+, particle [0-9]+");
  std::smatch here, there;
  ASSERT_TRUE(std::regex_search(outcome.err, here, place)) << outcome.err;
  ASSERT_TRUE(std::regex_search(one.err, there, place)) << one.err;
  EXPECT_EQ(here.str(), there.str());
  // What was saved goes on.
  write("saved.h5", before);
  succeed_on(2, "run hanging.toml --quiet --out more --restart saved.h5 --set end=" +
                    std::to_string(ledger.column("time").back() - 0.01));
}

// What is there stays whole. (Shared memory would be a file that is too large as well.)
TEST_F(OnRanks, AFullDiskIsAnError) {
  const std::string command =
      "run still.toml --cells 16 --quiet --out out --set frames=0 --set ledger=false --set end=";
  succeed_on(2, command + "0.1");
  const std::string before = read("out/checkpoint.h5");
  const Outcome full = shell("OMPI_MCA_btl=self,tcp; export OMPI_MCA_btl; " +
                             std::regex_replace(mpirun(2), std::regex("OMPI_MCA_btl=[^ ]*"), "") +
                             "sh -c \"ulimit -f 20; exec '" + program() + "' " + command +
                             "0.2 --restart out/checkpoint.h5\"");
  EXPECT_EQ(full.code, 3);
  EXPECT_THAT(said(full), HasSubstr("checkpoint.h5: cannot write"));
  EXPECT_TRUE(read("out/checkpoint.h5") == before);
  succeed_on(2, command + "0.2 --restart out/checkpoint.h5");
}

// A signal to mpirun saves the run, and what it says goes on with it.
TEST_F(OnRanks, ASignalSavesTheRun) {
  const std::string command = "run still.toml --quiet --out out";
  for (const char* name : {"USR1", "TERM"}) {
    std::filesystem::remove_all(folder() / "out");
    std::string start = mpirun(2);
    start.erase(0, start.find("env"));
    const Outcome stopped =
        shell(start + "'" + program() + "' " + command +
              " --set end=1e7 & p=$!; while kill -0 $p && ! test -e out/checkpoint.h5; "
              "do sleep 0.05; done; sleep 0.2; kill -" +
              name + " $p; wait $p");
    EXPECT_NE(stopped.code, 0);
    if (name == std::string("USR1")) {
      EXPECT_EQ(stopped.code, 138);
    }
    EXPECT_THAT(said(stopped), AllOf(HasSubstr("stopped at time "), HasSubstr(", step "),
                                     HasSubstr("--restart out/checkpoint.h5")));
    const double time = table("out/ledger.csv").column("time").back();
    EXPECT_GT(time, 0);
    succeed_on(2,
               command + " --restart out/checkpoint.h5 --set end=" + std::to_string(time * 1.01));
  }
}

TEST_F(OnRanks, MistakesAreSaidOnce) {
  expect_failure_on(2, "run hanging.toml --metod cpls", 1, HasSubstr("--method"));
  write("bad.h5", "not a checkpoint");
  expect_failure_on(2, "run hanging.toml --restart bad.h5", 2, HasSubstr("bad.h5: "));
  expect_failure_on(2, "run still.toml --method mpm+mass=consistent", 2,
                    HasSubstr("must be lumped in a state of several parts"));
  EXPECT_THAT(on(2, "compare hanging.toml").err,
              HasSubstr("compare is for one process, and 2 were started; only recon-mpm run is "
                        "spread over the ranks"));
  ASSERT_EQ(shell("mkfifo pipe.toml").code, 0);
  expect_failure_on(2, "run pipe.toml", 2, HasSubstr("pipe.toml: is no ordinary file"));
  expect_failure_on(3, "rnu hanging.toml", 1, HasSubstr("did you mean 'run'?"));
  const std::string help = on(2, "help run").out, usage = "Usage: ";
  EXPECT_NE(help.find(usage), std::string::npos);
  EXPECT_EQ(help.find(usage), help.rfind(usage));

  // Another run's folder, and another problem's checkpoint.
  succeed_on(2, "run hanging.toml --quiet --set end=0.01 --out out");
  expect_failure_on(2, "run hanging.toml --out out", 3, HasSubstr("another run"));
  expect_failure_on(2, "run hanging.toml --set cells=12 --restart out/checkpoint.h5", 2,
                    HasSubstr("checkpoint of another problem"));
}

// Each rank has a command or a file of its own.
using RanksThatDiffer = OnRanks;

TEST_F(RanksThatDiffer, NoneWaitsForOneWithAnotherCommand) {
  const std::string right = "run still.toml --quiet --out out";
  const auto expect = [&](const std::string& first, const std::string& second,
                          const testing::Matcher<const std::string&>& message) {
    const std::string quoted = "'" + program() + "' ";
    const Outcome outcome = each(quoted + first, quoted + second);
    EXPECT_EQ(outcome.code, 1) << first << ", " << second << "\n" << outcome.err;
    EXPECT_THAT(said(outcome), message) << first << ", " << second;
    EXPECT_FALSE(exists("out")) << first << ", " << second;
  };
  expect(right + " --bogus", right, HasSubstr("rank 0: unknown option '--bogus'"));
  expect(right, right + " --bogus", HasSubstr("rank 1: unknown option '--bogus'"));
  expect(right, "rnu still.toml", HasSubstr("rank 1: unknown command 'rnu'; did you mean 'run'?"));
  expect(right, "methods", HasSubstr("rank 1: methods is for one process"));
  expect(right, "--version",
         HasSubstr("rank 1: the command is 'recon-mpm --version', and that of "
                   "the first rank is 'recon-mpm run still.toml"));
  expect(right, "run still.toml --quiet --out other", HasSubstr(" --out other', and that of"));
}

// Ranks that do not see the same file.
TEST_F(RanksThatDiffer, WhatOneRankReadsIsWhatAllRead) {
  std::filesystem::create_directory(folder() / "0");
  std::filesystem::create_directory(folder() / "1");
  write("0/p.toml", hanging);
  const std::string run_own = "run p.toml --out ../out";
  const Outcome missing = each_in_its_folder(run_own);
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(said(missing), AllOf(HasSubstr("rank 1: "), HasSubstr("p.toml: no such file")));
  write("1/p.toml", std::regex_replace(std::string(hanging), std::regex("30 \\* t"), "31 * t"));
  const Outcome differs = each_in_its_folder(run_own);
  EXPECT_EQ(differs.code, 2);
  EXPECT_THAT(said(differs), HasSubstr("different on some ranks"));
  EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace recon::test
