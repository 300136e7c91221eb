#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>

#include "png.hpp"
#include "recon/core/error.hpp"
#include "recon/io/picture.hpp"
#include "support/nan.hpp"
#include "temporary.hpp"

namespace {

using recon::GridSlice;
using recon::HeatMap;
using recon::HeatMapPanel;
using recon::LinePlot;
using recon::nan;
using recon::StructuredGrid;
using test::bytes_of;
using test::decode_png;
using test::expect_file_error;
using test::expect_invalid;
using test::Image;
using test::TemporaryFolder;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t colours(const Image& image) {
  std::set<std::array<int, 3>> found;
  for (std::size_t y = 0; y < image.height; ++y)
    for (std::size_t x = 0; x < image.width; ++x) found.insert(image.pixel(x, y));
  return found.size();
}

// An area of a colour, not just a pixel that antialiasing gave it.
bool is_area(const Image& image, std::size_t x, std::size_t y, std::array<int, 3> colour) {
  for (std::size_t j = y - 1; j <= y + 1; ++j)
    for (std::size_t i = x - 1; i <= x + 1; ++i)
      if (image.pixel(i, j) != colour) return false;
  return true;
}

// A pixel of a colour: for lines, which may be narrower than an area.
bool has_pixel(const Image& image, std::array<int, 3> colour) {
  for (std::size_t y = 0; y < image.height; ++y)
    for (std::size_t x = 0; x < image.width; ++x)
      if (image.pixel(x, y) == colour) return true;
  return false;
}

HeatMapPanel panel(std::size_t nx, std::size_t ny) {
  HeatMapPanel panel;
  panel.grid = {2, {0, 0, 0}, {1, 1, 1}, {nx, ny, 1}};
  for (std::size_t i = 0; i < nx * ny; ++i) panel.values.push_back(static_cast<double>(i));
  return panel;
}

// Least and greatest columns and rows of the areas of a colour.
struct Span {
  std::size_t left = 100000, right = 0, top = 100000, bottom = 0;
};
Span span_of(const Image& image, std::array<int, 3> colour) {
  Span span;
  for (std::size_t y = 1; y + 1 < image.height; ++y)
    for (std::size_t x = 1; x + 1 < image.width; ++x) {
      if (!is_area(image, x, y, colour)) continue;
      span = {std::min(span.left, x - 1), std::max(span.right, x + 1), std::min(span.top, y - 1),
              std::max(span.bottom, y + 1)};
    }
  return span;
}

bool shows(const Image& image, std::array<int, 3> colour) {
  return span_of(image, colour).right > 0;
}

TEST(Slice, Values) {
  const StructuredGrid<double> grid{3, {1, 2, 3}, {0.1, 0.2, 0.3}, {2, 3, 4}};
  std::vector<double> values;
  for (std::size_t n = 0; n < grid.size(); ++n) values.push_back(static_cast<double>(n));
  const GridSlice y = recon::slice(grid, values, 1, 2);
  EXPECT_EQ(y.grid.dimension, 2);
  EXPECT_EQ(y.grid.origin, (std::array<double, 3>{1, 3, 0}));
  EXPECT_EQ(y.grid.spacing, (std::array<double, 3>{0.1, 0.3, 1}));
  EXPECT_EQ(y.grid.counts, (std::array<std::size_t, 3>{2, 4, 1}));
  EXPECT_EQ(y.values, (std::vector<double>{4, 5, 10, 11, 16, 17, 22, 23}));
  const GridSlice line = recon::slice(y.grid, y.values, 0, 1);
  EXPECT_EQ(line.grid.dimension, 1);
  EXPECT_EQ(line.values, (std::vector<double>{5, 11, 17, 23}));
  expect_invalid([&] { recon::slice(grid, values, 3, 0); }, "axis of the slice = 3");
  expect_invalid([&] { recon::slice(grid, values, 1, 3); }, "index of the slice = 3");
  expect_invalid([&] { recon::slice(line.grid, line.values, 0, 0); }, "at least 2");
  values.pop_back();
  expect_invalid([&] { recon::slice(grid, values, 1, 0); }, "number of values = 23");
}

TEST(HeatMap, EndsOfTheColourMapStandWhereTheValuesAre) {
  const TemporaryFolder folder;
  HeatMap map;
  map.panels = {panel(4, 2)};
  map.colour_range = {{0, 7}};
  recon::draw(folder / "a.png", map);
  const Image image = decode_png(bytes_of(folder / "a.png"));
  EXPECT_GT(image.width, 400u);
  EXPECT_GT(image.height, 200u);
  // The first node is at the lower left, the last at the upper right of a map of 4 by 2 squares.
  const Span dark = span_of(image, {0x44, 0x01, 0x54});
  EXPECT_LT(dark.left, image.width / 4);
  EXPECT_GT(dark.bottom, image.height / 2);
  EXPECT_TRUE(shows(image, {0xfd, 0xe7, 0x25}));
}

TEST(HeatMap, NanIsGreyAndOthersKeepTheirPlace) {
  const TemporaryFolder folder;
  constexpr std::array grey{0xd4, 0xd4, 0xd4};
  HeatMap map;
  map.panels = {panel(10, 10)};
  recon::draw(folder / "full.png", map);
  const Image full = decode_png(bytes_of(folder / "full.png"));
  EXPECT_FALSE(shows(full, grey));
  for (const std::size_t hole :
       {std::size_t{0}, std::size_t{9}, std::size_t{45}, std::size_t{99}}) {
    HeatMap holed = map;
    holed.colour_range = {{0, 99}};
    holed.panels[0].values[hole] = nan;
    recon::draw(folder / "hole.png", holed);
    const Image image = decode_png(bytes_of(folder / "hole.png"));
    const Span span = span_of(image, grey);
    const double cell = static_cast<double>(span.right - span.left + 1);
    EXPECT_NEAR(cell, 56, 2) << "node " << hole;  // of 560 pixels for ten nodes
    EXPECT_NEAR(static_cast<double>(span.bottom - span.top + 1), 56, 2);
    // Outside of the hole nothing has changed.
    for (std::size_t y = 40; y < 590; y += 13)
      for (std::size_t x = 85; x < 640; x += 13) {
        const bool inside =
            x + 2 >= span.left && x <= span.right + 2 && y + 2 >= span.top && y <= span.bottom + 2;
        if (inside) continue;
        ASSERT_EQ(image.pixel(x, y), full.pixel(x, y)) << x << ' ' << y;
      }
  }
}

TEST(HeatMap, ManyPanelsOddShapesAndDots) {
  const TemporaryFolder folder;
  HeatMap map;
  map.panels = {panel(8, 6), panel(3, 1), panel(1, 1)};
  map.panels[0].title =
      "a_b {/Symbol c} 'd' `touch " + (folder / "pwned").string() + "` \" @x\n&<>";
  map.panels[1].title = "b";
  map.title = "all $(true) \\";
  map.panels[0].dots = {{1, 1}, {2, 3.5}};
  map.panels[2].title = map.x_label = "d'a''b";
  recon::draw(folder / "a.png", map);
  map.columns = 2;
  map.scale = 2;
  recon::draw(folder / "b.png", map);
  EXPECT_GT(colours(decode_png(bytes_of(folder / "a.png"))), 20u);
  EXPECT_GT(colours(decode_png(bytes_of(folder / "b.png"))), 20u);
  EXPECT_EQ(folder.entries(), 2u);
}

TEST(HeatMap, ConstantAndEmptyFields) {
  const TemporaryFolder folder;
  for (const double value : {0.0, 5.0, -1e300, 1e-300, 1e-30, nan}) {
    HeatMap map;
    map.panels = {panel(3, 3)};
    for (double& each : map.panels[0].values) each = value;
    map.panels[0].values[3] = std::nextafter(value, infinity);
    recon::draw(folder / "a.png", map);
    EXPECT_GT(colours(decode_png(bytes_of(folder / "a.png"))), 5u);
  }
}

// One node of a hundred is far away: the colours are those of the others, and the picture says so.
TEST(HeatMap, OutliersDoNotSpoilTheColours) {
  const TemporaryFolder folder;
  HeatMap map;
  map.panels = {panel(10, 10)};
  EXPECT_EQ(recon::colour_scale(map).range, (recon::Range{0, 99}));
  EXPECT_EQ(recon::describe_beyond(recon::colour_scale(map)), "");
  recon::draw(folder / "plain.png", map);
  map.panels[0].values[57] = 1e6;
  recon::ColourScale scale = recon::colour_scale(map);
  EXPECT_EQ(scale.range, (recon::Range{0, 99}));
  EXPECT_EQ(scale.above, 1u);
  EXPECT_EQ(scale.below, 0u);
  EXPECT_EQ(recon::describe_beyond(scale), "beyond the colours: 1 node above, up to 1e+06");
  recon::draw(folder / "spoilt.png", map);
  const Image plain = decode_png(bytes_of(folder / "plain.png"));
  const Image image = decode_png(bytes_of(folder / "spoilt.png"));
  EXPECT_GT(image.height, plain.height);      // a line of text
  for (std::size_t y = 40; y < 240; y += 13)  // above the row of the outlier
    for (std::size_t x = 85; x < 640; x += 13)
      ASSERT_EQ(image.pixel(x, y), plain.pixel(x, y)) << x << ' ' << y;
  map.panels[0].values[3] = -1e3;
  scale = recon::colour_scale(map);
  EXPECT_EQ(recon::describe_beyond(scale),
            "beyond the colours: 1 node above, up to 1e+06; 1 node below, down to -1000");
  map.colour_range = {{-1e3, 1e6}};
  EXPECT_EQ(recon::describe_beyond(recon::colour_scale(map)), "");
}

// What is no outlier: the ends of a normal distribution, and what differs from a constant.
TEST(HeatMap, WhatIsNoOutlier) {
  HeatMap map;
  map.panels = {panel(100, 100)};
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (double& value : map.panels[0].values) value = normal(random);
  EXPECT_EQ(recon::describe_beyond(recon::colour_scale(map)), "");
  for (double& value : map.panels[0].values) value = 2;
  map.panels[0].values[17] = 3;
  EXPECT_EQ(recon::colour_scale(map).range, (recon::Range{2, 3}));
  map.panels = {panel(19, 1)};
  map.panels[0].values[3] = 1e6;
  EXPECT_EQ(recon::describe_beyond(recon::colour_scale(map)), "");
}

TEST(HeatMap, OneDimensionIsDrawnAsCurves) {
  const TemporaryFolder folder;
  HeatMap map;
  map.panels.resize(1);
  map.panels[0].grid = {1, {0, 0, 0}, {1, 1, 1}, {3, 1, 1}};
  map.panels[0].values = {1, 4, 2};
  recon::draw(folder / "a.png", map);
  EXPECT_TRUE(has_pixel(decode_png(bytes_of(folder / "a.png")), {0x00, 0x72, 0xb2}));
}

TEST(HeatMap, WrongInput) {
  const TemporaryFolder folder;
  const auto expect = [&](const HeatMap& map, const std::string& part) {
    expect_invalid([&] { recon::draw(folder / "a.png", map); }, part);
  };
  HeatMap map;
  expect(map, "panels");
  map.panels = {panel(3, 3)};
  map.panels[0].values.pop_back();
  expect(map, "number of values of a heat map = 8");
  map.panels[0].values.push_back(infinity);
  expect(map, "= inf");
  map.panels = {panel(3, 3)};
  map.panels[0].dots = {{nan, 1}};
  expect(map, "coordinate of a dot = nan");
  map.panels = {panel(3, 3)};
  map.panels[0].values[0] = -1e308;
  map.panels[0].values[1] = 1e308;
  expect(map, "colour range");
  map.panels = {panel(3, 3)};
  map.colour_range = {{1, 1}};
  expect(map, "colour range");
  map.colour_range.reset();
  map.x_range = {{nan, 1}};
  expect(map, "x range");
  map.x_range.reset();
  map.scale = 0;
  expect(map, "scale");
  map.scale = 1;
  map.panels[0].grid = {3, {}, {1, 1, 1}, {3, 3, 1}};
  expect(map, "slice()");
  EXPECT_EQ(folder.entries(), 0u);
}

LinePlot convergence() {
  LinePlot plot;
  plot.log_x = plot.log_y = true;
  plot.reference_slope = 2;
  plot.title = "error of u_h";
  plot.curves = {
      {"degree 1", {0.1, 0.05, 0.025}, {1e-2, 2.4e-3, 6e-4}, recon::CurveStyle::line_and_markers},
      {"degree 2", {0.1, 0.05, 0.025}, {1e-3, nan, 1e-5}, recon::CurveStyle::markers}};
  return plot;
}

TEST(LinePlot, DrawsCurves) {
  const TemporaryFolder folder;
  recon::draw(folder / "a.png", convergence());
  const Image image = decode_png(bytes_of(folder / "a.png"));
  EXPECT_EQ(image.width, 960u);
  EXPECT_EQ(image.height, 600u);
  EXPECT_TRUE(shows(image, {0x00, 0x72, 0xb2}));
  EXPECT_TRUE(shows(image, {0xd5, 0x5e, 0x00}));
}

TEST(LinePlot, Svg) {
  const TemporaryFolder folder;
  recon::draw(folder / "a.svg", convergence());
  const std::string text = bytes_of(folder / "a.svg");
  EXPECT_TRUE(text.starts_with("<?xml"));
  EXPECT_NE(text.find("degree 2"), std::string::npos);
  EXPECT_NE(text.find("u_h"), std::string::npos);
  LinePlot quotes = convergence();
  quotes.title = quotes.curves[0].name = "d'a''b";
  quotes.curves[1].name = "1.5\\`77@8\\91_{2}^3 -0.25";
  recon::draw(folder / "a.svg", quotes);
  EXPECT_NE(bytes_of(folder / "a.svg").find("d'a''b"), std::string::npos);
  EXPECT_NE(bytes_of(folder / "a.svg").find(quotes.curves[1].name), std::string::npos);
  HeatMap map;
  map.panels = {panel(3, 3)};
  recon::draw(folder / "b.svg", map);
  EXPECT_NE(bytes_of(folder / "b.svg").find("data:image/png;base64"), std::string::npos);
  EXPECT_EQ(folder.entries(), 2u);
}

std::size_t pixels(const Image& image, std::array<int, 3> colour, std::size_t left,
                   std::size_t right) {
  std::size_t count = 0;
  for (std::size_t y = 0; y < image.height; ++y)
    for (std::size_t x = left; x < right; ++x) count += image.pixel(x, y) == colour ? 1 : 0;
  return count;
}

constexpr std::array<int, 3> blue{0x00, 0x72, 0xb2}, vermilion{0xd5, 0x5e, 0x00},
    green{0x00, 0x9e, 0x73};

LinePlot three_times_the_same(recon::CurveStyle style, std::size_t points) {
  LinePlot plot;
  for (const char* name : {"a", "b", "c"}) {
    recon::Curve curve{name, {}, {}, style};
    for (std::size_t i = 0; i < points; ++i) {
      curve.x.push_back(static_cast<double>(i));
      curve.y.push_back(std::sin(0.1 * curve.x.back()));
    }
    plot.curves.push_back(curve);
  }
  return plot;
}

TEST(LinePlot, CurvesThatCoincideShow) {
  const TemporaryFolder folder;
  for (const auto style : {recon::CurveStyle::line, recon::CurveStyle::line_and_markers})
    for (const std::size_t points : {std::size_t{12}, std::size_t{200}}) {
      recon::draw(folder / "a.png", three_times_the_same(style, points));
      const Image image = decode_png(bytes_of(folder / "a.png"));
      for (const auto& colour : {blue, vermilion, green})  // left of the legend
        EXPECT_GT(pixels(image, colour, 100, 760), 20u) << points;
    }
}

// Between its parts a curve leaves nothing, on either axis; a point by itself is shown.
TEST(LinePlot, GapsAreGaps) {
  const TemporaryFolder folder;
  LinePlot plot;
  plot.x_range = {{0, 10}};
  plot.y_range = {{0, 10}};
  for (const bool x : {false, true}) {
    recon::Curve curve{"", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, {}, recon::CurveStyle::line};
    curve.y = curve.x;
    for (const std::size_t i : {3u, 4u, 6u, 7u}) (x ? curve.x : curve.y)[i] = nan;
    plot.curves = {curve};
    recon::draw(folder / "a.png", plot);
    const Image image = decode_png(bytes_of(folder / "a.png"));
    const auto shown = [&](double from, double to) {
      const double left = 90, right = 900;  // roughly what the axis spans
      return pixels(image, blue, static_cast<std::size_t>(left + from * (right - left) / 10),
                    static_cast<std::size_t>(left + to * (right - left) / 10));
    };
    EXPECT_GT(shown(0, 1.7), 20u);
    EXPECT_EQ(shown(2.5, 4.4), 0u);
    EXPECT_GT(shown(4.5, 5.5), 5u);
    EXPECT_EQ(shown(5.6, 7.4), 0u);
    EXPECT_GT(shown(8.3, 10), 20u);
  }
  for (double& y : plot.curves[0].y) y = nan;
  recon::draw(folder / "a.png", plot);  // a curve without any point
}

// On a logarithmic axis that begins anywhere a label stands where its number is.
TEST(LinePlot, LabelsOfDecadesStandWhereTheyBelong) {
  const TemporaryFolder folder;
  LinePlot plot;
  plot.log_x = true;
  plot.curves = {
      {"a", {70, 100, 1000, 5578}, {1, 2, 3, 4}, recon::CurveStyle::markers, {"", "", "here", ""}}};
  recon::draw(folder / "a.svg", plot);
  const std::string text = bytes_of(folder / "a.svg");
  const auto place_before = [&](const std::string& what, std::size_t begin) {
    const std::size_t at = text.find(what, begin), place = text.rfind("translate(", at);
    EXPECT_NE(at, std::string::npos) << what;
    return std::atof(text.c_str() + place + std::string("translate(").size());
  };
  std::size_t marker = text.find("<use xlink:href='#gpPt6' transform");
  std::vector<double> markers;
  for (; marker != std::string::npos;
       marker = text.find("<use xlink:href='#gpPt6' transform", marker + 1))
    markers.push_back(std::atof(text.c_str() + text.find("translate(", marker) + 10));
  ASSERT_GE(markers.size(), 4u);
  EXPECT_NEAR(place_before("dy=\"-6.00px\">2<", 0), markers[1], 0.02);
  EXPECT_NEAR(place_before("dy=\"-6.00px\">3<", 0), markers[2], 0.02);
  EXPECT_NE(text.find("here"), std::string::npos);
  plot.curves[0].labels.pop_back();
  expect_invalid([&] { recon::draw(folder / "b.svg", plot); }, "labels");
}

TEST(LinePlot, WrongInput) {
  const TemporaryFolder folder;
  const auto expect = [&](const LinePlot& plot, const std::string& part) {
    expect_invalid([&] { recon::draw(folder / "a.png", plot); }, part);
  };
  expect(LinePlot{}, "curves");
  LinePlot plot = convergence();
  plot.curves[1].y[2] = 0;
  expect(plot, "y of curve 'degree 2' = 0: must be positive on a logarithmic axis");
  plot = convergence();
  plot.curves[0].x[0] = infinity;
  expect(plot, "x of curve 'degree 1' = inf");
  plot = convergence();
  plot.curves[0].x.pop_back();
  expect(plot, "number of y values");
  plot = convergence();
  plot.log_y = false;
  expect(plot, "reference slope");
  plot = convergence();
  plot.y_range = {{-1, 1}};
  expect(plot, "must be positive on a logarithmic axis");
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(Picture, Extensions) {
  const TemporaryFolder folder;
  expect_file_error([&] { recon::draw(folder / "a.jpg", convergence()); }, 0, ".png or .svg");
  expect_file_error([&] { recon::draw(folder / "a", convergence()); }, 0, ".png or .svg");
  expect_file_error([&] { recon::draw(folder.path() / "none" / "a.png", convergence()); }, 0,
                    "there is no directory");
}

// While it lives, PATH is another one.
class OtherPath {
 public:
  explicit OtherPath(const std::string& path) : old_(std::getenv("PATH")) {
    setenv("PATH", path.c_str(), 1);
  }
  ~OtherPath() { setenv("PATH", old_.c_str(), 1); }

 private:
  std::string old_;
};

TEST(Picture, WithoutGnuplot) {
  const TemporaryFolder folder, empty;
  folder.file("a.png", "old");
  const OtherPath path(empty.path().string());
  expect_file_error([&] { recon::draw(folder / "a.png", convergence()); }, 0,
                    "apt-get install gnuplot-nox");
  EXPECT_EQ(bytes_of(folder / "a.png"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(Picture, GnuplotFails) {
  const TemporaryFolder folder, programs;
  const auto program = [&](const std::string& script) {
    std::filesystem::permissions(programs.file("gnuplot", "#!/bin/sh\n" + script),
                                 std::filesystem::perms::owner_all);
  };
  folder.file("a.png", "old");
  const OtherPath path(programs.path().string());
  program("echo no such font >&2; exit 3\n");
  expect_file_error([&] { recon::draw(folder / "a.png", convergence()); }, 0, "no such font");
  program("printf '\\211PNG\\r\\n\\032\\n half'\n");
  expect_file_error([&] { recon::draw(folder / "a.png", convergence()); }, 0, "incomplete picture");
  program("kill -9 $$\n");
  expect_file_error([&] { recon::draw(folder / "a.png", convergence()); }, 0, "gnuplot failed");
  EXPECT_EQ(bytes_of(folder / "a.png"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
