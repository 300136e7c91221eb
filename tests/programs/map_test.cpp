#include <cmath>
#include <numbers>
#include <random>

#include "run_program.hpp"

namespace recon::test {
namespace {

using testing::HasSubstr;

class MapTest : public ProgramTest {
 protected:
  static double linear(double x, double y, double z) { return 1 + 2 * x - 3 * y + 0.5 * z; }

  // Particles at random in the unit square or cube, with u = linear(x, y, z).
  void write_cloud(const std::string& name, int particles, bool flat) const {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform;
    std::ostringstream text;
    text.precision(17);
    text << "id,x,y,z,u,vx,vy,vz,mass\n";
    for (int i = 0; i < particles; ++i) {
      const double x = uniform(random), y = uniform(random), z = flat ? 0.25 : uniform(random);
      text << i + 1 << ',' << x << ',' << y << ',' << z << ',' << linear(x, y, z) << ",3,4,"
           << (flat ? 0 : 12) << ",0.5\n";
    }
    write(name, text.str());
  }

  // A periodic lattice in [0,1)^2 with field and masses; a LAMMPS dump with periodic x and y.
  void write_periodic(const std::string& name, int side) const {
    std::ostringstream text;
    text.precision(17);
    text << "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n"
         << side * side
         << "\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n-0.5 0.5\nITEM: ATOMS id x y z mass u radius\n";
    for (int i = 0; i < side * side; ++i) {
      const double x = (i % side + 0.37) / side, y = (i / side + 0.11) / side;
      text << i + 1 << ' ' << x << ' ' << y << " 0 " << 1 + 0.5 * (i % 3) << ' '
           << std::sin(2 * std::numbers::pi * x) << " 0.01\n";
    }
    write(name, text.str());
  }
};

TEST_F(MapTest, ReproducesALinearField) {
  write_cloud("cloud.csv", 800, false);
  succeed(
      "map cloud.csv --fields u --spacing 0.2 --radius 0.35 --limit none --leverage 30 --out "
      "grid.csv");
  EXPECT_EQ(first_line("grid.csv"), "x,y,z,u,neighbours,rank,degree,status,limited");
  const ParticleTable grid = table("grid.csv");
  ASSERT_EQ(grid.size(), 216u);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    ASSERT_EQ(grid.column("degree")[i], 1) << grid.describe_row(i);
    EXPECT_NEAR(grid.column("u")[i],
                linear(grid.column("x")[i], grid.column("y")[i], grid.column("z")[i]), 1e-10);
  }
  EXPECT_THAT(read("grid.csv"), HasSubstr(",4,1,full,0\n"));
}

TEST_F(MapTest, AllMethodsOfDegreeOneReproduceIt) {
  write_cloud("cloud.csv", 300, true);
  for (const char* method : {"mls", "imls", "qr", "svd"}) {
    succeed(std::string("map cloud.csv --fields u --spacing 0.25 --k 12 --limit none --out m.csv "
                        "--method ") +
            method);
    const ParticleTable grid = table("m.csv");
    for (std::size_t i = 0; i < grid.size(); ++i)
      EXPECT_NEAR(grid.column("u")[i], linear(grid.column("x")[i], grid.column("y")[i], 0.25),
                  1e-10)
          << method;
  }
}

TEST_F(MapTest, ConstantZMeansTwoDimensions) {
  write_cloud("flat.csv", 200, true);
  EXPECT_THAT(succeed("map flat.csv --fields u --spacing 0.25 --out a.csv"), HasSubstr("in 2-D"));
  EXPECT_EQ(first_line("a.csv"), "x,y,u,neighbours,rank,degree,status,limited");
  EXPECT_THAT(succeed("map flat.csv --fields u --spacing 0.25 --dimension 3 --out b.csv"),
              HasSubstr("in 3-D"));
  EXPECT_EQ(first_line("b.csv"), "x,y,z,u,neighbours,rank,degree,status,limited");
  EXPECT_THAT(read("b.csv"), HasSubstr("reduced"));  // nothing is known across the plane
}

// A run in the plane y = 0.5: 2-D in x and z, in every name and file.
TEST_F(MapTest, AnyTwoCoordinatesMakeTwoDimensions) {
  std::ostringstream text;
  text.precision(17);
  text << "x,y,z,u,vx,vy,vz\n";
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < 200; ++i) {
    const double x = uniform(random), z = uniform(random);
    text << x << ",0.5," << z << ',' << linear(x, 0.5, z) << ",3,0,4\n";
  }
  write("plane.csv", text.str());
  const std::string map =
      "map plane.csv --fields u,velocity --gradient --spacing 0.25 --radius 0.35 --leverage 30 "
      "--limit none ";
  for (const char* coordinates : {"", " --coordinates x,z"}) {
    const std::string out = succeed(map + "--out a.csv --out a.vti" + coordinates);
    EXPECT_THAT(out, HasSubstr(*coordinates == 0 ? "in 2-D (x and z; y = 0.5 for all)" : "in 2-D"));
    EXPECT_THAT(out, HasSubstr("full degree at 25 (100 %)"));
    EXPECT_EQ(first_line("a.csv"),
              "x,z,u,du_dx,du_dz,velocity_x,velocity_z,dvx_dx,dvx_dz,dvz_dx,dvz_dz,neighbours,rank,"
              "degree,status,limited");
    const ParticleTable grid = table("a.csv");
    for (std::size_t i = 0; i < grid.size(); ++i) {
      EXPECT_NEAR(grid.column("u")[i], linear(grid.column("x")[i], 0.5, grid.column("z")[i]),
                  1e-10);
      EXPECT_NEAR(grid.column("du_dz")[i], 0.5, 1e-8);
      EXPECT_NEAR(grid.column("velocity_z")[i], 4, 1e-10);
    }
    // In space it lies where the particles are.
    const std::string vti = read("a.vti");
    EXPECT_THAT(vti, HasSubstr("WholeExtent=\"0 4 0 0 0 4\""));
    EXPECT_THAT(vti, HasSubstr(*coordinates == 0 ? "Origin=\"0 0.5 0\"" : "Origin=\"0 0 0\""));
    EXPECT_THAT(vti, HasSubstr("Name=\"velocity\" NumberOfComponents=\"3\""));
  }
  write("points.csv", "x,y,z\n0.25,7,0.5\n0.75,8,0.5\n");
  succeed("map plane.csv --fields u --radius 0.35 --targets points.csv --out at.csv --out at.vtp");
  EXPECT_EQ(first_line("at.csv"), "x,z,u,neighbours,rank,degree,status,limited");
  EXPECT_NEAR(table("at.csv").column("u")[1], linear(0.75, 0.5, 0.5), 1e-10);
}

