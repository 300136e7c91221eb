// recon-mpm from end to end.
#ifdef RECON_MPM_PROGRAM

#include <signal.h>

#include <regex>

#include "programs/run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class MpmProgram : public ProgramTest {
 protected:
  MpmProgram() : ProgramTest("recon-mpm", RECON_MPM_PROGRAM) {
    std::filesystem::copy(std::string(RECON_SOURCE_DIR) + "/examples/mpm", folder());
  }
};

TEST_F(MpmProgram, MethodsAreListed) {
  const std::string table = succeed("methods");
  for (const char* name :
       {"mpm", "ugimp", "cpgimp", "cpdi1", "cpdi2", "impm", "improved_cpdi", "imls_mpm", "cpls"})
    EXPECT_THAT(table, HasSubstr(std::string("\n") + name + " "));
}

TEST_F(MpmProgram, ARunLeavesItsFiles) {
  const std::string summary =
      succeed("run disks.toml --cells 10 --set end=0.3 --set frames=3 --quiet --out out");
  EXPECT_THAT(summary, AllOf(HasSubstr("cpls, 2-D"), HasSubstr("momentum"), HasSubstr("energy"),
                             HasSubstr("4 frames")));
  for (const char* name : {"ledger.csv", "checkpoint.h5", "disks_particles.pvd",
                           "disks_particles_0003.vtp", "disks_nodes_0003.vti"})
    EXPECT_TRUE(exists(std::string("out/") + name)) << name;
  EXPECT_EQ(exists("out/energy.png"), has_gnuplot());
  const ParticleTable ledger = table("out/ledger.csv");
  EXPECT_NEAR(ledger.column("time").back(), 0.3, 1e-12);
  EXPECT_THAT(read("out/disks_particles.pvd"), HasSubstr("disks_particles_0002.vtp"));

  // Another run in the same place is refused; going on from the end changes nothing.
  EXPECT_THAT(run("run disks.toml --cells 10 --set end=0.3 --out out").err,
              AllOf(HasSubstr("another run"), HasSubstr("--restart out/checkpoint.h5"),
                    HasSubstr("--overwrite"), HasSubstr("--out")));
  const std::string before = read("out/ledger.csv");
  succeed(
      "run disks.toml --cells 10 --set end=0.3 --set frames=3 --quiet --out out "
      "--restart out/checkpoint.h5");
  EXPECT_EQ(read("out/ledger.csv"), before);
}

// And the advice can be followed: too long a step in the first run, half of it in the second.
TEST_F(MpmProgram, AFailureIsExplained) {
  const std::string command =
      "run disks.toml --method cpdi1 --cells 10 --set frames=4 --quiet --out out --set courant=1.4";
  const Outcome outcome = run(command);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("step "), HasSubstr("particle "),
                                 HasSubstr("out/checkpoint.h5 holds its state at time ")));
  EXPECT_TRUE(exists("out/checkpoint.h5"));
  const std::string restart = " --restart out/checkpoint.h5", shorter = " --set time.courant=0.7";
  EXPECT_THAT(outcome.err, HasSubstr("the same command with" + restart + " and" + shorter + "."));
  EXPECT_THAT(outcome.err, HasSubstr("with --overwrite or another --out"));
  EXPECT_EQ(run(command + restart + shorter).code, 0);
  EXPECT_EQ(run(command + shorter + " --overwrite").code, 0);

  const Outcome fixed =
      run("run wall.toml --method mpm --cells 10 --set 'velocity=[1,0.5]' --quiet --out fixed "
          "--set rule=fixed --set time.step=0.01");
  EXPECT_EQ(fixed.code, 4);
  EXPECT_THAT(fixed.err, HasSubstr("--set time.step=0.005"));
}

const std::string still =
    "[grid]\nlower = [0.0, 0.0]\nupper = [1.0, 1.0]\ncells = 4\n[material]\nyoung = 1000\n"
    "poisson = 0.3\ndensity = 1000\n[[body]]\nshape = \"box\"\nlower = [0.25, 0.25]\n"
    "upper = [0.75, 0.75]\n[method]\nname = \"mpm\"\n[time]\nend = 1\n[output]\nframes = 1\n";

