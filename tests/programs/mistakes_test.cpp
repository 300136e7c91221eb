// What a user can get wrong: each mistake has its exit code and a message that helps, and
// leaves no file.
#include "run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class MistakesTest : public ProgramTest {
 protected:
  MistakesTest() { write("grains.csv", "x,y,vx,vy\n0,0,1,0\n1,0,2,0\n0,1,3,0\n1,1,4,0\n"); }
};

TEST_F(MistakesTest, MisspeltNames) {
  expect_failure("mapp grains.csv", 1, HasSubstr("did you mean 'map'?"));
  expect_failure("map grains.csv --feilds vx --out a.csv", 1,
                 HasSubstr("did you mean '--fields'?"));
  expect_failure("map --feilds=vx grains.csv --out a.csv", 1,
                 HasSubstr("did you mean '--fields'?"));
  expect_failure("map grains.csv --fields vxx --out a.csv", 1,
                 HasSubstr("unknown field 'vxx'; did you mean 'vx'"));
  expect_failure("map grains.csv --fields sped --out a.csv", 1, HasSubstr("'speed'"));
  expect_failure("map grains.csv --fields vx --method imsl --out a.csv", 1,
                 HasSubstr("did you mean 'imls'?"));
  expect_failure("map grains.csv --fields vx --weight cubc --out a.csv", 1,
                 HasSubstr("did you mean 'cubic'?"));
  expect_failure("map grain.csv --fields vx --out a.csv", 2, HasSubstr("grains.csv"));
  expect_failure("grains.csv", 1, HasSubstr("recon info grains.csv"));
}

TEST_F(MistakesTest, Values) {
  const std::string map = "map grains.csv --fields vx --out a.csv ";
  expect_failure(map + "--radius -1", 1,
                 HasSubstr("--radius: a number above 0 is needed, not '-1'"));
  expect_failure(map + "--radius wide", 1, HasSubstr("'wide'"));
  expect_failure(map + "--k 0", 1, HasSubstr("1 or more"));
  expect_failure(map + "--k 5", 1, HasSubstr("4 particles only"));
  expect_failure(map + "--degree 9", 1, HasSubstr("'9'"));
  expect_failure(map + "--method shepard --degree 1", 1, HasSubstr("mls or imls"));
  expect_failure(map + "--periodic x", 1, HasSubstr("--bounds"));
  expect_failure(map + "--bounds 0,1", 1, HasSubstr("0,1,0,1"));
  expect_failure(map + "--bounds 0,1,3,2", 1, HasSubstr("'3,2'"));
  expect_failure(map + "--spacing 1e-9", 1, HasSubstr("spacing"));
  expect_failure(map + "--dimension 3", 1, HasSubstr("dimension"));
  expect_failure(map + "--unsupported maybe", 1, HasSubstr("'maybe'"));
  expect_failure(map + "--slice y=0", 1, HasSubstr("--picture"));
  expect_failure(map + "stray", 1, HasSubstr("'stray'"));
  expect_failure("map grains.csv --fields density --out a.csv", 1, HasSubstr("mass"));
  expect_failure("map grains.csv --fields vx,vx --out a.csv", 1, HasSubstr("twice"));
  expect_failure("map grains.csv --fields vx", 1, HasSubstr("--out"));
  expect_failure("map grains.csv --out a.csv", 1, HasSubstr("--fields"));
  expect_failure(map + "--radius 1 --radius 2", 1, HasSubstr("--radius can be given only once"));
  expect_failure(map + "--radius", 1, HasSubstr("--radius needs a value"));
  expect_failure("map", 1, HasSubstr("FILE"));
}

// Names of reports are taken, all of them.
TEST_F(MistakesTest, FieldsWithTheNameOfAReport) {
  for (const std::string name :
       {"neighbours", "rank", "degree", "status", "smallest_pivot", "amplification",
        "gradient_rank", "gradient_amplification", "limited"}) {
    write("taken.csv", "x,y," + name + "\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n");
    expect_failure("map taken.csv --fields " + name + " --out a.csv", 1,
                   HasSubstr("has the name of a report"));
  }
}

// 3.6e9 nodes want some 600 GB.
TEST_F(MistakesTest, MoreMemoryThanThereIs) {
  const double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * 4096;
  if (bytes > 300e9) GTEST_SKIP() << "this machine might have the memory";
  expect_failure("map grains.csv --fields vx --out a.csv --spacing 5e-5 --bounds 0,3,0,3", 1,
                 HasSubstr("GB"));
}

TEST_F(MistakesTest, Inputs) {
  write("broken.csv", "x,y,u\n0,0,1\n1,zero,2\n");
  expect_failure("map broken.csv --fields u --out a.csv", 2,
                 AllOf(HasSubstr("(line 3) of broken.csv"), HasSubstr("zero")));
  write("short.csv", "x,y,u\n0,0,1\n1,0\n");
  expect_failure("map short.csv --fields u --out a.csv", 2, HasSubstr("short.csv:3:"));
  write("nan.csv", "id,x,y,u\n11,0,0,1\n12,1,0,nan\n13,0,1,1\n");
  expect_failure("map nan.csv --fields u --out a.csv", 2,
                 AllOf(HasSubstr("column u"), HasSubstr("id 12")));
  write("nowhere.csv", "id,x,y,u\n11,0,0,1\n12,nan,0,1\n13,0,1,1\n");
  expect_failure("map nowhere.csv --fields u --out a.csv", 2,
                 AllOf(HasSubstr("column x"), HasSubstr("id 12")));
  expect_failure("map \"$CHUTE\" --frame 6 --fields vx --out a.csv", 2, HasSubstr("6 frames"));
  write("flat.csv", "x\n1\n");
  expect_failure("map grains.csv --fields vx --targets flat.csv --out a.csv", 2, HasSubstr("2-D"));
}

TEST_F(MistakesTest, Outputs) {
  expect_failure("map grains.csv --fields vx --out none/a.csv", 3, HasSubstr("none"));
  expect_failure("map grains.csv --fields vx --out a.vtx", 1, HasSubstr(".vti"));
  expect_failure("map grains.csv --fields vx --picture a.gif", 1, HasSubstr(".png"));
  expect_failure("map grains.csv --fields vx --out a.csv --out ./a.csv", 1, HasSubstr("twice"));
  const std::string before = read("grains.csv");
  expect_failure("map grains.csv --fields vx --out ./grains.csv", 1, HasSubstr("input"));
  expect_failure("map grains.csv --fields vx --out a.csv --out none/b.csv", 3, HasSubstr("none"));
  EXPECT_EQ(read("grains.csv"), before);
}

TEST_F(MistakesTest, HelpAndVersion) {
  EXPECT_THAT(succeed("--version"), testing::StartsWith("recon 0."));
  EXPECT_THAT(succeed("--help"), AllOf(HasSubstr("Exit codes"), HasSubstr("profile")));
  EXPECT_THAT(succeed("help map"), AllOf(HasSubstr("--fields"), HasSubstr("Examples")));
  EXPECT_EQ(succeed("help map"), succeed("map --help"));
  for (const char* command : {"--help", "help info", "help map", "help profile"}) {
    std::istringstream lines(succeed(command));
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

}  // namespace
}  // namespace recon::test
