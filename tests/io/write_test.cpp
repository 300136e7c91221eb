#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "recon/core/error.hpp"
#include "recon/io/read.hpp"
#include "recon/io/write.hpp"
#include "recon/points/make_view.hpp"
#include "support/nan.hpp"
#include "temporary.hpp"

namespace {

using recon::FieldSet;
using recon::nan;
using recon::NumberType;
using recon::StructuredGrid;
using test::bytes_of;
using test::expect_file_error;
using test::expect_invalid;
using test::TemporaryFolder;

const std::string hostile = "v \"a\" <b> & 'c', ; d";

TEST(WriteCsv, Text) {
  const TemporaryFolder folder;
  const std::vector<double> x{0.1, -2}, y{1e300, 0};
  FieldSet fields;
  fields.add("v", 2, {1, 2, 3, 0.30000000000000004});
  fields.add("s", 3, {1, 2, 3, 4, 5, 6});
  fields.add("rank", 1, {100000, -7}, NumberType::int32);
  fields.add("p", 1, {nan, 0.1}, NumberType::float32);
  recon::write_csv(folder / "a.csv", recon::points_of(x, y), fields);
  EXPECT_EQ(bytes_of(folder / "a.csv"),
            "x,y,v_x,v_y,s_0,s_1,s_2,rank,p\n"
            "0.1,1e+300,1,2,1,2,3,100000,nan\n"
            "-2,0,3,0.30000000000000004,4,5,6,-7,0.1\n");
}

TEST(WriteCsv, ReadsBackBitForBit) {
  const TemporaryFolder folder;
  std::mt19937_64 random(3);
  std::vector<double> x, values;
  while (x.size() < 3000) {
    const double number = std::bit_cast<double>(random());
    if (!std::isfinite(number)) continue;
    x.push_back(number);
    values.push_back(x.size() % 7 == 0 ? nan : -number);
  }
  for (const double edge : {5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, -0.0}) {
    x.push_back(edge);
    values.push_back(edge);
  }
  FieldSet fields;
  fields.add(hostile, 1, values);
  fields.add("12", 1, values);
  fields.add("#c", 1, values);
  fields.add(" blank ", 1, values);
  recon::write_csv(folder / "a.csv", recon::points_of(x), fields);
  const recon::ParticleTable table = recon::read_particles(folder / "a.csv");
  EXPECT_EQ(table.names(), (std::vector<std::string>{"x", hostile, "12", "#c", " blank "}));
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(table.column("x")[i]),
              std::bit_cast<std::uint64_t>(x[i]));
    const double back = table.raw_column(hostile)[i];
    ASSERT_TRUE(std::isnan(values[i]) ? std::isnan(back)
                                      : std::bit_cast<std::uint64_t>(back) ==
                                            std::bit_cast<std::uint64_t>(values[i]));
  }
}