TEST_F(MapTest, GradientsOfALinearField) {
  write_cloud("cloud.csv", 300, true);
  succeed(
      "map cloud.csv --fields u --spacing 0.25 --radius 0.3 --leverage 30 --gradient --out g.csv");
  EXPECT_EQ(first_line("g.csv"), "x,y,u,du_dx,du_dy,neighbours,rank,degree,status,limited");
  const ParticleTable grid = table("g.csv");
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_NEAR(grid.column("du_dx")[i], 2, 1e-9);
    EXPECT_NEAR(grid.column("du_dy")[i], -3, 1e-9);
  }
}

TEST_F(MapTest, TargetsOfAFile) {
  write_cloud("cloud.csv", 300, true);
  write("points.csv", "name,x,y\na,0.5,0.5\nb,0.25,0.75\n");
  succeed("map cloud.csv --fields u --radius 0.3 --targets points.csv --out at.csv --out at.vtp");
  const ParticleTable at = table("at.csv");
  ASSERT_EQ(at.size(), 2u);
  EXPECT_NEAR(at.column("u")[0], linear(0.5, 0.5, 0.25), 1e-10);
  EXPECT_NEAR(at.column("u")[1], linear(0.25, 0.75, 0.25), 1e-10);
  EXPECT_THAT(read("at.vtp"), HasSubstr("PolyData"));
}

