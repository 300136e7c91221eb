// recon map on several ranks: the fields of one process, and one clear message where that cannot be.
#include <functional>
#include <map>

#include "on_ranks/mpirun.hpp"

namespace recon::test {
namespace {

using testing::HasSubstr;

class MapOnRanks : public OnRanksTest {
 protected:
  // A value of each column at each node.
  using Nodes = std::map<std::vector<double>, std::vector<double>>;
  static void add(const ParticleTable& table, Nodes& nodes) {
    const auto x = table.positions(3);
    for (std::size_t i = 0; i < table.size(); ++i) {
      std::vector<double> place, values;
      for (int d = 0; d < x.dimension(); ++d) place.push_back(x(i, d));
      for (const std::string& name : table.names())
        if (!axis_of_coordinate(name)) values.push_back(table.raw_column(name)[i]);
      const auto [at, is_new] = nodes.try_emplace(place, values);
      if (is_new) continue;
      // Pieces share the nodes between them.
      for (std::size_t c = 0; c < values.size(); ++c) expect_near(at->second[c], values[c]);
    }
  }
  static void expect_near(double a, double b) {
    if (std::isnan(a) && std::isnan(b)) return;
    EXPECT_NEAR(a, b, 1e-12 * std::max({1.0, std::abs(a), std::abs(b)}));
  }

  // The program's answer on some ranks is that on one, and its pieces share nodes as they should.
  void expect_as_one(const std::string& arguments, std::initializer_list<int> numbers) const {
    succeed("map " + arguments + " --out one.vti");
    Nodes wanted;
    add(table("one.vti"), wanted);
    for (const int ranks : numbers) {
      const Outcome outcome = on(ranks, "map " + arguments + " --out v.pvti --quiet");
      ASSERT_EQ(outcome.code, 0) << outcome.err;
      EXPECT_EQ(outcome.out + outcome.err, "");
      Nodes got;
      const std::string list = read("v.pvti");
      for (int r = 0; r < ranks; ++r) {
        const std::string piece = "v_" + std::to_string(r) + ".vti";
        if (list.find(piece) != std::string::npos) add(table(piece), got);
      }
      ASSERT_EQ(got.size(), wanted.size()) << ranks << " ranks";
      for (const auto& [place, values] : wanted) {
        ASSERT_TRUE(got.contains(place));
        for (std::size_t c = 0; c < values.size(); ++c) expect_near(values[c], got[place][c]);
      }
    }
  }

