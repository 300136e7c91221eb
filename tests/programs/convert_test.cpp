// recon convert, and pipes in and out of the programs.
#include "programs/run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class ConvertTest : public ProgramTest {};

TEST_F(ConvertTest, AnyFormatToAnyFormat) {
  const std::string csv = succeed("convert $CHUTE --out - --format csv");
  EXPECT_THAT(csv, StartsWith("id,radius,mass,x,y,z,vx,vy,vz,fx,fy,fz\n1,0.5,"));
  // Once round, in a ring: each reads what the one before wrote.
  succeed("convert $CHUTE --out a.xyz --quiet");
  succeed("convert a.xyz --out a.h5 --quiet");
  succeed("convert a.h5 --out a.dump --quiet");
  EXPECT_THAT(succeed("info a.dump"), HasSubstr("frames        6, steps 25000 to 50000"));
  EXPECT_THAT(succeed("convert a.dump --out a.vtp"),
              AllOf(HasSubstr("frames        1"), HasSubstr("written       a.vtp")));
  EXPECT_EQ(succeed("map a.vtp --fields vx --spacing 1 --radius 2 --out - "),
            succeed("map $CHUTE --fields vx --spacing 1 --radius 2 --periodic none --out -"));
  EXPECT_THAT(succeed("convert $CHUTE --where 'id <= 5' --frame 0 --out b.xyz"),
              HasSubstr("particles     5"));
  EXPECT_THAT(succeed("convert a.h5 --frame 1:2 --out b.dump"), HasSubstr("frames        2"));
}

TEST_F(ConvertTest, Pipes) {
  const std::string direct = succeed("map $CHUTE --fields vx --spacing 1 --radius 2 --out -");
  const Outcome piped =
      shell("zcat $CHUTE | '" + program() + "' convert - --out - --format xyz | '" + program() +
            "' map - --fields vx --spacing 1 --radius 2 --out -");
  EXPECT_EQ(piped.code, 0) << piped.err;
  EXPECT_EQ(piped.out, direct);
  const Outcome info = shell("mkfifo pipe; (cat $CHUTE > pipe) & '" + program() + "' info pipe");
  EXPECT_THAT(info.out, StartsWith("pipe, frame 5, step 50000: 3,000 particles")) << info.err;
  EXPECT_THAT(shell("'" + program() + "' info - < $CHUTE").out,
              StartsWith("standard input, frame 5"));
  const Outcome broken = shell("echo x,y | '" + program() + "' map - --fields x --out -");
  EXPECT_EQ(broken.code, 2);
  EXPECT_EQ(broken.out, "");
}

TEST_F(ConvertTest, Mistakes) {
  write("a.csv", "x,y\n1,2\n");
  expect_failure("convert a.csv", 1, HasSubstr("--out"));
  expect_failure("convert a.csv --out a.xxx", 1, HasSubstr("no extension of particles"));
  expect_failure("convert a.csv --out -", 1, HasSubstr("--format"));
  expect_failure("convert a.csv --out b --format vtu", 1, HasSubstr("did you mean"));
  expect_failure("convert a.csv --out a.csv", 1, HasSubstr("would be overwritten"));
  expect_failure("convert $CHUTE --frame all --out b.csv", 1, HasSubstr("xyz, dump or h5md"));
  expect_failure("convert a.csv --out none/b.xyz", 3, HasSubstr("no directory"));
  expect_failure("convert none.csv --out b.xyz", 2, HasSubstr("no such file"));
  expect_failure("map a.csv --fields y --out - --json", 1, HasSubstr("choose one"));
  write("b.csv", "a,b\n1,2\n");
  expect_failure("convert b.csv --out b.xyz", 2, HasSubstr("coordinate column x"));
  succeed("convert b.csv --coordinates a,b --out b.xyz --quiet");
  EXPECT_THAT(read("b.xyz"), HasSubstr("X 1 2 0\n"));
}

}  // namespace
}  // namespace recon::test
