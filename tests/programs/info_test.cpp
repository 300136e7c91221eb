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
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  succeed(out.substr(at + 9, out.find('\n', at + 1) - at - 9));
  EXPECT_TRUE(exists("fields.vti"));
  EXPECT_EQ(read("fields.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
}

// Whatever the names of the file and of its columns, and whatever was said about it.
TEST_F(InfoTest, SuggestsACommandThatWorksWithAnyNames) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  std::string text = "ID,xsu,ix,east,north,part_type,\"d'a''b, \"\"q\"\" $(x)\"\n";
  for (int i = 0; i < 40; ++i)
    text += std::to_string(i) + ",0.5,0," + std::to_string(i % 8) + "," + std::to_string(i / 8) +
            "," + std::to_string(i % 2) + "," + std::to_string(i) + "\n";
  write("it's a `file`.csv", text);
  const std::string out =
      succeed("info \"it's a \\`file\\`.csv\" --coordinates east,north --where 'ID > 3'");
  const std::size_t at = out.find("\n  recon map ");
  ASSERT_NE(at, std::string::npos) << out;
  EXPECT_THAT(succeed(out.substr(at + 9, out.find('\n', at + 1) - at - 9)),
              HasSubstr("36 of 40 particles"));
  EXPECT_TRUE(exists("fields.png"));
}

// Of a LAMMPS dump without velocities: labels, scaled and unwrapped coordinates are no fields.
TEST_F(InfoTest, SuggestsFieldsThatAreFields) {
  std::string text =
      "ITEM: UNITS\nlj\nITEM: TIME\n0.035\nITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n27\n"
      "ITEM: BOX BOUNDS ff ff ff\n0 3\n0 3\n0 3\n"
      "ITEM: ATOMS id type mol xs ys zs xsu ysu zsu ix iy iz temperature\n";
  for (int i = 0; i < 27; ++i) {
    const std::string place = std::to_string((i % 3 + 0.5) / 3) + " " +
                              std::to_string((i / 3 % 3 + 0.5) / 3) + " " +
                              std::to_string((i / 9 + 0.5) / 3) + " ";
    text += std::to_string(i + 1) + " 1 1 " + place + place + "0 0 0 " + std::to_string(i) + "\n";
  }
  write("a.dump", text);
  const std::string out = succeed("info a.dump");
  EXPECT_THAT(out, HasSubstr("--fields temperature --spacing"));
  EXPECT_THAT(out, testing::ContainsRegex("units +lj\n"));
  EXPECT_THAT(out, HasSubstr("1, step 7, time 0.035\n"));
  succeed("map a.dump --fields all --out a.csv");
  EXPECT_EQ(first_line("a.csv"), "x,y,z,temperature,neighbours,rank,degree,status,limited");
}

TEST_F(InfoTest, CountsCoincidentParticles) {
  std::string text = "x,y,v\n";
  for (int i = 0; i < 30; ++i) text += std::to_string(i % 6) + "," + std::to_string(i / 6) + ",1\n";
  write("a.csv", text);
  EXPECT_THAT(succeed("info a.csv"), testing::Not(HasSubstr("coincident")));
  write("a.csv", text + "0,0,1\n0,0,2\n3,2,1\n");
  EXPECT_THAT(succeed("info a.csv"), testing::ContainsRegex("coincident +5 particles at 2 places"));
}

// Also across a periodic border.
TEST_F(InfoTest, CoincidentImages) {
  write("a.dump",
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\n"
        "ITEM: ATOMS id x y z\n1 0 1 1\n2 4 1 1\n3 2 2 2\n");
  EXPECT_THAT(succeed("info a.dump"), HasSubstr("2 particles at 1 place that"));
}

// 5e5 with a spacing of 0.01: the figures tell the ends apart.
TEST_F(InfoTest, FiguresEnoughForTheRange) {
  std::string text = "x,y,v\n";
  for (int i = 0; i < 64; ++i)
    text += "500000.0" + std::to_string(i % 8) + ",5600000.0" + std::to_string(i / 8) +
            ",1000000." + std::to_string(i % 4) + "\n";
  write("a.csv", text);
  const std::string out = succeed("info a.csv");
  EXPECT_THAT(out, HasSubstr("x  500000 .. 500000.07\n"));
  EXPECT_THAT(out, HasSubstr("y  5600000 .. 5600000.07\n"));
  EXPECT_THAT(out, testing::ContainsRegex("v +1000000 +1000000\\.3 +1000000\\.15\n"));
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