TEST(Write, WrongInputLeavesNothing) {
  const TemporaryFolder folder;
  const std::vector<double> x{0, 1}, bad{0, nan};
  FieldSet fields;
  fields.add("p", 1, {1, 2, 3});
  for (const char* name : {"a.csv", "a.vtp"})
    expect_invalid([&] { recon::write(folder / name, recon::points_of(x), fields); },
                   "number of values of field p = 3");
  for (const char* name : {"a.csv", "a.vtp"})
    expect_invalid([&] { recon::write(folder / name, recon::points_of(bad), FieldSet{}); }, "nan");
  expect_invalid([&] { recon::write_vti(folder / "a.vti", StructuredGrid<double>{}, fields); },
                 "number of values of field p");
  FieldSet clash;
  clash.add("x", 1, {1, 2});
  expect_invalid([&] { recon::write_csv(folder / "a.csv", recon::points_of(x), clash); },
                 "name of a column = x");
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(Write, Extensions) {
  const TemporaryFolder folder;
  const std::vector<double> x{0};
  const StructuredGrid<double> grid;
  const auto points = recon::points_of(x);
  recon::write(folder / "a.VTP", points, {});
  recon::write(folder / "a.vti", grid, {});
  recon::write(folder / "a.csv", points, {});
  recon::write(folder / "b.csv", grid, {});
  EXPECT_EQ(bytes_of(folder / "b.csv"), "x,y,z\n0,0,0\n");
  expect_file_error([&] { recon::write(folder / "a.vtu", points, {}); }, 0, "did you mean '.vtp'?");
  expect_file_error([&] { recon::write(folder / "a.vti", points, {}); }, 0, "is for a grid");
  expect_file_error([&] { recon::write(folder / "a.vtp", grid, {}); }, 0, "is for points");
  expect_file_error([&] { recon::write(folder / "a", grid, {}); }, 0, "no extension");
  EXPECT_EQ(folder.entries(), 4u);
}

TEST(WritePvd, Text) {
  const TemporaryFolder folder;
  recon::write_pvd(folder / "a.pvd", {{0.5, "a_0.vti"}, {1e-7, "b&<>\"'.vti"}});
  EXPECT_EQ(bytes_of(folder / "a.pvd"),
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n"
            "  <Collection>\n"
            "    <DataSet timestep=\"0.5\" part=\"0\" file=\"a_0.vti\"/>\n"
            "    <DataSet timestep=\"1e-07\" part=\"0\" "
            "file=\"b&amp;&lt;&gt;&quot;&apos;.vti\"/>\n"
            "  </Collection>\n</VTKFile>\n");
  expect_invalid([&] { recon::write_pvd(folder / "b.pvd", {{nan, "a.vti"}}); }, "time of a frame");
  expect_invalid([&] { recon::write_pvd(folder / "b.pvd", {{0, "a\n.vti"}}); }, "line breaks");
  expect_invalid([&] { recon::write_pvd(folder / "b.pvd", {{0, "a\xff"}}); }, "UTF-8");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WritePvti, PiecesAreTheWholeGrid) {
  const TemporaryFolder folder;
  const recon::StructuredGrid<double> grid{3, {1, -2, 0.5}, {0.5, 0.25, 2}, {5, 3, 2}};
  const auto value = [](double x, double y, double z) { return x + 10 * y + 100 * z; };
  std::vector<recon::GridPieceFile> files;
  std::vector<int> seen(grid.size(), 0);
  recon::FieldSet fields;
  for (const auto [first, count] : {std::array<std::size_t, 2>{0, 3}, {2, 2}, {3, 2}}) {
    const recon::GridPiece piece{{first, 0, 0}, {count, 3, 2}};
    std::vector<double> values;
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t i = 0; i < count; ++i)
          values.push_back(
              value(grid.coordinate(first + i, 0), grid.coordinate(j, 1), grid.coordinate(k, 2)));
    fields = {};
    fields.add("u", 1, values);
    const std::string name = "piece & " + std::to_string(first) + ".vti";
    recon::write_vti_piece(folder / name, grid, piece, fields);
    files.push_back({piece, name});
    const auto table = recon::read_particles(folder / name);
    const auto x = table.positions(3);
    ASSERT_EQ(table.size(), piece.size());
    for (std::size_t n = 0; n < table.size(); ++n) {
      EXPECT_EQ(table.column("u")[n], value(x(n, 0), x(n, 1), x(n, 2)));
      ++seen[static_cast<std::size_t>(std::lround((x(n, 0) - 1) / 0.5) +
                                      5 * std::lround((x(n, 1) + 2) / 0.25) +
                                      15 * std::lround((x(n, 2) - 0.5) / 2))];
    }
  }
  // The planes 2 and 3 are in two pieces.
  for (std::size_t n = 0; n < seen.size(); ++n)
    EXPECT_EQ(seen[n], n % 5 == 2 || n % 5 == 3 ? 2 : 1);
  recon::write_pvti(folder / "all.pvti", grid, files, fields);
  const std::string text = test::bytes_of(folder / "all.pvti");
  EXPECT_THAT(text, testing::HasSubstr("WholeExtent=\"0 4 0 2 0 1\" Origin=\"1 -2 0.5\""));
  EXPECT_THAT(text,
              testing::HasSubstr("<Piece Extent=\"2 3 0 2 0 1\" Source=\"piece &amp; 2.vti\"/>"));
  EXPECT_THAT(text, testing::HasSubstr("<PDataArray type=\"Float64\" Name=\"u\""));

  fields = {};
  fields.add("u", 1, {1, 2});
  expect_invalid(
      [&] {
        recon::write_vti_piece(folder / "b.vti", grid, {{4, 0, 0}, {2, 1, 1}}, fields);
      },
      "nodes of a piece along axis 0");
  expect_invalid(
      [&] {
        recon::write_vti_piece(folder / "b.vti", grid, {{0, 0, 0}, {1, 1, 0}}, fields);
      },
      "nodes of a piece along axis 2");
  expect_invalid(
      [&] {
        recon::write_vti_piece(folder / "b.vti", grid, {{0, 0, 0}, {3, 1, 1}}, fields);
      },
      "");
  expect_invalid(
      [&] {
        recon::write_pvti(folder / "b.pvti", grid, {{{}, "a\xff"}}, fields);
      },
      "UTF-8");
  EXPECT_FALSE(std::filesystem::exists(folder / "b.vti"));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.pvti"));
}

