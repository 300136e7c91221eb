// recon-mpm from end to end.
#ifdef RECON_MPM_PROGRAM

#include "programs/run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

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
              HasSubstr("another run"));
  const std::string before = read("out/ledger.csv");
  succeed(
      "run disks.toml --cells 10 --set end=0.3 --set frames=3 --quiet --out out "
      "--restart out/checkpoint.h5");
  EXPECT_EQ(read("out/ledger.csv"), before);
}

TEST_F(MpmProgram, AFailureIsExplained) {
  const Outcome outcome =
      run("run wall.toml --method mpm --cells 10 --set 'velocity=[1,0.5]' --quiet --out out");
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("step "), HasSubstr("particle "), HasSubstr("checkpoint.h5")));
  EXPECT_TRUE(exists("out/checkpoint.h5"));
}

TEST_F(MpmProgram, Mistakes) {
  expect_failure("run disks.toml --method cplss", 1, HasSubstr("did you mean 'cpls'"));
  expect_failure("run disks.toml --metod cpls", 1, HasSubstr("--method"));
  expect_failure("run disk.toml", 2, HasSubstr("no such file"));
  expect_failure("run disks.toml --set cels=3", 2, HasSubstr("grid.cells"));
  expect_failure("run disks.toml --cells 0", 1, HasSubstr("above 0"));
  expect_failure("run disks.toml --restart none.h5", 3, HasSubstr("no such file"));
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
  EXPECT_EQ(rows.size(), 2u * 3 * 3 * 4 * 2);
  EXPECT_THAT(read("c.csv"), HasSubstr("cpls,32,0.03125,0.02"));
}

TEST_F(MpmProgram, CompareShowsAllMethods) {
  const std::string shown = succeed(
      "compare vibration_1d.toml --cells 4,8 --methods mpm,cpls,q8 --no-stability --quiet --out "
      "a.csv");
  EXPECT_THAT(shown, AllOf(HasSubstr("\ncpls "), HasSubstr("refused: "), HasSubstr("is for 2-D")));
  const std::string csv = read("a.csv");
  EXPECT_THAT(csv, AllOf(HasSubstr("method,displacement error,order"), HasSubstr("\ncpls,"),
                         HasSubstr("refused")));
  expect_failure("compare vibration_1d.toml --methods cpl", 1, HasSubstr("cpls"));
  expect_failure("compare vibration_1d.toml --cells no", 1, HasSubstr("--cells"));
  expect_failure("compare vibration_1d.toml --against luck", 1, HasSubstr("angular"));
  expect_failure("compare nothing.toml", 2, HasSubstr("no such file"));
  expect_failure("compare vibration_1d.toml --picture a.gif", 1, HasSubstr(".png"));
}

TEST_F(MpmProgram, OneClaimIsVerified) {
  EXPECT_THAT(succeed("verify --only 'figure 4.8' --quiet"),
              AllOf(HasSubstr("| Gong 2015, figure 4.8 |"), HasSubstr("| holds |")));
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