TEST_F(MapTest, VtkHasTheFieldsAndTheReports) {
  write_cloud("cloud.csv", 200, true);
  succeed("map cloud.csv --fields u,speed --components v=vx,vy --spacing 0.25 --out a.vti");
  const std::string vti = read("a.vti");
  for (const char* name : {"u", "speed", "v", "neighbours", "rank", "degree", "status",
                           "smallest_pivot", "gradient_rank", "gradient_amplification", "limited"})
    EXPECT_THAT(vti, HasSubstr("Name=\"" + std::string(name) + "\"")) << name;
}

TEST_F(MapTest, DerivedVelocityAndSpeed) {
  write_cloud("cloud.csv", 400, false);
  succeed("map cloud.csv --fields velocity,speed --spacing 0.5 --radius 0.5 --out a.csv");
  EXPECT_EQ(first_line("a.csv"),
            "x,y,z,velocity_x,velocity_y,velocity_z,speed,neighbours,rank,degree,status,limited");
  const ParticleTable grid = table("a.csv");
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_NEAR(grid.column("velocity_y")[i], 4, 1e-12);
    EXPECT_NEAR(grid.column("speed")[i], 13, 1e-12);
  }
}

TEST_F(MapTest, AllIsEveryColumnButLabelsAndCoordinates) {
  write_cloud("cloud.csv", 200, true);
  succeed("map cloud.csv --fields all --spacing 0.5 --out a.csv");
  EXPECT_EQ(first_line("a.csv"), "x,y,u,vx,vy,vz,mass,neighbours,rank,degree,status,limited");
}

// The same at the nodes on either side of the seam as on a shifted copy's interior.
TEST_F(MapTest, PeriodicSeam) {
  write_periodic("wave.dump", 16);
  EXPECT_THAT(succeed("map wave.dump --fields u --spacing 0.125 --radius 0.15 --out on.csv"),
              HasSubstr("periodic in x and y"));
  succeed("map wave.dump --fields u --spacing 0.125 --radius 0.15 --periodic none --out off.csv");
  const ParticleTable on = table("on.csv"), off = table("off.csv");
  EXPECT_EQ(on.size(), 64u);
  EXPECT_GE(off.size(), 81u);
  // A lattice that is periodic has the same number of neighbours everywhere along y.
  for (std::size_t i = 0; i < on.size(); ++i)
    EXPECT_EQ(on.column("neighbours")[i], on.column("neighbours")[i % 8]) << i;
  for (std::size_t i = 0; i < on.size(); ++i)
    EXPECT_NEAR(on.column("u")[i], std::sin(2 * std::numbers::pi * on.column("x")[i]), 0.1);
}

// The cubic B-spline as a tensor product with support 2 h sums to one over a grid of spacing h: the
// masses at the nodes add up to the mass of the particles, to rounding.
TEST_F(MapTest, DensityKeepsTheMass) {
  write_periodic("wave.dump", 16);
  succeed(
      "map wave.dump --fields density,number_density,solid_fraction --form tensor "
      "--spacing 0.125 --radius 0.25 --out d.csv");
  const ParticleTable grid = table("d.csv"), particles = table("wave.dump");
  double mass = 0, expected = 0, number = 0, solid = 0;
  for (const double density : grid.column("density")) mass += density * 0.125 * 0.125;
  for (const double density : grid.column("number_density")) number += density * 0.125 * 0.125;
  for (const double part : grid.column("solid_fraction")) solid += part * 0.125 * 0.125;
  for (const double m : particles.column("mass")) expected += m;
  EXPECT_NEAR(mass, expected, 1e-11 * expected);
  EXPECT_NEAR(number, 256, 1e-9);
  EXPECT_NEAR(solid, 256 * std::numbers::pi * 1e-4, 1e-12);
}

// With a radial weight the sum over a grid that is fine beside the support comes close.
TEST_F(MapTest, RadialDensityKeepsTheMassNearly) {
  write_cloud("cloud.csv", 200, false);
  succeed(
      "map cloud.csv --fields density --spacing 0.1 --radius 0.4 --bounds "
      "-0.5,1.5,-0.5,1.5,-0.5,1.5 --out d.csv --unsupported nearest");
  const ParticleTable grid = table("d.csv");
  double mass = 0;
  for (const double density : grid.column("density")) mass += density * 1e-3;
  EXPECT_NEAR(mass, 100, 0.01);
}

