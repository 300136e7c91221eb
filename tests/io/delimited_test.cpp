#include <gtest/gtest.h>

#include <cmath>

#include "recon/core/error.hpp"
#include "recon/io/read.hpp"
#include "temporary.hpp"

namespace {

using recon::ParticleTable;
using recon::read_particles;
using test::expect_invalid;
using test::TemporaryFolder;
using Names = std::vector<std::string>;
using Values = std::vector<double>;

class Delimited : public testing::Test {
 protected:
  ParticleTable read(const std::string& text, int frame = -1) {
    return read_particles(folder.file("a.csv", text), {.frame = frame});
  }
  void expect_error(const std::string& text, std::size_t line, const std::string& part) {
    test::expect_file_error([&] { read(text); }, line, part);
  }
  TemporaryFolder folder;
};

TEST_F(Delimited, EachDelimiter) {
  for (const std::string text :
       {"x,y,m\n1,2,3\n4,5,6\n", "x;y;m\n1;2;3\n4;5;6\n", "x\ty\tm\n1\t2\t3\n4\t5\t6\n",
        "x y  m\n 1 2\t3\n4   5 6 \n", "x , y , m\n1, 2, 3\n 4 ,5 ,6\n",
        "x,y,m\r\n1,2,3\r\n4,5,6\r\n", "\xef\xbb\xbfx,y,m\n1,2,3\n4,5,6"}) {
    const ParticleTable table = read(text);
    EXPECT_EQ(table.names(), (Names{"x", "y", "m"})) << text;
    EXPECT_EQ(table.column("x"), (Values{1, 4})) << text;
    EXPECT_EQ(table.column("m"), (Values{3, 6})) << text;
    EXPECT_EQ(table.dimension(), 2);
  }
}

TEST_F(Delimited, CommentsAndBlankLines) {
  const ParticleTable table = read("# made by hand\n\nx,y\n# a\n1,2\n\n  \n3,4\n#5,6\n");
  EXPECT_EQ(table.column("y"), (Values{2, 4}));
  EXPECT_EQ(table.describe_row(1), "row 1 (line 8)");
}

TEST_F(Delimited, CommentedHeader) {
  EXPECT_EQ(read("# two lines\n# x y z\n1 2 3\n4 5 7\n").column("z"), (Values{3, 7}));
  EXPECT_EQ(read("#x,y\n1,2\n").column("x"), (Values{1}));
  EXPECT_EQ(read("## x;y\n1;2\n").column("y"), (Values{2}));
}

TEST_F(Delimited, QuotedNamesAndUnits) {
  const ParticleTable table =
      read("\"x\", y,\"v, \"\"fast\"\" [m/s]\",p [Pa],\"1985\"\n\"1\",2,3,4,5\n");
  EXPECT_EQ(table.names(), (Names{"x", "y", "v, \"fast\" [m/s]", "p [Pa]", "1985"}));
  EXPECT_EQ(table.column("v, \"fast\" [m/s]"), (Values{3}));
  EXPECT_EQ(read("\"x x\" y\n1 2\n").names(), (Names{"x x", "y"}));
}

TEST_F(Delimited, UnnamedColumnsAreNumbered) {
  EXPECT_EQ(read(",x,y\n0,1,2\n").names(), (Names{"column_1", "x", "y"}));
}

TEST_F(Delimited, ParaViewNames) {
  const ParticleTable table =
      read("\"v:0\",\"Points:0\",\"Points:1\",\"Points:2\"\n9,1,2,3\n8,1,2,4\n");
  EXPECT_EQ(table.positions()(1, 2), 4);
}

TEST_F(Delimited, EmptyAndNanCells) {
  const ParticleTable table = read("id,x,y,p,q\n5,1,2,,nan\n6,3,,1,2\n");
  EXPECT_EQ(table.column("x"), (Values{1, 3}));
  EXPECT_TRUE(std::isnan(table.raw_column("p")[0]));
  expect_invalid([&] { table.column("p"); }, "column p, row 0 (id 5, line 2) of a.csv = nan");
  expect_invalid([&] { table.column("q"); }, "row 0 (id 5, line 2)");
  expect_invalid([&] { table.positions(); }, "column y, row 1 (id 6, line 3)");
  expect_invalid([&] { table.field("pq", {"x", "q"}); }, "column q");
}

TEST_F(Delimited, TextColumns) {
  const ParticleTable table = read("x,y,material\n1,2,sand\n3,4,7\n");
  EXPECT_EQ(table.text_columns(), (Names{"material"}));
  expect_invalid([&] { table.column("material"); }, "holds text ('sand' on line 2)");
  expect_error("x,y,p\n1,2,\n1,2,3\n1,2,abc\n", 4, "'abc' is not a number: column 'p'");
  expect_error("x,y\n1,2\n1,two\n", 3, "'two' is not a number: column 'y'");
}

TEST_F(Delimited, DecimalComma) {
  expect_error("x;y\n1,5;2\n", 2, "1.5 and not 1,5");
  const ParticleTable table = read("x;y;p\n1;2;2,5\n");
  expect_invalid([&] { table.column("p"); }, "1.5 and not 1,5");
}

TEST_F(Delimited, HeaderIsNeeded) {
  expect_error("1,2,3\n4,5,6\n", 1, "x,y,z,mass");
  expect_error("# some remark of six words here\n1 2 3\n", 2, "header line");
  expect_error("x,2,z\n4,5,6\n", 1, "header line");
  expect_error("# only remarks\n", 1, "ends without a header");
  expect_error("\n\n", 2, "ends without a header");
}

TEST_F(Delimited, RaggedRows) {
  expect_error("x,y\n1,2\n\n3\n", 4, "has 1 cells, the header (line 1) names 2");
  expect_error("x,y\n1,2,3\n", 2, "has 3 cells");
  expect_error("x y\n1 2\n3 4 5\n", 3, "has 3 cells");
  test::expect_file_error([&] { recon::list_frames(folder.file("b.csv", "x,y\n1\n")); }, 2,
                          "has 1 cells");
}

TEST_F(Delimited, BrokenQuotes) {
  expect_error("\"x,y\n1,2\n", 1, "does not end on this line");
  expect_error("x,y\n\"1\"2,3\n", 2, "delimiter");
}

TEST_F(Delimited, DuplicateNames) {
  expect_error("x,y,x\n1,2,3\n", 1, "'x' is that of columns 1 and 3");
}

TEST_F(Delimited, OneFrame) {
  EXPECT_EQ(read("x\n1\n2\n", 0).size(), 2u);
  test::expect_file_error([&] { read("x\n1\n", 1); }, 0, "the file has 1 frame");
  const auto frames = recon::list_frames(folder.file("b.csv", "x,y\n1,2\n3,4\n"));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].particles, 2u);
  EXPECT_EQ(frames[0].columns, (Names{"x", "y"}));
  EXPECT_FALSE(frames[0].step);
}

TEST_F(Delimited, HeaderOnlyIsAnEmptyTable) {
  const ParticleTable table = read("x,y\n");
  EXPECT_EQ(table.size(), 0u);
  EXPECT_EQ(table.dimension(), 2);
}

}  // namespace