// Ctrl-C saves the run, and what it says goes on with it.
TEST_F(MpmProgram, ASignalSavesTheRun) {
  write("still.toml", still);
  const std::string command = "run still.toml --quiet --out 'o u t'";
  for (const auto& [name, number] : {std::pair("INT", SIGINT), std::pair("TERM", SIGTERM)}) {
    std::filesystem::remove_all(folder() / "o u t");
    const Outcome stopped =
        shell("env --default-signal '" + program() + "' " + command +
              " --set end=1e7 & p=$!; while kill -0 $p && ! test -e 'o u t/checkpoint.h5'; "
              "do sleep 0.05; done; sleep 0.2; kill -" +
              name + " $p; wait $p");
    EXPECT_EQ(stopped.code, 128 + number) << stopped.err;
    EXPECT_THAT(stopped.err,
                AllOf(HasSubstr("stopped at time "), HasSubstr(", step "),
                      HasSubstr("the same command with --restart 'o u t/checkpoint.h5'")));
    for (const std::string& each : files()) EXPECT_THAT(each, Not(HasSubstr(".part")));
    const ParticleTable ledger = table("o u t/ledger.csv");
    const double time = ledger.column("time").back();
    EXPECT_GT(time, 0);
    succeed(command + " --set end=" + std::to_string(time * 1.01) +
            " --restart 'o u t/checkpoint.h5'");
    EXPECT_GE(table("o u t/ledger.csv").size(), ledger.size());
  }
}

// What is there stays whole.
TEST_F(MpmProgram, AFullDiskIsAnError) {
  const std::string command =
      "run disks.toml --cells 10 --quiet --out out --set frames=0 --set ledger=false --set end=";
  succeed(command + "0.1");
  const std::string before = read("out/checkpoint.h5");
  const Outcome full = shell("ulimit -f 20; exec '" + program() + "' " + command +
                             "0.2 --restart out/checkpoint.h5");
  EXPECT_EQ(full.code, 3);
  EXPECT_THAT(full.err, HasSubstr("checkpoint.h5: cannot write"));
  EXPECT_EQ(read("out/checkpoint.h5"), before);
  succeed(command + "0.2 --restart out/checkpoint.h5");
}

TEST_F(MpmProgram, ListsOfFramesAreXml) {
  std::filesystem::copy(folder() / "disks.toml", folder() / "a&b<\"c.toml");
  succeed("run 'a&b<\"c.toml' --cells 10 --set end=0.01 --set frames=1 --quiet --out out");
  EXPECT_TRUE(exists("out/a&b<\"c_particles_0001.vtp"));
  EXPECT_THAT(read("out/a&b<\"c_particles.pvd"),
              HasSubstr("file=\"a&amp;b&lt;&quot;c_particles_0001.vtp\""));
}

// While the problem is still read, of a pipe that gives it once the signal is there.
TEST_F(MpmProgram, ASignalBeforeTheRunIsNotLost) {
  const Outcome stopped =
      shell("mkfifo still.toml; '" + program() +
            "' run still.toml --quiet --out out & p=$!; exec 3> still.toml; kill -USR1 $p; "
            "echo '" +
            still + "' >&3; exec 3>&-; wait $p");
  EXPECT_EQ(stopped.code, 128 + SIGUSR1);
  EXPECT_EQ(stopped.err, "recon-mpm: stopped before the run has begun; nothing was written\n");
  EXPECT_FALSE(exists("out"));
}

// timeout tells a process and then its group.
TEST_F(MpmProgram, ASignalThatComesTwiceAtOnceIsOne) {
  write("still.toml", still);
  const Outcome stopped = shell(
      "'" + program() +
      "' run still.toml --quiet --out out --set end=1e7 & p=$!; while kill -0 $p && ! test -e "
      "out/checkpoint.h5; do sleep 0.05; done; kill -USR1 $p; kill -USR1 $p; wait $p");
  EXPECT_EQ(stopped.code, 128 + SIGUSR1);
  EXPECT_THAT(stopped.err, HasSubstr("--restart out/checkpoint.h5"));
}

