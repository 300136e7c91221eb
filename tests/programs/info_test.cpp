#include "run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using InfoTest = ProgramTest;

TEST_F(InfoTest, TellsWhatADumpHolds) {
  const std::string out = succeed("info \"$CHUTE\"");
  EXPECT_THAT(out, HasSubstr("3,000 particles in 3-D, periodic in x and y"));
  EXPECT_THAT(out, HasSubstr("6, steps 25000 to 50000"));
  EXPECT_THAT(out, testing::ContainsRegex("vx +2\\.0378 +6\\.0409"));
  EXPECT_THAT(out, HasSubstr("mean spacing"));
  EXPECT_THAT(out, HasSubstr("solid_fraction"));
}

TEST_F(InfoTest, SuggestsACommandThatWorks) {
  const std::string out = succeed("info \"$CHUTE\"");
  const std::size_t at = out.find("\n  recon map ");
  ASSERT_NE(at, std::string::npos) << out;
  succeed(out.substr(at + 9, out.find('\n', at + 1) - at - 9));
  EXPECT_TRUE(exists("fields.vti"));
}

TEST_F(InfoTest, CountsNumbersThatAreNotFinite) {
  write("a.csv", "x,y,u\n0,0,1\n1,0,nan\n0,1,\n1,1,4\n");
  EXPECT_THAT(succeed("info a.csv"),
              AllOf(HasSubstr("4 particles in 2-D"), HasSubstr("not finite at 2 particles")));
}

// A lattice of spacing 0.25, so that is the mean spacing, and the grid suggested is the lattice.
TEST_F(InfoTest, MeanSpacingOfALattice) {
  std::string text = "x,y,u\n";
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 5; ++j)
      text += std::to_string(0.25 * i) + "," + std::to_string(0.25 * j) + ",1\n";
  write("lattice.csv", text);
  const std::string out = succeed("info lattice.csv");
  EXPECT_THAT(out, testing::ContainsRegex("mean spacing +0\\.25\n"));
  EXPECT_THAT(out, HasSubstr("spacing 0.25 (9 x 5 nodes)"));
}

}  // namespace
}  // namespace recon::test