// Files that vtk_reader_check.py reads with VTK itself and compares with the same formulas; it
// names the folder in RECON_VTK_SAMPLES.
TEST(VtkSamples, Write) {
  const TemporaryFolder own;
  const char* asked = std::getenv("RECON_VTK_SAMPLES");
  const std::filesystem::path folder = asked ? std::filesystem::path(asked) : own.path();

  StructuredGrid<double> grid{3, {-1.5, 0.1, 1e6}, {0.25, 1.0 / 3, 2}, {4, 3, 2}};
  FieldSet fields;
  fields.step = 9007199254740993;  // needs 64-bit integers
  fields.time = 0.1;
  std::vector<double> scalar, vector, tensor, rank, single;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double number = static_cast<double>(i);
    scalar.push_back(i == 5 ? nan : 0.1 * number);
    for (int c = 0; c < 3; ++c) vector.push_back(number + 0.01 * c);
    for (int c = 0; c < 9; ++c) tensor.push_back(-number * c);
    rank.push_back(number - 3);
    single.push_back(0.1 * number);
  }
  fields.add(hostile, 1, scalar);
  fields.add("velocity", 3, vector);
  fields.add("stress", 9, tensor);
  fields.add("rank", 1, rank, NumberType::int32);
  fields.add("single", 1, single, NumberType::float32);
  recon::write_vti(folder / "grid.vti", grid, fields);
  // The same in two pieces.
  std::vector<recon::GridPieceFile> pieces;
  for (const auto [first, count] : {std::array<std::size_t, 2>{0, 3}, {2, 2}}) {
    FieldSet part;
    part.step = fields.step;
    part.time = fields.time;
    for (const recon::NamedField& field : fields) {
      std::vector<double> values;
      for (std::size_t n = 0; n < grid.size(); ++n)
        for (int c = 0; c < field.components && n % 4 >= first && n % 4 < first + count; ++c)
          values.push_back(field.view()(n, c));
      part.add(field.name, field.components, std::move(values), field.type);
    }
    pieces.push_back({{{first, 0, 0}, {count, 3, 2}}, "piece_" + std::to_string(first) + ".vti"});
    recon::write_vti_piece(folder / pieces.back().file, grid, pieces.back().piece, part);
  }
  recon::write_pvti(folder / "grid.pvti", grid, pieces, fields);

  // A rotation about (1.5, 2.125), a tensor, a symmetric one, and four numbers that are none.
  StructuredGrid<double> plane{2, {1, 2, 0}, {0.5, 0.25, 1}, {3, 2, 1}};
  FieldSet plane_fields;
  std::vector<double> turning, slope, stress, four;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const double x = 1 + 0.5 * static_cast<double>(i % 3),
                 y = 2 + 0.25 * static_cast<double>(i / 3);
    const double number = static_cast<double>(i);
    for (const double value : {2.125 - y, x - 1.5}) turning.push_back(value);
    for (const double value : {1.0, 2.0, 3.0, 4.0}) slope.push_back(value * number);
    for (const double value : {1.0, 2.0, 3.0}) stress.push_back(value + number);
    for (const double value : {5.0, 6.0, 7.0, 8.0}) four.push_back(value);
  }
  plane_fields.add("turning", 2, turning);
  plane_fields.add("slope", 4, slope, NumberType::float32);
  plane_fields.add("stress", 3, stress, NumberType::float64, recon::FieldKind::symmetric_tensor);
  plane_fields.add("four", 4, four, NumberType::int32, recon::FieldKind::scalars);
  recon::write_vti(folder / "plane.vti", plane, plane_fields);
  recon::write_vtp(folder / "plane.vtp", plane.nodes().view(), plane_fields);

  const std::vector<double> along{0, 1, 3};
  FieldSet line_fields;
  line_fields.add("u", 1, {0.5, 1, -1}, NumberType::float64, recon::FieldKind::vector);
  line_fields.add("p", 1, {1, 2, 3});
  recon::write_vtp(folder / "line.vtp", recon::points_of(along), line_fields);
  const std::string awkward = "a&b<\"c' \xc2\xb2.vtp";
  recon::write_vtp(folder / awkward, recon::points_of(along), line_fields);
  recon::write_pvd(folder / "series.pvd", {{0, "line.vtp"}, {0.1 + 0.2, awkward}});

  recon::write_vtp(folder / "points.vtp", grid.nodes().view(), fields);
  recon::write_vtp(folder / "none.vtp", recon::PointsView<double>(0, 2, {}, {}), {});
  const std::vector<double> x{1, 2}, y{3, 4};
  recon::write_vtp(folder / "flat.vtp", recon::points_of(x, y), {});
  for (const char* name :
       {"grid.vti", "plane.vti", "points.vtp", "none.vtp", "flat.vtp", "line.vtp"})
    EXPECT_TRUE(bytes_of(folder / name).ends_with("Data>\n</VTKFile>\n")) << name;
}

}  // namespace