  // One message on the standard error, whatever mpirun adds; and no file more than before.
  void expect_one_message(int ranks, const std::string& arguments, int code,
                          const testing::Matcher<const std::string&>& message) const {
    const std::vector<std::string> before = files();
    const Outcome outcome = on(ranks, arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_THAT(outcome.err, message);
    const std::size_t first = outcome.err.find("recon: ");
    EXPECT_EQ(outcome.err.find("recon: ", first + 1), std::string::npos) << outcome.err;
    EXPECT_EQ(files(), before);
  }

  // Rows of x,y,z,v in turns of 256, of which ranks read every second; z is what `z` says.
  void write_rows(const std::string& name, const std::function<std::string(int)>& row) const {
    std::string text = "x,y,z,v\n";
    for (int i = 0; i < 1024; ++i) text += row(i) + "\n";
    write(name, text);
  }
  static std::string place(int i) {
    return std::to_string(i % 32 + 0.1 * (i % 7)) + "," + std::to_string(i / 32 + 0.1 * (i % 5));
  }

  static constexpr const char* on_all = " --max-distance none";
};

TEST_F(MapOnRanks, FieldsAreThoseOfOneProcess) {
  for (const std::string support : {" --k 20", " --radius 2", " --k 30 --radius 1.5"})
    expect_as_one("\"$CHUTE\" --fields vx,velocity --spacing 1.5" + support + on_all, {2, 3});
  for (const std::string limit : {" --limit none", " --limit range"})
    expect_as_one("\"$CHUTE\" --fields speed --spacing 1.5 --k 20" + limit + on_all, {2});
  expect_as_one("\"$CHUTE\" --fields speed --spacing 1.5 --k 30 --method mls:2 --gradient" +
                    std::string(on_all),
                {2});
  // Fewer particles than a turn for each rank, more ranks than planes, a condition, a weight.
  expect_as_one(
      "\"$CHUTE\" --frame 0 --where 'z > 3' --weight-by mass --fields vz --spacing 8 --k 12" +
          std::string(on_all),
      {4});
}

TEST_F(MapOnRanks, AxesAreThoseOfAllParticles) {
  // z is one number in each part, but another one in each.
  write_rows("layers.csv",
             [&](int i) { return place(i) + "," + std::to_string(i / 256 % 2) + ",1"; });
  expect_as_one("layers.csv --fields v --spacing 4 --k 12" + std::string(on_all), {2});
  EXPECT_EQ(table("one.vti").dimension(), 3);
  write_rows("plane.csv", [&](int i) { return place(i) + ",7," + std::to_string(i % 3); });
  expect_as_one("plane.csv --fields v --spacing 4 --radius 3" + std::string(on_all), {2, 3});
}

TEST_F(MapOnRanks, PiecesOfMoreRanksAreNotLeft) {
  const std::string arguments =
      "map \"$CHUTE\" --fields vx --spacing 4 --k 20 --quiet --out v.pvti";
  write("v_9.vti", "of somebody else");
  for (const int ranks : {3, 2}) EXPECT_EQ(on(ranks, arguments + on_all).code, 0);
  EXPECT_TRUE(exists("v_1.vti"));
  EXPECT_FALSE(exists("v_2.vti"));
  EXPECT_TRUE(exists("v_9.vti"));
}

// A piece that cannot take its place leaves the map of before whole.
TEST_F(MapOnRanks, AllPiecesAreWrittenOrNone) {
  const std::string arguments = "map \"$CHUTE\" --spacing 4 --k 20 --quiet --out v.pvti --fields ";
  EXPECT_EQ(on(2, arguments + "vx" + on_all).code, 0);
  const std::string before = read("v_0.vti");
  std::filesystem::remove(folder() / "v_1.vti");
  std::filesystem::create_directory(folder() / "v_1.vti");
  expect_one_message(2, arguments + "vy" + on_all, 3,
                     HasSubstr("rank 1: v_1.vti: only an ordinary"));
  EXPECT_EQ(read("v_0.vti"), before);
}

TEST_F(MapOnRanks, AllSeeTheSameFileAndFolder) {
  std::filesystem::create_directory(folder() / "0");
  std::filesystem::create_directory(folder() / "1");
  const auto map_to = [&](const std::string& out) {
    return each_in_its_folder(
        "map a.csv --fields v --spacing 4 --radius 3 --max-distance none --quiet --out " + out);
  };
  for (const char* name : {"0/a.csv", "1/a.csv"})
    write_rows(name, [&](int i) { return place(i) + ",7," + std::string(name, 1); });
  Outcome outcome = map_to("../v.pvti");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("recon: a.csv: is another file for some ranks"));
  write("1/a.csv", read("0/a.csv"));
  EXPECT_EQ(map_to("../v.pvti").code, 0);
  outcome = map_to("v.pvti");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("v.pvti: of 2 pieces 1 are beside it"));
  for (const char* name : {"0/v.pvti", "0/v_0.vti", "0/v_0.vti.part", "1/v_1.vti"})
    EXPECT_FALSE(exists(name)) << name;
}

// A column that holds text in a part is no field for anybody.
TEST_F(MapOnRanks, AllFieldsAreThoseOfOneProcess) {
  std::string text = "x,y,u,v\n";
  for (int i = 0; i < 1024; ++i)
    text += place(i) + "," + (i == 300 ? "oh" : "1") + "," + std::to_string(i % 3) + "\n";
  write("text.csv", text);
  expect_as_one("text.csv --fields all --spacing 4 --radius 3" + std::string(on_all), {2});
  EXPECT_FALSE(table("one.vti").has("u"));
  expect_failure("map text.csv --fields v --spacing 4 --out v.pvti", 1,
                 HasSubstr("several ranks write pieces"));
}

TEST_F(MapOnRanks, SaysWhatNeedsAllParticlesAtOnce) {
  expect_one_message(2, "map \"$CHUTE\" --fields vx --out v.pvti", 1,
                     HasSubstr("on 2 ranks say also --spacing H, --radius R (or --k K) and "
                               "--max-distance none"));
  const std::string all = "map \"$CHUTE\" --spacing 2 --k 20" + std::string(on_all);
  expect_one_message(2, all + " --fields vx --out v.vti", 1, HasSubstr("one --out FILE.pvti"));
  expect_one_message(2, all + " --fields vx --out v.pvti --picture v.png", 1,
                     HasSubstr("--picture is for one process"));
  expect_one_message(2, all + " --fields density --out v.pvti", 1, HasSubstr("for one process"));
  expect_one_message(2, all + " --fields vq --out v.pvti", 1, HasSubstr("unknown field 'vq'"));
  expect_one_message(2, all + " --fields vx --out nowhere/v.pvti", 3, HasSubstr("nowhere"));
}

TEST_F(MapOnRanks, WhatOneRankFindsWrongEndsAll) {
  write("v.pvti", "of before");
  const std::string how = " --fields v --spacing 4 --radius 3 --out v.pvti" + std::string(on_all);
  expect_one_message(3, "map nowhere.csv" + how, 2, HasSubstr("nowhere.csv"));
  // Line 302 is of the second rank alone.
  write_rows("short.csv", [&](int i) { return place(i) + (i == 300 ? "" : ",7,1"); });
  expect_one_message(2, "map short.csv" + how, 2, HasSubstr("short.csv:302"));
  write_rows("text.csv", [&](int i) { return place(i) + (i == 300 ? ",7,oh" : ",7,1"); });
  expect_one_message(2, "map text.csv" + how, 2,
                     testing::AllOf(HasSubstr("rank 1: "), HasSubstr("row 300 (line 302)")));
  write_rows("text.csv", [&](int i) { return place(i) + (i == 300 ? ",seven,1" : ",7,1"); });
  expect_one_message(2, "map text.csv" + how, 2, HasSubstr("line 302"));
  write_rows("far.csv", [&](int i) { return (i == 300 ? "nan,1" : place(i)) + ",7,1"; });
  expect_one_message(2, "map far.csv" + how, 2, HasSubstr("row 300 (line 302)"));
  // Of the first rank alone.
  write_rows("low.csv", [&](int i) { return place(i) + (i == 600 ? ",7,0" : ",7,1"); });
  expect_one_message(2, "map low.csv --weight-by v" + how, 2,
                     testing::AllOf(HasSubstr("recon: rank 0: "), HasSubstr("row 600 (line 602)")));
  expect_one_message(3, "map low.csv --where 'v > 1'" + how, 1, HasSubstr("is true of none"));
  EXPECT_EQ(read("v.pvti"), "of before");
}

}  // namespace
}  // namespace recon::test
