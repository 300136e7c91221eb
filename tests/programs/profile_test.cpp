#include "run_program.hpp"

namespace recon::test {
namespace {

using ProfileTest = ProgramTest;

// A linear profile over a lattice: degree 1 follows it up to the border, Shepard cannot.
TEST_F(ProfileTest, LinearProfile) {
  std::ostringstream text;
  text << "x y z u\n";
  for (int i = 0; i < 512; ++i)
    text << i % 8 << ' ' << i / 8 % 8 << ' ' << i / 64 << ' ' << 2 * (i / 64) + 1 << '\n';
  write("lattice.txt", text.str());
  succeed(
      "profile lattice.txt --fields u --methods shepard,imls,imls:2 --radius 2.2 --range 0,7 "
      "--spacing 0.5 --across 1 --out p.csv");
  EXPECT_EQ(first_line("p.csv"),
            "z,u_shepard,u_imls,u_imls_2,supported,full_shepard,full_imls,full_imls_2");
  const ParticleTable profile = read_particles(folder() / "p.csv");
  ASSERT_EQ(profile.size(), 15u);
  for (std::size_t i = 0; i < profile.size(); ++i)
    EXPECT_NEAR(profile.column("u_imls")[i], 2 * profile.column("z")[i] + 1, 1e-10);
  EXPECT_GT(profile.column("u_shepard")[0], 1.1);
  EXPECT_EQ(profile.column("supported")[0], 1);
}

TEST_F(ProfileTest, ChuteSlipsLessThanShepardSays) {
  succeed(
      "profile \"$CHUTE\" --fields vx,solid_fraction --methods shepard,mls,imls --radius 2 "
      "--range 0,9 --out p.csv");
  const ParticleTable p = read_particles(folder() / "p.csv");
  EXPECT_NEAR(p.column("vx_shepard")[0], 2.89, 0.02);
  EXPECT_NEAR(p.column("vx_imls")[0], 1.60, 0.02);
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_NEAR(p.column("vx_mls")[i], p.column("vx_imls")[i], 1e-9);
  EXPECT_TRUE(p.has("solid_fraction"));
}

TEST_F(ProfileTest, PictureIsAPng) {
  if (!has_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  succeed("profile \"$CHUTE\" --fields vx --methods shepard,imls --picture p.png");
  EXPECT_EQ(read("p.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
}

TEST_F(ProfileTest, Mistakes) {
  using testing::HasSubstr;
  expect_failure("profile \"$CHUTE\" --fields vx --axis w --out p.csv", 1,
                 HasSubstr("'x', 'y' or 'z'"));
  expect_failure("profile \"$CHUTE\" --fields vx --methods imls,imls --out p.csv", 1,
                 HasSubstr("twice"));
  expect_failure("profile \"$CHUTE\" --fields vx --out p.vti", 1, HasSubstr(".csv"));
  expect_failure("profile \"$CHUTE\" --fields vx --range 5,1 --out p.csv", 1,
                 HasSubstr("--range 5,1"));
}

}  // namespace
}  // namespace recon::test