// The nearest particles alone do not fill the support they define.
TEST_F(MapTest, DensityWithNearestNeighbours) {
  write_periodic("wave.dump", 16);
  succeed("map wave.dump --fields number_density --k 9 --spacing 0.125 --out d.csv");
  const ParticleTable grid = table("d.csv");
  for (const double density : grid.column("number_density")) EXPECT_NEAR(density, 256, 16);
}

// Two kinds of particles at the same places, of masses 1 and 99: the mean by mass.
TEST_F(MapTest, WeightByMass) {
  std::string text = "x,y,mass,u\n";
  for (int i = 0; i < 50; ++i)
    for (const char* kind : {",1,0\n", ",99,1\n"})
      text += std::to_string(i % 10) + "," + std::to_string(i / 10) + kind;
  write("two.csv", text);
  const std::string map =
      "map two.csv --fields u,density --spacing 2 --radius 2.5 --method shepard --out a.csv";
  succeed(map);
  const ParticleTable plain = table("a.csv");
  EXPECT_THAT(succeed(map + " --weight-by mass"), HasSubstr("times mass"));
  const ParticleTable weighted = table("a.csv");
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_NEAR(plain.column("u")[i], 0.5, 1e-12);
    EXPECT_NEAR(weighted.column("u")[i], 0.99, 1e-12);
    EXPECT_EQ(weighted.column("density")[i], plain.column("density")[i]);
  }
  expect_failure("map two.csv --fields u --out b.csv --weight-by mas", 1, HasSubstr("'mass'"));
  expect_failure("map two.csv --fields u --out b.csv --weight-by u", 2,
                 testing::AllOf(HasSubstr("--weight-by u: 0 at row 0"), HasSubstr("positive")));
}

// The sum over the grid beside that of the particles, and a warning where nodes cannot see all.
TEST_F(MapTest, SumsAreCompared) {
  write_periodic("wave.dump", 16);
  const std::string map = "map wave.dump --fields number_density --form tensor --out d.csv ";
  std::string out = succeed(map + "--spacing 0.125 --radius 0.25");
  EXPECT_THAT(out, HasSubstr("number_density: 256 over the grid, 256 of the particles"));
  EXPECT_THAT(out, testing::Not(HasSubstr("warning")));
  out = succeed(map + "--spacing 0.125 --radius 0.05");
  EXPECT_THAT(out, HasSubstr("of the particles"));
  EXPECT_THAT(out, HasSubstr("warning"));
  EXPECT_THAT(out, HasSubstr("radius 0.05 is smaller than the spacing 0.125"));
  out = succeed(map + "--spacing 0.125 --radius 0.25 --bounds 0,0.5,0,0.5");  // of a part
  EXPECT_THAT(out, testing::Not(HasSubstr("of the particles")));
}

TEST_F(MapTest, FramesFromBothEnds) {
  EXPECT_THAT(succeed("map \"$CHUTE\" --frame 0 --fields vx --out a.csv"), HasSubstr("step 25000"));
  EXPECT_THAT(succeed("map \"$CHUTE\" --frame -6 --fields vx --out b.csv"),
              HasSubstr("step 25000"));
  EXPECT_THAT(succeed("map \"$CHUTE\" --fields vx --out c.csv"), HasSubstr("step 50000"));
  EXPECT_EQ(read("a.csv"), read("b.csv"));
  EXPECT_NE(read("a.csv"), read("c.csv"));
}

TEST_F(MapTest, WithoutSupport) {
  write("two.csv", "x,y,u\n0,0,1\n10,1,2\n");
  const std::string map =
      "map two.csv --fields u --spacing 5 --radius 1 --out a.csv --unsupported ";
  succeed(map + "nan");
  EXPECT_THAT(read("a.csv"), HasSubstr("5,0,nan,0,0,-1,no_support,0\n"));
  succeed(map + "-1");
  EXPECT_THAT(read("a.csv"), HasSubstr("5,0,-1,0,0,-1,no_support,0\n"));
  succeed(map + "nearest");
  EXPECT_THAT(read("a.csv"), HasSubstr("5,0,1,0,"));
  EXPECT_THAT(read("a.csv"), HasSubstr(",nearest,0\n"));
}