// Several copies that cannot be ranks of one run, as the program knows no ranks or another MPI has
// started them, would write the same files: one of them says so.
TEST_F(MpmProgram, CopiesThatAreNoRanksAreRefused) {
  for (const auto& [command, said] :
       {std::pair("run disks.toml --out out", "4 copies were started"),
        std::pair("compare disks.toml", "only recon-mpm run is spread over the ranks")}) {
    const std::string rest = " '" + program() + "' " + command;
    const Outcome first = shell("exec env PMI_SIZE=4 PMI_RANK=0" + rest);
    EXPECT_EQ(first.code, 1);
    EXPECT_THAT(first.err, AllOf(StartsWith("recon-mpm: "), HasSubstr(said)));
    const Outcome other = shell("exec env PMI_SIZE=4 PMI_RANK=2" + rest);
    EXPECT_EQ(other.code, 1);
    // What is no work for ranks is said by all that mpirun leaves the time to.
    if (said[0] == '4')
      EXPECT_EQ(other.err + other.out, "");
    else
      EXPECT_THAT(other.err, StartsWith("recon-mpm: rank 2: "));
  }
  EXPECT_FALSE(exists("out"));
}

TEST_F(MpmProgram, AGpuThatCannotBeIsRefused) {
  for (const char* asked : {"--device gpu", "--set device=gpu"}) {
#ifdef RECON_HAS_GPU
    const Outcome outcome = run(std::string("run disks.toml --method cpls --out out ") + asked);
    EXPECT_EQ(outcome.code, 2);  // no GPU, or none of its forms
    EXPECT_THAT(outcome.err, HasSubstr("GPU"));
#else
    expect_failure(std::string("run disks.toml --method mpm --out out ") + asked, 1,
                   HasSubstr("RECON_CUDA"));
#endif
    EXPECT_FALSE(exists("out"));
  }
  expect_failure("run disks.toml --device tpu", 1, HasSubstr("--device"));
  expect_failure("run disks.toml --set device=tpu", 2, HasSubstr("device"));
  EXPECT_THAT(succeed("run disks.toml --device cpu --method mpm --cells 10 --set end=0.1 "
                      "--set frames=1 --quiet --out cpu"),
              HasSubstr("2 frames"));
}

TEST_F(MpmProgram, Mistakes) {
  expect_failure("run disks.toml --method cplss", 1, HasSubstr("did you mean 'cpls'"));
  expect_failure("run disks.toml --method cpls+velocty=mls", 1,
                 HasSubstr("did you mean 'velocity'"));
  expect_failure("run disks.toml --method cpdi1+polynomial", 2,
                 AllOf(HasSubstr("method.name"), HasSubstr("domain is cpdi1")));
  expect_failure("run disks.toml --metod cpls", 1, HasSubstr("--method"));
  expect_failure("run disk.toml", 2, HasSubstr("no such file"));
  expect_failure("run disks.toml --set cels=3", 2, HasSubstr("grid.cells"));
  expect_failure("run disks.toml --cells 0", 1, HasSubstr("above 0"));
  expect_failure("run disks.toml --restart none.h5", 2, HasSubstr("no such file"));
  expect_failure("disks.toml", 1, HasSubstr("recon-mpm run disks.toml"));
  expect_failure("converge disks.toml --quiet", 2, HasSubstr("no exact solution"));
  expect_failure("converge vibration_1d.toml --times 2T", 1, HasSubstr("none beyond T"));
  expect_failure("converge vibration_1d.toml --methods mpm,ipm", 1, HasSubstr("impm"));
  expect_failure("converge vibration_1d.toml --out none/a.csv", 3, HasSubstr("none"));
  write("bad.toml", "[grid]\nlower = [0.0]\nupper = [1.0]\ncells = 8\nclls = 9\n");
  expect_failure("run bad.toml", 2, HasSubstr("bad.toml:5: grid.clls: unknown key"));
}

TEST_F(MpmProgram, ConvergeWritesATable) {
  const std::string text = succeed(
      "converge vibration_1d.toml --methods mpm,cpls --cells 16,8,32 --times 'T/4,3T/8,T' --out "
      "c.csv --quiet");
  EXPECT_THAT(text, AllOf(HasSubstr("displacement"), HasSubstr("time 0.0075")));
  EXPECT_EQ(first_line("c.csv"), "method,cells,h,time,field,norm,error,order,failure");
  const ParticleTable rows = table("c.csv");
  EXPECT_EQ(rows.size(), 2u * 3 * 3 * 5 * 2);
  EXPECT_THAT(read("c.csv"), HasSubstr("cpls,32,0.03125,0.02"));
}

