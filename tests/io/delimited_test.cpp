#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <limits>

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
      read("\"v:0\",\"Points:0\",\"Points:1\",\"Points:2\"\n9,1,2,3\n8,2,1,4\n");
  EXPECT_EQ(table.positions()(1, 2), 4);
}

TEST_F(Delimited, EmptyAndNanCells) {
  const ParticleTable table = read("id,x,y,p,q\n5,1,2,,nan\n6,3,,1,2\n");
  EXPECT_EQ(table.column("x"), (Values{1, 3}));
  EXPECT_TRUE(std::isnan(table.raw_column("p")[0]));
  expect_invalid([&] { table.column("p"); }, "column p, row 0 (id 5, line 2) of a.csv = ''");
  expect_invalid([&] { table.column("q"); }, "row 0 (id 5, line 2)");
  expect_invalid([&] { table.positions(); }, "column y, row 1 (id 6, line 3)");
  expect_invalid([&] { table.field("pq", {"x", "q"}); }, "column q");
}

// Whatever stands in columns that nobody asks for; asked for, the first bad cell is named.
TEST_F(Delimited, ColumnsAreTypedWhenTheyAreUsed) {
  const ParticleTable table =
      read("x,y,material,note,note,w\n1,2,304,a,b,1\n3,4,316L,c,d,NA\n5,7,sand,e,f,1e999\n");
  EXPECT_EQ(table.positions()(2, 1), 7);
  EXPECT_EQ(table.names(), (Names{"x", "y"}));
  EXPECT_EQ(table.text_columns(), (Names{"material", "w"}));
  EXPECT_EQ(
      table.remarks,
      (Names{
          "columns that hold text are no fields: material ('316L' on line 3), w ('NA' on line 3)",
          "names of several columns, which can therefore not be used: note"}));
  expect_invalid([&] { table.column("material"); },
                 "column material, row 1 (line 3) of a.csv = '316L'");
  expect_invalid([&] { table.column("w"); }, "row 1 (line 3) of a.csv = 'NA': is not a number");
  expect_invalid([&] { table.column("note"); }, "several columns of a.csv (numbers 4, 5)");
  const ParticleTable bad = read("x,y\n1,2\n1,two\n");
  expect_invalid([&] { bad.positions(); }, "column y, row 1 (line 3) of a.csv = 'two'");
}

TEST_F(Delimited, MissingValues) {
  const auto path = folder.file("a.csv", "x,y,v,w\n0,0,1,-9999\nNA,0,2,3\n2,0,-9999.0,4\n3,1,,5\n");
  ParticleTable table = read_particles(path, {.missing = {"NA", "-9999"}});
  EXPECT_EQ(table.names(), (Names{"x", "y", "v", "w"}));
  EXPECT_EQ(table.leave_out_missing(table.coordinates()), 1u);
  EXPECT_EQ(table.column("x"), (Values{0, 2, 3}));
  EXPECT_EQ(table.leave_out_missing({"v"}), 1u);
  expect_invalid([&] { table.column("v"); }, "row 3 (line 5) of a.csv = ''");
  table = read_particles(path, {.missing = {"NA", "-9999", ""}});
  EXPECT_EQ(table.leave_out_missing({"x", "y", "v", "w"}), 4u);
  EXPECT_EQ(table.size(), 0u);
}

TEST_F(Delimited, CommentsWithPercent) {
  EXPECT_EQ(read("% made by hand\n% x y v\n1 2 3\n% a\n4 5 6\n").column("v"), (Values{3, 6}));
  EXPECT_EQ(read("%x,y\n1,2\n").column("x"), (Values{1}));
}

TEST_F(Delimited, ARowOfUnits) {
  const ParticleTable table = read("x,y,v\nm,m,\xb5m/s\n1,2,3\n4,5,NA\n");
  EXPECT_EQ(table.column("x"), (Values{1, 4}));
  EXPECT_EQ(table.remarks.back(),
            "line 2 holds no number and is taken for units: x [m], y [m], v [\xc2\xb5m/s]");
  EXPECT_EQ(table.describe_row(0), "row 0 (line 3)");
  EXPECT_EQ(recon::list_frames(folder / "a.csv")[0].particles, 2u);
  EXPECT_EQ(read("x,y\n-,mm\n# a\n\n1,2\n").column("y"), (Values{2}));
  // No units: a row with a number, a row without values, a row before another one without numbers.
  EXPECT_EQ(read("x,y,v\nm,m,1\n1,2,3\n").size(), 2u);
  EXPECT_EQ(read("x,y,v\nNA,NA,-\n1,2,3\n").size(), 2u);
  EXPECT_EQ(read("x,y,v\nnan,NA,NA\n1,2,3\n").size(), 2u);
  EXPECT_EQ(read("x,y\na,b\nc,d\n1,2\n").size(), 3u);
  EXPECT_EQ(read("x,y\na,b\n").size(), 1u);
}