// Three particles close together and one far away: the plane through the three is 6.67 at (2, 0).
TEST_F(MapTest, ValuesStayNearTheirData) {
  write("three.csv", "x,y,v\n0,0,0\n0.3,0,1\n0,0.3,0\n6,6,0.5\n");
  const std::string map =
      "map three.csv --fields v --spacing 1 --bounds 0,6,0,6 --out a.csv --radius 3 ";
  for (const char* limit : {"", "--limit range", "--limit relaxed", "--limit none"}) {
    const std::string out = succeed(map + limit);
    const ParticleTable grid = table("a.csv");
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const double v = grid.raw_column("v")[i];
      if (std::isnan(v)) continue;
      EXPECT_GE(v, limit == std::string("--limit none") ? -0.2 : 0) << limit;
      EXPECT_LE(v, limit == std::string("--limit none") ? 1.2 : 1) << limit;
    }
    EXPECT_THAT(out, HasSubstr(limit == std::string("--limit none") ? "nothing (--limit none)"
                                                                    : " of the values, at "));
  }
}

TEST_F(MapTest, LimitedValuesAreCounted) {
  std::ostringstream text;
  text << "x,y,u,w\n";  // a step between lattice lines, and a linear field
  for (int i = 0; i < 400; ++i)
    text << i % 20 << ',' << i / 20 << ',' << (i % 20 < 10 ? 0 : 1) << ',' << i % 20 << '\n';
  write("step.csv", text.str());
  const std::string map =
      "map step.csv --fields u,w --degree 2 --spacing 0.5 --bounds 2,17,2,17 --out a.csv --out "
      "a.vti ";
  succeed(map + "--limit none");
  const ParticleTable plain = table("a.csv");
  for (const char* limit : {"--limit range", "--limit relaxed"}) {
    const std::string out = succeed(map + limit);
    const ParticleTable grid = table("a.csv");
    int targets = 0;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const double u = grid.column("u")[i], expected = plain.column("u")[i];
      EXPECT_NEAR(u, std::clamp(expected, 0.0, 1.0), 1e-12);
      EXPECT_EQ(grid.column("limited")[i], std::abs(u - expected) > 1e-12 ? 1 : 0);
      targets += grid.column("limited")[i] > 0;
      EXPECT_NEAR(grid.column("w")[i], grid.column("x")[i], 1e-12);
    }
    EXPECT_GT(targets, 20);
    EXPECT_THAT(out, HasSubstr("at " + std::to_string(targets) + " targets"));
    EXPECT_THAT(read("a.vti"), HasSubstr("Name=\"limited\""));
  }
}

TEST_F(MapTest, TargetsTooFarFromAllParticles) {
  std::ostringstream text;
  text << "x,y,u\n";
  for (int i = 0; i < 100; ++i) text << i % 10 << ',' << i / 10 << ",2\n";
  write("square.csv", text.str());
  const std::string map =
      "map square.csv --fields u --spacing 1 --bounds 0,30,0,9 --out a.csv --out a.vti ";
  EXPECT_THAT(succeed(map + "--unsupported nearest"),
              HasSubstr("too far from all particles at 170 (54.8 %): nan"));
  EXPECT_THAT(read("a.csv"), HasSubstr("30,0,nan,0,0,-1,too_far,0\n"));
  EXPECT_THAT(read("a.csv"), HasSubstr("11,0,2,9,"));
  succeed(map + "--unsupported -4");
  EXPECT_THAT(read("a.csv"), HasSubstr("30,0,-4,0,0,-1,too_far,0\n"));
  EXPECT_THAT(succeed(map + "--max-distance none"), testing::Not(HasSubstr("too far")));
  EXPECT_THAT(read("a.csv"), HasSubstr("30,0,2,9,"));
}