TEST_F(MpmProgram, CompareShowsAllMethods) {
  const std::string shown = succeed(
      "compare vibration_1d.toml --cells 4,8 --methods mpm,cpls,q8 --no-stability --quiet --out "
      "a.csv");
  EXPECT_THAT(shown, AllOf(HasSubstr("\ncpls "), HasSubstr("refused: "),
                           HasSubstr("needs a problem in 2-D")));
  const std::string csv = read("a.csv");
  EXPECT_THAT(csv, AllOf(HasSubstr("method,courant,displacement error,order"), HasSubstr("\ncpls,"),
                         HasSubstr("refused")));
  expect_failure("compare vibration_1d.toml --methods cpl", 1, HasSubstr("cpls"));
  expect_failure("compare vibration_1d.toml --cells no", 1, HasSubstr("--cells"));
  expect_failure("compare vibration_1d.toml --courant 0.4,0", 1, HasSubstr("--courant: '0'"));
  expect_failure("compare cantilever.toml --courant 0.4", 1, HasSubstr("time.rule=bar_wave"));
  expect_failure("compare vibration_1d.toml --against luck", 1, HasSubstr("angular"));
  expect_failure("compare nothing.toml", 2, HasSubstr("no such file"));
  expect_failure("compare vibration_1d.toml --picture a.gif", 1, HasSubstr(".png"));
}

// A table goes on where it was cut off: rows that are there are not made again, and those of another
// comparison are no rows of this one.
TEST_F(MpmProgram, CompareGoesOn) {
  const std::string study =
      "compare vibration_1d.toml --cells 4 --courant 0.4,0.2 --no-stability --quiet --out a.csv ";
  succeed(study + "--methods mpm,q8");
  const std::string before = read("a.csv");
  const std::string marked =
      std::regex_replace(before, std::regex("\nmpm,0\\.4,[^,]*"), "\nmpm,0.4,0.125");
  ASSERT_NE(before, marked);
  write("a.csv", marked);
  succeed(study + "--methods cpls --resume");  // what stood there stays
  EXPECT_THAT(read("a.csv"), AllOf(HasSubstr("\ncpls,0.4,"), HasSubstr("\nmpm,0.4,0.125,"),
                                   HasSubstr("refused: ")));
  const std::string shown = succeed(study + "--methods mpm,cpls,q8 --resume");
  EXPECT_THAT(shown, AllOf(HasSubstr("1.25e-01"), HasSubstr("\ncpls "), HasSubstr("refused: ")));
  EXPECT_THAT(read("a.csv"), StartsWith(marked.substr(0, marked.find("\nq8"))));
  succeed(study + "--methods mpm,q8");  // anew
  EXPECT_THAT(read("a.csv"), Not(HasSubstr("0.125")));
  for (const char* other : {"--set end=0.01", "--cells 8", "--courant 0.4", "--threads 1"}) {
    std::string changed = study;
    const std::string option = std::string(other).substr(0, std::string(other).find(' '));
    changed = std::regex_replace(changed, std::regex(option + " [^ ]+"), "") + other + " ";
    expect_failure(changed + "--methods mpm --resume", 2, HasSubstr("a.csv:2: is of another"));
  }
  expect_failure("compare vibration_1d.toml --resume", 1, HasSubstr("--resume: needs --out"));
  write("a.csv", "method,remark\nmpm,\n");
  expect_failure(study + "--resume", 2, HasSubstr("a.csv:1: is no table of compare"));
  write("a.csv", before + "mpm,0.1\n");
  expect_failure(study + "--resume", 2, HasSubstr("a.csv:6: is no row"));
}

// The usage names the arguments that a command takes, and no others.
TEST_F(MpmProgram, UsageNamesTheArguments) {
  EXPECT_THAT(succeed("run --help"), HasSubstr("Usage: recon-mpm run FILE [OPTIONS]\n"));
  EXPECT_THAT(succeed("stability --help"), HasSubstr("Usage: recon-mpm stability [OPTIONS]\n"));
}

// Gong 2015, chapter 7, with the re-mapping taken into account.
TEST_F(MpmProgram, StabilityLimits) {
  const std::string text = succeed("stability --methods mpm,improved_cpdi --particles 1,4");
  EXPECT_THAT(text, HasSubstr("0.707"));
  EXPECT_THAT(text, HasSubstr("0.770"));
  EXPECT_THAT(text, HasSubstr("0.731"));
}

}  // namespace
}  // namespace recon::test

#endif
