// Several frames: a series of outputs with a list, and their mean and standard deviation.
#include <random>

#include "run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SeriesTest : public ProgramTest {
 protected:
  // Frame f of a lattice of `side` x `side` particles in [0, 5]^2: u = x + 10 f.
  static std::string frame(int f, int side = 6, bool time = true) {
    std::ostringstream text;
    if (time) text << "ITEM: TIME\n" << 0.5 * f << "\n";
    text << "ITEM: TIMESTEP\n"
         << 100 * f << "\nITEM: NUMBER OF ATOMS\n"
         << side * side
         << "\nITEM: BOX BOUNDS ff ff ff\n0 5\n0 5\n0 5\nITEM: ATOMS id x y z u vx vy\n";
    for (int i = 0; i < side * side; ++i)
      text << i + 1 << ' ' << i % side << ' ' << i / side << " 0 " << i % side + 10 * f << " 1 "
           << f << '\n';
    return text.str();
  }
};

TEST_F(SeriesTest, EachFrameHasItsFilesAndOneListHasAll) {
  write("a.dump", frame(0) + frame(1) + frame(2));
  const std::string out =
      succeed("map a.dump --frame all --fields u --spacing 1 --radius 1.5 --out v.vti --out v.csv");
  EXPECT_THAT(out, AllOf(HasSubstr("step 200, time 1: 36 particles"), HasSubstr("v_0002.vti"),
                         HasSubstr("v.pvd")));
  EXPECT_EQ(files(),
            (std::vector<std::string>{"a.dump", "v.pvd", "v_0000.csv", "v_0000.vti", "v_0001.csv",
                                      "v_0001.vti", "v_0002.csv", "v_0002.vti"}));
  for (int f = 0; f < 3; ++f) {
    const ParticleTable grid = table("v_000" + std::to_string(f) + ".csv");
    ASSERT_EQ(grid.size(), 36u);
    for (std::size_t i = 0; i < grid.size(); ++i)
      EXPECT_NEAR(grid.column("u")[i], grid.column("x")[i] + 10 * f, 1e-12);
    EXPECT_THAT(read("v.pvd"),
                HasSubstr("timestep=\"" +
                          std::string(f == 0   ? "0"
                                      : f == 1 ? "0.5"
                                               : "1") +
                          "\" part=\"0\" file=\"v_000" + std::to_string(f) + ".vti\""));
  }
  succeed("map a.dump --frame 1 --fields u --spacing 1 --radius 1.5 --out one.csv");
  EXPECT_EQ(read("one.csv"), read("v_0001.csv"));
}

TEST_F(SeriesTest, RangesAndSteps) {
  std::string dump;
  for (int f = 0; f < 7; ++f) dump += frame(f, 3, false);
  write("a.dump", dump);
  const auto frames = [&](const std::string& choice) {
    const std::string out =
        succeed("map a.dump --frame=" + choice + " --fields u --out v.vtp" + " --targets p.csv");
    std::string steps;
    std::istringstream list(read("v.pvd"));
    for (std::string line; std::getline(list, line);)
      if (const auto at = line.find("timestep=\""); at != std::string::npos)
        steps += line.substr(at + 10, line.find('"', at + 10) - at - 10) + " ";
    return steps;
  };
  write("p.csv", "x,y\n1,1\n");
  EXPECT_EQ(frames("all"), "0 100 200 300 400 500 600 ");  // without times: steps
  EXPECT_EQ(frames("2:4"), "200 300 400 ");
  EXPECT_EQ(frames("-2:"), "500 600 ");
  EXPECT_EQ(frames(":-6"), "0 100 ");
  EXPECT_EQ(frames("1:6:2"), "100 300 500 ");
  EXPECT_EQ(frames("3:3"), "300 ");
}

TEST_F(SeriesTest, SeveralFiles) {
  write("a b&<.csv", "x,y,u\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n");
  write("c.csv", "x,y,u\n0,0,2\n1,0,3\n0,1,4\n2,1,5\n");
  succeed("map 'a b&<.csv' c.csv --fields u --spacing 1 --out 's&<.vti'");
  EXPECT_THAT(read("s&<.pvd"),
              AllOf(HasSubstr("timestep=\"0\" part=\"0\" file=\"s&amp;&lt;_0000.vti\""),
                    HasSubstr("timestep=\"1\" part=\"0\" file=\"s&amp;&lt;_0001.vti\"")));
  EXPECT_THAT(read("s&<_0001.vti"), HasSubstr("WholeExtent=\"0 2 0 1 0 0\""));  // its own grid
}

// Mean and standard deviation as the formulas say, over the frames in which a target has a value.
TEST_F(SeriesTest, Average) {
  write("a.dump", frame(0) + frame(1) + frame(3));
  const std::string out = succeed(
      "map a.dump --frame all --average --fields u,velocity --gradient --spacing 1 --radius 1.5 "
      "--out m.csv --out m.vti");
  EXPECT_THAT(out, HasSubstr("frames        3"));
  EXPECT_EQ(first_line("m.csv"),
            "x,y,u_mean,u_std,du_dx_mean,du_dx_std,du_dy_mean,du_dy_std,velocity_mean_x,"
            "velocity_mean_y,velocity_std_x,velocity_std_y,dvx_dx_mean,dvx_dx_std,dvx_dy_mean,"
            "dvx_dy_std,dvy_dx_mean,dvy_dx_std,dvy_dy_mean,dvy_dy_std,frames,frames_full");
  const ParticleTable grid = table("m.csv");
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_NEAR(grid.column("u_mean")[i], grid.column("x")[i] + 40.0 / 3, 1e-12);
    EXPECT_NEAR(grid.column("u_std")[i], std::sqrt(700.0 / 3), 1e-12);
    EXPECT_NEAR(grid.column("velocity_std_y")[i], std::sqrt(7.0 / 3), 1e-12);
    EXPECT_EQ(grid.column("frames")[i], 3);
    EXPECT_EQ(grid.column("frames_full")[i], 3);
  }
  EXPECT_THAT(files(), Not(testing::Contains("m.pvd")));
}

