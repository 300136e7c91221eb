#include "recon/fields/particle_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "recon/core/error.hpp"
#include "support/nan.hpp"

namespace {

using recon::Box;
using recon::nan;
using recon::ParticleTable;
using testing::ElementsAre;
using testing::HasSubstr;

std::string message(const std::function<void()>& call) {
  try {
    call();
  } catch (const recon::InvalidArgument& error) {
    return error.what();
  }
  return "no exception";
}

ParticleTable cube() {
  ParticleTable table;
  table.add_column("id", {11, 12, 13});
  table.add_column("x", {0, 1, 2});
  table.add_column("y", {3, 4, 5});
  table.add_column("z", {6, 7, 8});
  table.add_column("vx", {1, nan, 2});
  table.source = "test";
  return table;
}

TEST(ParticleTable, Columns) {
  const ParticleTable table = cube();
  EXPECT_EQ(table.size(), 3u);
  EXPECT_TRUE(table.has("vx"));
  EXPECT_THAT(table.column("y"), ElementsAre(3, 4, 5));
  EXPECT_THAT(message([&] { table.column("vz"); }), HasSubstr("did you mean 'z' or 'vx'?"));
  EXPECT_THAT(message([&] { table.column("temperature"); }), HasSubstr("valid: id, x, y, z, vx"));
  EXPECT_THAT(message([&] { ParticleTable().column("x"); }), HasSubstr("no columns"));
}

TEST(ParticleTable, WrongColumns) {
  ParticleTable table = cube();
  EXPECT_THAT(message([&] { table.add_column("x", {1, 2, 3}); }), HasSubstr("only once"));
  EXPECT_THAT(message([&] { table.add_column("", {1, 2, 3}); }), HasSubstr("empty"));
  EXPECT_THAT(message([&] { table.add_column("w", {1}); }), HasSubstr("of the other columns, 3"));
}

TEST(ParticleTable, NanIsNeverHandedOut) {
  ParticleTable table = cube();
  table.set_lines({4, 5, 9});
  EXPECT_THAT(message([&] { table.column("vx"); }),
              HasSubstr("column vx, row 1 (id 12, line 5) of test = nan"));
  EXPECT_THAT(message([&] { table.field("v", {"x", "vx"}); }), HasSubstr("row 1 (id 12"));
  table.set_coordinates({"x", "vx"});
  EXPECT_THAT(message([&] { table.positions(); }), HasSubstr("column vx, row 1"));
  EXPECT_EQ(table.raw_column("vx")[2], 2);
}

TEST(ParticleTable, FieldOfColumns) {
  const auto field = cube().field("p", {"z", "x"});
  EXPECT_EQ(field.components, 2);
  EXPECT_THAT(field.values, ElementsAre(6, 0, 7, 1, 8, 2));
}

TEST(ParticleTable, Dimensions) {
  ParticleTable table = cube();
  EXPECT_EQ(table.dimension(), 3);
  EXPECT_EQ(table.positions()(2, 2), 8);
  EXPECT_EQ(table.positions(1).dimension(), 1);
  EXPECT_THAT(message([&] { table.positions(4); }), HasSubstr("dimension = 4"));
  ParticleTable line;
  line.add_column("xu", {1, 2});
  EXPECT_EQ(line.dimension(), 1);
  EXPECT_THAT(message([&] { line.positions(2); }), HasSubstr("must not exceed"));
  ParticleTable flat = line;
  flat.add_column("y", {1, 1});
  EXPECT_EQ(flat.dimension(), 1);
  EXPECT_EQ(flat.positions(2).dimension(), 2);
  flat.add_column("z", {0.5, 0.75});
  EXPECT_EQ(flat.dimension(), 2);
  EXPECT_THAT(flat.coordinates(), ElementsAre("xu", "z"));
  EXPECT_THAT(flat.axes(), ElementsAre(0, 2));
  EXPECT_EQ(flat.positions()(1, 1), 0.75);
  EXPECT_EQ(flat.positions(3).dimension(), 3);
  EXPECT_THAT(flat.coordinates(3), ElementsAre("xu", "y", "z"));
  EXPECT_THAT(flat.all_coordinates(), ElementsAre("xu", "y", "z"));
}

// Whichever coordinate is constant, the others count; where all are, all do.
TEST(ParticleTable, AConstantCoordinateCountsAsNone) {
  for (int constants = 0; constants < 8; ++constants) {
    ParticleTable table;
    std::vector<std::string> varying;
    std::vector<int> axes;
    for (int d = 0; d < 3; ++d) {
      const std::string name(1, "xyz"[d]);
      const bool constant = (constants >> d & 1) == 1;
      table.add_column(name, {2, 2, constant ? 2.0 : 3.0});
      if (constant && constants < 7) continue;
      varying.push_back(name);
      axes.push_back(d);
    }
    EXPECT_EQ(table.coordinates(), varying) << constants;
    EXPECT_EQ(table.axes(), axes) << constants;
    EXPECT_EQ(table.dimension(), static_cast<int>(axes.size())) << constants;
  }
}

TEST(ParticleTable, AxesByNameOrByPlace) {
  ParticleTable table;
  for (const char* name : {"lon", "x", "y", "zu"}) table.add_column(name, {1, 2});
  const auto axes = [&](std::vector<std::string> columns) {
    table.set_coordinates(std::move(columns));
    return table.axes();
  };
  EXPECT_THAT(axes({"x", "zu"}), ElementsAre(0, 2));
  EXPECT_THAT(axes({"zu", "x"}), ElementsAre(2, 0));
  EXPECT_THAT(axes({"lon", "x"}), ElementsAre(0, 1));
  EXPECT_THAT(axes({"lon", "zu"}), ElementsAre(0, 2));
}

TEST(ParticleTable, KeepsRows) {
  ParticleTable table = cube();
  table.set_lines({5, 6, 7});
  table.keep_rows({false, true, true});
  EXPECT_EQ(table.size(), 2u);
  EXPECT_THAT(table.column("x"), ElementsAre(1, 2));
  EXPECT_EQ(table.describe_row(1), "row 2 (id 13, line 7)");
  EXPECT_THAT(message([&] { table.keep_rows({true}); }), HasSubstr("number of rows"));
  table.keep_rows({false, false});
  EXPECT_EQ(table.size(), 0u);
}

TEST(ParticleTable, OneParticleKeepsItsZ) {
  ParticleTable table;
  for (const char* name : {"x", "y", "z"}) table.add_column(name, {1});
  EXPECT_EQ(table.dimension(), 3);
}

TEST(ParticleTable, MissingCoordinates) {
  ParticleTable table;
  table.add_column("r", {1});
  EXPECT_THAT(message([&] { table.positions(); }), HasSubstr("coordinate column x = not found"));
  EXPECT_THAT(message([&] { table.set_coordinates({"q"}); }), HasSubstr("column = q"));
  EXPECT_THAT(message([&] { table.set_coordinates({}); }), HasSubstr("must be 1, 2 or 3"));
  EXPECT_THAT(message([&] { table.set_coordinates({"r", "r"}); }), HasSubstr("only once"));
  table.set_coordinates({"r"});
  EXPECT_EQ(table.positions()(0, 0), 1);
  ParticleTable gap;
  gap.add_column("y", {1});
  gap.add_column("z", {1});
  EXPECT_THAT(gap.coordinates(), ElementsAre("y", "z"));
}

TEST(ParticleTable, BoxFollowsTheCoordinates) {
  ParticleTable table = cube();
  EXPECT_FALSE(table.has_box());
  EXPECT_EQ(table.box().upper[2], 8);  // of the particles
  EXPECT_FALSE(table.domain().any());
  table.set_box(Box<double>{{0, 10, 20}, {5, 15, 30}, 3}, {false, false, true});
  table.set_coordinates({"x", "z"});
  EXPECT_EQ(table.box().dimension, 2);
  EXPECT_EQ(table.box().lower[1], 20);
  EXPECT_EQ(table.domain().periodic, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(table.domain().period(1), 10);
  EXPECT_NO_THROW(table.domain().validate(2));
}

TEST(ParticleTable, WrongBoxes) {
  ParticleTable table = cube();
  const auto set = [&](Box<double> box, std::array<bool, 3> periodic) {
    return message([&] { table.set_box(box, periodic); });
  };
  EXPECT_THAT(set({{0, 0, 0}, {1, -1, 1}, 3}, {}), HasSubstr("extent"));
  EXPECT_THAT(set({{0, 0, 0}, {1, nan, 1}, 3}, {}), HasSubstr("extent"));
  EXPECT_THAT(set({{0, 0, 0}, {1, 0, 1}, 3}, {false, true, false}), HasSubstr("period"));
  EXPECT_FALSE(table.has_box());
}

TEST(ParticleTable, ViewsSurviveAMove) {
  ParticleTable table = cube();
  const auto points = table.positions();
  const ParticleTable moved = std::move(table);
  EXPECT_EQ(&moved.column("x")[0], &moved.raw_column("x")[0]);
  EXPECT_EQ(points(1, 1), 4);
}

recon::TextCells texts(const std::vector<std::pair<std::uint32_t, std::string>>& cells) {
  recon::TextCells all;
  for (const auto& [row, text] : cells) all.add(row, text);
  return all;
}

TEST(ParticleTable, ColumnsAreTypedWhenTheyAreUsed) {
  ParticleTable table;
  table.add_read_columns({{"id", {7, 8, 9}, {}},
                          {"x", {1, 2, 3}, {}},
                          {"v", {1, nan, 3}, texts({{1, "n/a"}})},
                          {"p", {nan, 5, 6}, texts({{0, ""}})},
                          {"element", {nan, nan, nan}, texts({{0, "Fe"}, {1, "O"}, {2, "Fe"}})},
                          {"n", {1, 1, 1}, {}},
                          {"n", {2, 2, 2}, {}},
                          {"big", {1, 2, nan}, texts({{2, "1e999"}})}});
  table.set_lines({10, 11, 12});
  table.source = "a.csv";
  EXPECT_THAT(table.names(), ElementsAre("id", "x", "p"));
  EXPECT_THAT(table.text_columns(), ElementsAre("v", "element", "big"));
  EXPECT_THAT(table.repeated_names(), ElementsAre("n"));
  EXPECT_TRUE(table.has("v") && table.has("n") && table.has("element") && !table.has("y"));
  EXPECT_THAT(table.positions().size(), 3u);
  EXPECT_THAT(message([&] { table.column("v"); }),
              HasSubstr("column v, row 1 (id 8, line 11) of a.csv = 'n/a': is not a number"));
  EXPECT_THAT(message([&] { table.column("p"); }),
              HasSubstr("column p, row 0 (id 7, line 10) of a.csv = '': is an empty cell"));
  EXPECT_THAT(message([&] { table.field("f", {"x", "element"}); }), HasSubstr("'Fe'"));
  EXPECT_THAT(message([&] { table.column("big"); }), HasSubstr("no number that double can hold"));
  EXPECT_THAT(message([&] { table.column("n"); }),
              HasSubstr("column = n: is the name of several columns of a.csv (numbers 6, 7)"));
  EXPECT_THAT(message([&] { table.add_column("n", {1, 2, 3}); }), HasSubstr("only once"));
}

TEST(ParticleTable, KeptRows) {
  ParticleTable table;
  table.add_read_columns(
      {{"x", {0, 1, 2, 3, 4}, {}}, {"v", {1, nan, 3, nan, 5}, texts({{1, "a"}, {3, "b"}})}});
  table.set_lines({2, 3, 4, 5, 6});
  table.declare_missing("4");
  table.keep_rows({true, false, true, true, true});
  EXPECT_THAT(table.raw_column("x"), testing::ElementsAre(0, 2, 3, testing::IsNan()));
  EXPECT_THAT(message([&] { table.column("v"); }), HasSubstr("row 3 (line 5) = 'b'"));
  EXPECT_THAT(message([&] { table.column("x"); }), HasSubstr("row 4 (line 6) = missing"));
  table.keep_rows({true, true, false, true});
  EXPECT_THAT(table.column("v"), ElementsAre(1, 3, 5));
  EXPECT_THAT(table.names(), ElementsAre("x", "v"));
  EXPECT_EQ(table.leave_out_missing({"x", "v"}), 1u);
  EXPECT_THAT(table.column("x"), ElementsAre(0, 2));
  EXPECT_THAT(message([&] { table.keep_rows({true}); }), HasSubstr("number of rows"));
}

TEST(ParticleTable, MissingValues) {
  const auto make = [] {
    ParticleTable table;
    table.add_read_columns({{"x", {0, 1, 2, 3}, {}},
                            {"v", {-9999, 1, nan, nan}, texts({{2, "NA"}})},
                            {"w", {nan, 1, 1, -9999.0}, texts({{0, ""}})}});
    return table;
  };
  ParticleTable table = make();
  EXPECT_EQ(table.leave_out_missing({"v", "w"}), 0u);
  table.declare_missing("NA");
  EXPECT_THAT(table.names(), ElementsAre("x", "v", "w"));
  EXPECT_EQ(table.leave_out_missing({"x", "w"}), 0u);  // w misses nothing yet
  EXPECT_EQ(table.size(), 4u);
  EXPECT_EQ(table.leave_out_missing({"v"}), 1u);
  EXPECT_THAT(table.remarks, ElementsAre("left out, without a value in v: 1 of 4 particles"));
  table.declare_missing("nan");
  table.declare_missing("-9.999e3");
  table.declare_missing("");
  EXPECT_EQ(table.leave_out_missing({"x", "v", "w"}), 2u);
  EXPECT_THAT(table.column("x"), ElementsAre(1));
  EXPECT_THAT(table.remarks.at(1), HasSubstr("without a value in v, w: 2 of 3 particles"));
  table = make();
  table.declare_missing("1");
  EXPECT_THAT(message([&] { table.column("x"); }), HasSubstr("row 1 = missing"));
}

TEST(ParticleTable, TriclinicBoxes) {
  ParticleTable table = cube();
  // b leans along x; a is along x and c along z: periods 4 from -1, and 5 from 0.
  const recon::SimulationCell leaning{{-1, 0, 0}, {{{4, 0, 0}, {-0.5, 3, 0}, {0, 0, 5}}}};
  table.set_cell(leaning, {true, true, false});
  EXPECT_EQ(table.domain().periodic, (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(table.domain().lower[0], -1);
  EXPECT_EQ(table.domain().period(0), 4);
  EXPECT_EQ(table.box().lower, (std::array<double, 3>{-1.5, 0, 0}));
  EXPECT_EQ(table.box().upper, (std::array<double, 3>{3, 3, 5}));
  EXPECT_THAT(table.remarks, ElementsAre(HasSubstr("b = (-0.5, 3, 0)")));
  EXPECT_EQ(table.possible_domain().periodic, (std::array<bool, 3>{true, false, true}));
  EXPECT_EQ(table.why_not_periodic(2), "");
  EXPECT_THAT(table.why_not_periodic(1), HasSubstr("b = (-0.5, 3, 0) is not along the axis"));
  ASSERT_TRUE(table.cell());
  EXPECT_EQ(table.cell()->edges[1][0], -0.5);
  // Edges along the axes, in another order and against them, are no cell of its own.
  ParticleTable turned = cube();
  turned.set_cell({{1, 1, 1}, {{{0, 2, 0}, {-3, 0, 0}, {0, 1e-15, 4}}}}, {true, false, true});
  EXPECT_FALSE(turned.cell());
  EXPECT_EQ(turned.domain().periodic, (std::array<bool, 3>{false, true, true}));
  EXPECT_EQ(turned.box().lower[0], -2);
  EXPECT_TRUE(turned.remarks.empty());
  EXPECT_THAT(message([&] {
                table.set_cell({{}, {{{1, 0, 0}, {}, {0, 0, 1}}}}, {true, true, true});
              }),
              HasSubstr("edge of the simulation cell = 0"));
}

}  // namespace