// Sums have one support everywhere, and are what they are where fields have no value.
TEST_F(MapTest, SumsKeepTheirMeaningWithAdaptiveSupports) {
  std::ostringstream text;
  text << "x,y,mass,u\n";
  for (int i = 0; i < 400; ++i)
    text << i % 20 + 0.5 << ',' << i / 20 + 0.5 << ",0.25," << i % 20 << '\n';
  write("square.csv", text.str());
  EXPECT_THAT(
      succeed("map square.csv --fields density,u --spacing 0.5 --bounds -8,28,-8,28 --out a.csv"),
      HasSubstr("of sums radius 2"));
  const ParticleTable grid = table("a.csv");
  double mass = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) mass += grid.column("density")[i] * 0.25;
  EXPECT_NEAR(mass, 100, 0.5);
  EXPECT_THAT(read("a.csv"), HasSubstr("-8,-8,0,nan,0,0,-1,too_far,0\n"));
}

TEST_F(MapTest, GrowingSupportsReachTheDegree) {
  write_cloud("cloud.csv", 200, true);
  const std::string map = "map cloud.csv --fields u --spacing 0.1 --radius 0.06 --out a.csv";
  succeed(map);
  EXPECT_THAT(read("a.csv"), HasSubstr("reduced"));
  succeed(map + " --grow 12");
  EXPECT_THAT(read("a.csv"), testing::Not(HasSubstr("reduced")));
}

TEST_F(MapTest, ThreadsDoNotMatter) {
  succeed("map \"$CHUTE\" --fields vx,solid_fraction --threads 1 --out a.csv");
  succeed("map \"$CHUTE\" --fields vx,solid_fraction --threads 3 --out b.csv");
  EXPECT_EQ(read("a.csv"), read("b.csv"));
}

TEST_F(MapTest, QuietSaysNothing) {
  EXPECT_EQ(succeed("map \"$CHUTE\" --fields vx --out a.csv --quiet"), "");
}

TEST_F(MapTest, ReplacesAnOlderOutput) {
  write("a.csv", "old");
  write_cloud("cloud.csv", 100, true);
  succeed("map cloud.csv --fields u --out a.csv");
  EXPECT_EQ(first_line("a.csv"), "x,y,u,neighbours,rank,degree,status,limited");
  EXPECT_EQ(files(), (std::vector<std::string>{"a.csv", "cloud.csv"}));
}

TEST_F(MapTest, PictureIsAPng) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  succeed("map \"$CHUTE\" --fields velocity --slice z=3 --show velocity,degree --picture a.png");
  EXPECT_EQ(read("a.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_GT(read("a.png").size(), 2000u);
}

TEST_F(MapTest, PictureOfAFieldWithAnyName) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  std::string text = "x,y,d'a''b,\"p, `q` $(r)\"\n";
  for (int i = 0; i < 36; ++i)
    text += std::to_string(i % 6) + "," + std::to_string(i / 6) + "," + std::to_string(i) + ",1\n";
  write("a.csv", text);
  succeed("map a.csv --fields \"d'a''b\" --picture a.png");
  succeed("map a.csv --fields \"d'a''b,\\\"p, \\`q\\` \\$(r)\\\"\" --picture b.png");
  EXPECT_TRUE(exists("a.png") && exists("b.png"));
}

// One particle of a hundred is far off: the colours are those of the others, and this is said.
TEST_F(MapTest, OutliersAreSaid) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  std::string text = "x,y,u\n";
  for (int i = 0; i < 400; ++i)
    text += std::to_string(i % 20) + "," + std::to_string(i / 20) + "," +
            (i == 209 ? "1e6" : std::to_string(i % 20)) + "\n";
  write("a.csv", text);
  const std::string map = "map a.csv --fields u --spacing 1 --radius 0.9 --picture a.png ";
  EXPECT_THAT(succeed(map), HasSubstr("1 node above, up to 1e+06"));
  EXPECT_THAT(succeed(map + "--colours all"), testing::Not(HasSubstr("above")));
  EXPECT_THAT(succeed(map + "--colours 0,12"), HasSubstr("nodes above, up to 1e+06"));
  expect_failure("map a.csv --fields u --picture b.png --colours 2,1", 1,
                 HasSubstr("--colours 2,1"));
}

}  // namespace
}  // namespace recon::test
