// --where: the particles that a condition is true of, and what is wrong with conditions.
#include "run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class WhereTest : public ProgramTest {
 protected:
  // A lattice of 12 x 10 particles whose type is 1, 2, 3 in turn, and u = type.
  WhereTest() {
    std::string text = "id,x,y,type,u,v [m/s],c_s[1]\n";
    for (int i = 0; i < 120; ++i)
      text += std::to_string(i + 1) + "," + std::to_string(i % 12) + "," + std::to_string(i / 12) +
              "," + std::to_string(i % 3 + 1) + "," + std::to_string(i % 3 + 1) + "," +
              std::to_string(i) + "," + std::to_string(-i) + "\n";
    write("a.csv", text);
  }

  std::string map(const std::string& condition) const {
    return "map a.csv --fields u --spacing 3 --k 6 --out o.csv --where '" + condition + "'";
  }
  void expect_kept(const std::string& condition, int particles) const {
    EXPECT_THAT(
        succeed(map(condition)),
        HasSubstr("where " + condition + ": " + std::to_string(particles) + " of 120 particles\n"));
  }
};

TEST_F(WhereTest, OnlyThoseParticlesCount) {
  succeed(map("type == 2"));
  const ParticleTable grid = table("o.csv");
  for (const double u : grid.column("u")) EXPECT_NEAR(u, 2, 1e-12);
  succeed("map a.csv --fields u --spacing 3 --k 6 --out o.csv");
  EXPECT_NE(table("o.csv").column("u"), grid.column("u"));
  EXPECT_THAT(succeed("info a.csv --where 'type == 2'"), HasSubstr("40 of 120"));
  EXPECT_THAT(succeed("profile a.csv --axis y --fields u --out p.csv --where 'type == 2'"),
              HasSubstr("40 of 120"));
}

TEST_F(WhereTest, WordsSignsAndPrecedence) {
  expect_kept("type == 2 and x > 5", 20);
  expect_kept("type == 2 && x > 5", 20);
  expect_kept("type == 1 or type == 2 and x > 5", 60);
  expect_kept("(type == 1 or type == 2) and x > 5", 40);
  expect_kept("not type == 2", 80);
  expect_kept("not type == 2 and x > 5", 40);
  expect_kept("NOT (type == 2 AND x > 5)", 100);
  expect_kept("!(type == 2)", 80);
  expect_kept("not (not type != 1)", 80);
  expect_kept("x^2 + y^2 <= 4", 6);
  expect_kept("sqrt(x^2 + y^2) <= min(2, 3)", 6);
  expect_kept("-x < -10.5e0", 10);
  expect_kept("x < pi", 40);
  expect_kept("type == 2 ? x > 5 : 0", 20);
  expect_kept("(x > 5) == (y > 4)", 60);
}

TEST_F(WhereTest, NamesThatAreNoWords) {
  expect_kept("`v [m/s]` >= 100", 20);
  expect_kept("c_s[1] > -10", 10);
}

TEST_F(WhereTest, Mistakes) {
  const auto fail = [&](const std::string& condition, const std::string& what) {
    expect_failure(map(condition), 1, AllOf(HasSubstr("--where '" + condition), HasSubstr(what)));
  };
  fail("tpye == 2", "at position 1: unknown column 'tpye'; did you mean 'type'?");
  fail("x > 1 and z > 1", "at position 11: unknown column 'z'");
  fail("type = 2", "at position 6: '=' assigns; the sign of equality is ==");
  fail("x > 1, y > 1", "at position 6: one condition is needed");
  fail("0 < x < 5", "at position 7: comparisons in a row");
  fail("sin(0 < x < 5) > 0", "at position 11: comparisons in a row");
  fail("x > 1 and", "ends too early");
  fail("x y > 1", "at position 3: 'y > 1' cannot be understood");
  fail("(x > 1", "at position 1: the parenthesis is not closed");
  fail("x > 1)", "at position 6: there is no '('");
  fail("squrt(x) > 1", "unknown function 'squrt'; did you mean 'sqrt'");
  fail("sqrt(x, y) > 1", "position 1");
  fail("x & y", "write 'and'");
  fail("`x > 1", "backtick");
  fail("x > 1e999", "double");
  fail("type == 4", "none of the 120 particles");
  expect_failure(map(" "), 1, HasSubstr("a condition is needed"));
  expect_failure(map("type - 1"), 2,
                 AllOf(HasSubstr("neither true nor false but 2"), HasSubstr("line 4")));
  expect_failure(map("sqrt(-1 - x)"), 2, HasSubstr("but nan at row 0"));
  write("a.csv", "x,y,type,name\n0,0,1,a\n1,1,nan,b\n2,3,2,c\n");
  expect_failure("map a.csv --fields type --where 'name == 1' --out o.csv", 2,
                 HasSubstr("line 2) of a.csv = 'a': is not a number"));
  expect_failure("map a.csv --fields x --where 'type == 1' --out o.csv", 2, HasSubstr("line 3"));
}

}  // namespace
}  // namespace recon::test