TEST_F(Delimited, NamesFromTheOptions) {
  const auto path = folder.file("a.csv", "1,2,3\n4,5,6\n");
  const ParticleTable table = read_particles(path, {.columns = {"x", "y", "v, fast"}});
  EXPECT_EQ(table.names(), (Names{"x", "y", "v, fast"}));
  EXPECT_EQ(table.column("x"), (Values{1, 4}));
  test::expect_file_error(
      [&] {
        read_particles(path, {.columns = {"x", "y"}});
      },
      1, "has 3 cells, the option columns names 2 columns");
  expect_invalid([&] { read_particles(path, {.columns = {"x", ""}}); }, "name of a column");
  folder.file("a.csv", "run 7\n\nX;Y\n1;2\n");
  EXPECT_EQ(read_particles(path, {.skip_rows = 2}).column("Y"), (Values{2}));
  EXPECT_EQ(read_particles(path, {.columns = {"x", "y"}, .skip_rows = 3}).column("y"), (Values{2}));
  EXPECT_EQ(read_particles(path, {.skip_rows = 2}).describe_row(0), "row 0 (line 4)");
  test::expect_file_error([&] { read_particles(path, {.skip_rows = 4}); }, 4, "ends without");
  test::expect_file_error([&] { read_particles(path, {.skip_rows = 5}); }, 0,
                          "behind the 5 rows to skip: the file has 4 lines");
}

TEST_F(Delimited, NamesThatAreNotUtf8) {
  const ParticleTable table = read("x,y,v\xb2,\xc2\xb5\n1,2,3,4\n");  // one is Latin-1, one UTF-8
  EXPECT_EQ(table.names(), (Names{"x", "y", "v\xc2\xb2", "\xc2\xb5"}));
  EXPECT_EQ(table.remarks, (Names{"names that are not UTF-8 are read as Latin-1 (Windows-1252)"}));
  EXPECT_TRUE(read("x,y,\xc2\xb5\n1,2,3\n").remarks.empty());
}

TEST_F(Delimited, TheLastLineBreakIsMissing) {
  const ParticleTable table = read("x,y\n1,2\n3,4.2");
  ASSERT_EQ(table.remarks.size(), 1u);
  EXPECT_NE(table.remarks[0].find("no line break"), std::string::npos);
}

// Eight times as many columns may take eight times as long, not 64 times: processor time against
// processor time, the least of a few tries each.
TEST_F(Delimited, ManyColumns) {
  const auto seconds = [&](int columns) {
    std::string names = "x", cells = "1";
    for (int i = 1; i < columns; ++i) {
      names += ",c" + std::to_string(i);
      cells += ",1";
    }
    const std::string text = names + "\n" + cells + "\n", last = "c" + std::to_string(columns - 1);
    std::clock_t least = std::numeric_limits<std::clock_t>::max();
    for (int i = 0; i < 3; ++i) {
      const std::clock_t start = std::clock();
      const ParticleTable table = read(text);
      EXPECT_EQ(table.names().size(), static_cast<std::size_t>(columns));
      EXPECT_EQ(table.column(last), (Values{1}));
      least = std::min(least, std::clock() - start);
    }
    return static_cast<double>(least) / CLOCKS_PER_SEC;
  };
  EXPECT_LT(seconds(40000) / seconds(5000), 8 * 3);
}

TEST_F(Delimited, DecimalComma) {
  const ParticleTable table = read("x;y;p\n1;2;2,5\n");
  expect_invalid([&] { table.column("p"); }, "1.5 and not 1,5");
  expect_invalid([&] { read("x;y\n1,5;2\n").positions(); }, "(line 2) of a.csv = '1,5'");
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
