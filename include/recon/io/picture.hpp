// Pictures of results: heat maps of fields on grids, and curves, as PNG or (extension .svg) SVG.
//
// gnuplot draws them, as a program of its own (Debian: apt-get install gnuplot-nox): it is found on
// PATH, gets its script on the standard input and never sees a file name or a shell. Texts are
// shown letter by letter, whatever they contain. A picture appears complete or not at all
// (atomic_file.hpp).
//
// ```cpp
//   recon::HeatMap map;
//   map.panels.push_back({.title = "density", .grid = grid, .values = nodal_density});
//   map.colour_label = "density / (kg/m^3)";
//   recon::draw("density.png", map);
// ```
//
// HeatMap. Each node of a 2-D grid is a rectangle of one spacing around it, coloured along viridis
// (perceptually uniform, readable without red-green vision, grey in print); NaN is grey. Equal
// lengths on both axes where the shape allows (between 1 : 12 and 12 : 1). All panels share axis
// ranges and colour range. A few outliers do not spoil the colours: the scale leaves them out, and
// the picture says how many lie beyond it and how far. A map of 1-D grids is drawn as curves; of a
// 3-D grid take a slice() first.
//
// LinePlot. Curves of (x, y); a NaN in x or y interrupts a curve. Curves that coincide can be told
// apart: each has dashes of its own over the ones before it, and where there are many points only
// some are marked, on each curve others. On a log axis all numbers must be positive.
//
// Wrong input throws InvalidArgument (sizes that disagree, infinite values, no panel or curve, a
// number that is not positive on a log axis); an unknown extension, a gnuplot that is missing or
// fails (with what it said), and trouble with the file throw FileError.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "recon/io/error.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon {

// Part of a grid, with one dimension less, and the values of a one-component field at its nodes.
struct GridSlice {
  StructuredGrid<double> grid;
  std::vector<double> values;
};

// Takes the nodes of `grid` whose index along `axis` is `index`. The remaining axes keep their
// order: the slice of an x-y-z grid normal to y has the axes x and z.
GridSlice slice(const StructuredGrid<double>& grid, std::span<const double> values, int axis,
                std::size_t index);

using Range = std::array<double, 2>;  // lower < upper

struct HeatMapPanel {
  std::string title;
  StructuredGrid<double> grid;              // 2-D (or 1-D, see the top)
  std::vector<double> values;               // one per node; NaN: no value there
  std::vector<std::array<double, 2>> dots;  // drawn on top, for example the particles
};

struct HeatMap {
  std::string title;
  std::vector<HeatMapPanel> panels;
  std::string x_label = "x", y_label = "y", colour_label;
  std::optional<Range> x_range, y_range;  // default: what the grids cover
  std::optional<Range> colour_range;      // default: see colour_scale(); beyond: the end colours
  int columns = 0;                        // panels in a row; 0: all, or one where panels are wide
  double scale = 1;                       // of the whole picture, texts included
};

// What the colours of a heat map stand for.
struct ColourScale {
  Range range{0, 1};
  std::size_t below = 0, above = 0;  // values beyond the range
  double least = 0, greatest = 0;    // of all values
};

// The scale of colour_range or, without one, of the values that are no outliers. For these the
// hundredth part of the values at either end (at least one value) is set aside; the rest has a
// width, and a value that is more than that width away from the rest is an outlier. Fewer than 20
// values, and values of which nearly all are the same, have no outliers. (Of a normal distribution
// none in a million is one.)
ColourScale colour_scale(const HeatMap& map);
// A sentence for the reader: "beyond the colours: 3 nodes above, up to 6.7; 1 below, down to -2";
// empty where no value is beyond.
std::string describe_beyond(const ColourScale& scale);

enum class CurveStyle { line, markers, line_and_markers };

struct Curve {
  std::string name;  // in the legend; none if empty
  std::vector<double> x, y;
  CurveStyle style = CurveStyle::line_and_markers;
  std::vector<std::string> labels{};  // beside the points, one for each; or none
};

struct LinePlot {
  std::string title;
  std::vector<Curve> curves;
  std::string x_label = "x", y_label = "y";
  bool log_x = false, log_y = false;
  std::optional<Range> x_range, y_range;  // default: what the curves cover, and a margin
  // Draws a dashed line y ~ x^slope below the first curve, to compare with; both axes must
  // be logarithmic.
  std::optional<double> reference_slope;
  double scale = 1;
};

void draw(const std::filesystem::path& path, const HeatMap& map);
void draw(const std::filesystem::path& path, const LinePlot& plot);

// Throws the FileError of draw() for an extension other than .png and .svg, before
// anything is drawn.
void require_picture_extension(const std::filesystem::path& path);

}  // namespace recon