// Fluctuations of 1 on a mean of 1e9: sums of squares would lose them.
TEST_F(SeriesTest, SmallFluctuationsOfALargeMean) {
  std::string dump;
  for (int f = 0; f < 4; ++f) {
    dump += "ITEM: TIMESTEP\n" + std::to_string(f) + "\nITEM: NUMBER OF ATOMS\n9\n" +
            "ITEM: BOX BOUNDS ff ff ff\n0 3\n0 3\n0 3\nITEM: ATOMS id x y z u\n";
    for (int i = 0; i < 9; ++i)
      dump += std::to_string(i) + " " + std::to_string(i % 3) + " " + std::to_string(i / 3) +
              " 0 " + std::to_string(1'000'000'000 + (f % 2 == 0 ? 1 : -1)) + "\n";
  }
  write("a.dump", dump);
  succeed(
      "map a.dump --frame all --average --fields u --method shepard --spacing 1 --radius 1.5 --out "
      "m.csv");
  const ParticleTable grid = table("m.csv");
  for (const double deviation : grid.column("u_std"))
    EXPECT_NEAR(deviation, std::sqrt(4.0 / 3), 1e-6);
}

// A target without particles in one frame has the mean of the others; one that never has any, none.
TEST_F(SeriesTest, TargetsMissingInSomeFrames) {
  write("a.csv", "x,y,u\n0,0,1\n1,0,1\n0,1,1\n1,1,1\n");
  write("b.csv", "x,y,u\n0,0,3\n0.1,0,3\n0,0.1,3\n0.1,0.1,3\n");
  write("p.csv", "x,y\n0,0\n1,1\n9,9\n");
  const std::string map =
      "map a.csv b.csv --average --fields u --method shepard --radius 0.5 --targets p.csv --out "
      "m.csv ";
  const std::string out = succeed(map);
  EXPECT_THAT(out, HasSubstr("1 target in some frames, 1 in all"));
  EXPECT_EQ(read("m.csv"),
            "x,y,u_mean,u_std,frames,frames_full\n0,0,2,1.4142135623730951,2,2\n1,1,1,nan,1,1\n"
            "9,9,nan,nan,0,0\n");
  succeed(map + "--unsupported -1");  // stands for no value at all, and is in no mean
  EXPECT_THAT(read("m.csv"), AllOf(HasSubstr("1,1,1,nan,1,1\n"), HasSubstr("9,9,-1,nan,0,0\n")));
}

TEST_F(SeriesTest, WhatLiesOutsideTheGridIsSaid) {
  write("a.csv", "x,y,u\n0,0,1\n1,0,1\n0,1,1\n1,1,1\n");
  write("b.csv", "x,y,u\n0,0,3\n5,0,3\n0,5,3\n1,1,3\n");
  const std::string map =
      "map a.csv b.csv --average --fields u --spacing 1 --radius 1.5 --out m.csv ";
  EXPECT_THAT(succeed(map), HasSubstr("2 particles outside the grid of the first frame in b.csv"));
  EXPECT_THAT(succeed(map + "--bounds 0,5,0,5"), Not(HasSubstr("outside")));
  EXPECT_EQ(table("m.csv").size(), 36u);
}

TEST_F(SeriesTest, Mistakes) {
  write("a.dump", frame(0) + frame(1));
  const std::string map = "map a.dump --fields u --out v.csv ";
  expect_failure(map + "--frame 0:5", 2, AllOf(HasSubstr("--frame 0:5"), HasSubstr("2 frames")));
  expect_failure(map + "--frame 1:0", 1, HasSubstr("before the first"));
  expect_failure(map + "--frame al", 1, HasSubstr("'al' is no frame"));
  expect_failure(map + "--frame 0:1:0", 1, HasSubstr("is no frame"));
  expect_failure(map + "--average", 1, HasSubstr("--frame all"));
  expect_failure(map + "--frame all --average --picture p.png --show u", 1, HasSubstr("u_mean"));
  expect_failure(map + "vy", 1, AllOf(HasSubstr("'vy'"), HasSubstr("commas")));
  expect_failure("info a.dump --frame all", 1, HasSubstr("one frame"));
  expect_failure("profile a.dump a.dump --fields u --out p.csv", 1, HasSubstr("recon map"));
  write("v_0001.csv", "x,y,u\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n");
  const std::string before = read("v_0001.csv");
  EXPECT_EQ(run("map a.dump v_0001.csv --frame all --fields u --out v.csv").code, 1);
  EXPECT_EQ(read("v_0001.csv"), before);
  // Flat at first, and not later: what lies above would be lost.
  write("flat.csv", "x,y,z,u\n0,0,0,1\n1,0,0,2\n0,1,0,3\n1,1,0,4\n");
  write("deep.csv", "x,y,z,u\n0,0,0,1\n1,0,1,2\n0,1,0,3\n1,1,2,4\n");
  const std::string both = "map flat.csv deep.csv --fields u --spacing 1 --average --out m.csv";
  expect_failure(both, 2, AllOf(HasSubstr("deep.csv"), HasSubstr("coordinate z varies")));
  succeed(both + " --dimension 3");
}

}  // namespace
}  // namespace recon::test
