#include "recon/io/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "gnuplot.hpp"
#include "number_text.hpp"
#include "recon/core/names.hpp"

namespace recon {

namespace {

using detail::gnuplot_string;
using detail::join;

// Eleven points of viridis (van der Walt and Smith, 2015), linear in between.
constexpr const char* palette =
    "set palette defined (0 '#440154', 1 '#482475', 2 '#414487', 3 '#355f8d', 4 '#2a788e', "
    "5 '#21918c', 6 '#22a884', 7 '#44bf70', 8 '#7ad151', 9 '#bddf26', 10 '#fde725')\n";

constexpr const char* frame_style =
    "set border 31 linewidth 1 linecolor rgb '#404040'\n"
    "set tics textcolor rgb '#202020'\n";

// Okabe and Ito's colours, which stay apart without red-green vision; yellow left out.
constexpr std::array curve_colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#e69f00", "#56b4e9", "#000000"};
constexpr std::array curve_markers{7, 5, 9, 13, 11, 6, 4};

std::string range_text(const Range& range) {
  return join("[", range[0], ":", range[1], "]");
}

// Ranges narrower than this part of their numbers show rounding.
constexpr double narrowest = 1e-9;

void require_range(const Range& r, const char* name) {
  const bool finite = std::isfinite(r[0]) && std::isfinite(r[1]) && std::isfinite(r[1] - r[0]);
  require(finite && r[1] - r[0] > narrowest * std::max(std::abs(r[0]), std::abs(r[1])), name,
          r[1] - r[0], "needs finite lower < upper that differ by more than rounding");
}

// The least and greatest of numbers that are added.
struct Extent {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  void add(double value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  // Never empty: where there is one value (but for rounding), or none, some room around it.
  Range range() const {
    if (least > greatest) return {0, 1};
    const double size = std::max(std::abs(least), std::abs(greatest));
    constexpr double smallest = 1e-280;  // what gnuplot can divide
    if (greatest - least > std::max(narrowest * size, smallest)) return {least, greatest};
    const double room = size < smallest ? 1 : 0.1 * size;
    return {least - room, greatest + room};
  }
};

// A distance of 1, 2 or 5 times a power of ten that cuts the range into at most `most` parts.
double tic_distance(const Range& range, int most) {
  const double least = (range[1] - range[0]) / std::max(most, 1);
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * power >= least * (1 - 1e-9)) return step * power;
  return 10 * power;
}

// Figures that tell one tic from the next.
int tic_figures(const Range& range, double step) {
  const double size = std::max(std::abs(range[0]), std::abs(range[1]));
  return std::max(6, static_cast<int>(std::log10(size / step)) + 2);
}

std::string linear_tics(const std::string& axis, const Range& range, int most) {
  const double step = tic_distance(range, most);
  return join("set ", axis, "tics ", step, "\nset format ", axis, " '%.", tic_figures(range, step),
              "h'\n");
}

// Decades or, on less than two of them, 1, 2 and 5 times each power of ten. Each one by itself:
// gnuplot would begin its own where the range does.
std::string log_tics(const std::string& axis, const Range& range) {
  const double decades = std::log10(range[1] / range[0]);
  const bool powers = decades >= 2;
  const int step = static_cast<int>(std::ceil(decades / 9));
  std::string tics;
  for (int e = static_cast<int>(std::floor(std::log10(range[0])));; ++e) {
    const double power = std::pow(10.0, e);
    if (power > range[1]) break;
    for (int m = 1; m <= 9; ++m) {
      const double at = m * power;
      if (at < range[0] || at > range[1] || (powers && step > 1 && m > 1)) continue;
      if (!tics.empty()) tics += ", ";
      if (powers && m == 1 && e % step == 0)
        tics += join("'10^{", e, "}' ", at);
      else if (!powers && (m == 1 || m == 2 || m == 5 || decades < 0.7))
        tics += join("'%g' ", at);
      else
        tics += join("'' ", at, " 1");
    }
  }
  return join("set logscale ", axis, "\nset ", axis, "tics (", tics, ")\n");
}

// ---- heat maps
// ------------------------------------------------------------------------------------

void require_panel(const HeatMapPanel& panel) {
  panel.grid.validate();
  require(panel.grid.dimension <= 2, "dimension of a heat map's grid", panel.grid.dimension,
          "must be 1 or 2; take a slice() of a 3-D grid");
  require(panel.values.size() == panel.grid.size(), "number of values of a heat map",
          panel.values.size(), "must be one per node of its grid");
  for (const double value : panel.values)
    require(!std::isinf(value), "value of a heat map", value, "must be finite, or NaN for none");
  for (const auto& dot : panel.dots)
    for (const double coordinate : dot)
      require(std::isfinite(coordinate), "coordinate of a dot", coordinate, "must be finite");
}

// What the nodes' rectangles cover along an axis.
Range covered(const StructuredGrid<double>& grid, int axis) {
  const double half = grid.spacing[axis] / 2;
  return {grid.coordinate(0, axis) - half, grid.coordinate(grid.count(axis) - 1, axis) + half};
}

Range common_range(const HeatMap& map, int axis) {
  Extent extent;
  for (const HeatMapPanel& panel : map.panels)
    for (const double border : covered(panel.grid, axis)) extent.add(border);
  return extent.range();
}

Range common_colours(const HeatMap& map) {
  Extent extent;
  for (const HeatMapPanel& panel : map.panels)
    for (const double value : panel.values)
      if (!std::isnan(value)) extent.add(value);
  return extent.range();
}

// Room in pixels for the tic labels of an axis that is cut as linear_tics() does.
int label_room(const Range& range, int most) {
  constexpr int letter = 9;
  const double step = tic_distance(range, most);
  std::size_t longest = 1;
  for (double k = std::ceil(range[0] / step); k * step <= range[1]; ++k) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", tic_figures(range, step), k * step);
    const std::string_view label = text;
    const bool power = label.find('e') != std::string_view::npos;  // drawn with a sign of times
    longest = std::max(longest, label.size() + (power ? 2 : 0));
  }
  return letter * static_cast<int>(longest);
}

// Positions in pixels. Panels in rows and columns, tics at the left and at the bottom, one colour
// bar at the right.
struct Layout {
  static constexpr int bottom = 70, gap_x = 28, panel_title = 34, bar_gap = 22, bar_width = 20;
  static constexpr double area_side = 560, longest_width = 1000, longest_height = 900,
                          shortest = 60;
  int columns, rows, panel_width, panel_height, left, right, top, gap_y, width, height;

  Layout(const HeatMap& map, const Range& x, const Range& y, const Range& colours) {
    const double aspect =
        std::clamp((x[1] - x[0]) / (y[1] - y[0]), 1.0 / 12, 12.0);  // width : height
    const int panels = static_cast<int>(map.panels.size());
    columns = map.columns > 0 ? std::min(map.columns, panels) : aspect > 2 ? 1 : panels;
    rows = (panels + columns - 1) / columns;
    // One area whatever the shape, within bounds; smaller where there are many, down to half the
    // size.
    const double side = area_side * std::max(0.5, 1 / std::sqrt(std::max(1.0, 0.6 * columns)));
    const double wide =
        std::min({side * std::sqrt(aspect), longest_width, longest_height * aspect});
    panel_width = static_cast<int>(std::max(wide, shortest));
    panel_height = static_cast<int>(std::max(wide / aspect, shortest));
    bool titles = false;
    for (const HeatMapPanel& panel : map.panels) titles = titles || !panel.title.empty();
    gap_y = titles ? panel_title + 6 : 22;
    top = (titles ? panel_title : 18) + (map.title.empty() ? 0 : 36);
    left = 56 + label_room(y, y_tics());
    right = 62 + label_room(colours, colour_tics());
    width = left + columns * panel_width + (columns - 1) * gap_x + bar_gap + bar_width + right;
    height = top + panels_height() + bottom;
  }

  int panels_height() const { return rows * panel_height + (rows - 1) * gap_y; }
  int x_tics() const { return std::max(2, panel_width / 75); }
  int y_tics() const { return std::max(3, panel_height / 45); }
  int colour_tics() const { return std::max(2, panels_height() / 60); }
  double screen_x(double pixels) const { return pixels / width; }
  double screen_y(double pixels_from_top) const { return 1 - pixels_from_top / height; }
};

// Positions of columns or rows of an image, of which gnuplot needs two: a single one is given
// twice, half as wide.
std::vector<double> image_positions(const StructuredGrid<double>& grid, int axis) {
  const double quarter = grid.spacing[axis] / 4;
  if (grid.count(axis) == 1) return {grid.origin[axis] - quarter, grid.origin[axis] + quarter};
  std::vector<double> positions;
  for (std::size_t i = 0; i < grid.count(axis); ++i) positions.push_back(grid.coordinate(i, axis));
  return positions;
}

// One line per node: x, y, value. (What gnuplot calls a matrix would be shorter, but is float.)
std::string data_block(const std::string& name, const HeatMapPanel& panel) {
  const StructuredGrid<double>& grid = panel.grid;
  const std::vector<double> x = image_positions(grid, 0), y = image_positions(grid, 1);
  std::string text = join("$", name, " << end\n");
  for (std::size_t row = 0; row < y.size(); ++row) {
    for (std::size_t column = 0; column < x.size(); ++column) {
      const std::size_t i = std::min(column, grid.count(0) - 1);
      const std::size_t j = std::min(row, grid.count(1) - 1);
      const double value = panel.values[j * grid.count(0) + i];
      detail::append_number(text, x[column]);
      text += ' ';
      detail::append_number(text, y[row]);
      text += ' ';
      if (std::isnan(value))
        text += "NaN";
      else
        detail::append_number(text, value);
      text += '\n';
    }
  }
  text += "end\n";
  if (panel.dots.empty()) return text;
  text += join("$dots_", name, " << end\n");
  for (const auto& dot : panel.dots) text += join(dot[0], " ", dot[1], "\n");
  return text + "end\n";
}

std::string panel_script(const HeatMap& map, const Layout& layout, const Range& x_range,
                         const Range& y_range, std::size_t index) {
  const HeatMapPanel& panel = map.panels[index];
  const int column = static_cast<int>(index) % layout.columns;
  const int row = static_cast<int>(index) / layout.columns;
  const bool lowest = index + static_cast<std::size_t>(layout.columns) >= map.panels.size();
  const int x = layout.left + column * (layout.panel_width + Layout::gap_x);
  const int y = layout.top + row * (layout.panel_height + layout.gap_y);
  const auto margin = [](const char* side, double at) {
    return join("set ", side, "margin at screen ", at, "\n");
  };
  std::string text =
      margin("l", layout.screen_x(x)) + margin("r", layout.screen_x(x + layout.panel_width)) +
      margin("t", layout.screen_y(y)) + margin("b", layout.screen_y(y + layout.panel_height));
  text += join("set title ", gnuplot_string(panel.title), " noenhanced offset 0,-0.4\n");
  text += lowest ? linear_tics("x", x_range, layout.x_tics()) : "set format x ''\n";
  text += column == 0 ? linear_tics("y", y_range, layout.y_tics()) : "set format y ''\n";
  text += join("set xlabel ", gnuplot_string(lowest ? map.x_label : ""), " noenhanced\n");
  text += join("set ylabel ", gnuplot_string(column == 0 ? map.y_label : ""), " noenhanced\n");
  if (index == 1) text += "unset colorbox\nunset label 1\n";
  text += join("plot $p", index, " using 1:2:3 with image notitle");
  if (!panel.dots.empty())
    text +=
        join(", $dots_p", index,
             " using 1:2 with points pointtype 7 pointsize 0.35 linecolor rgb '#202020' notitle");
  return text + "\n";
}

std::string shared_script(const HeatMap& map, const Layout& layout, const Range& x, const Range& y,
                          const Range& colours) {
  std::string text = std::string(palette) + frame_style;
  text += join("set xrange ", range_text(x), "\nset yrange ", range_text(y), "\nset cbrange ",
               range_text(colours), "\n");
  text += linear_tics("x", x, layout.x_tics()) + linear_tics("y", y, layout.y_tics()) +
          linear_tics("cb", colours, layout.colour_tics());
  text += "set tics out nomirror\nunset key\n";
  text +=
      "set object 1 rectangle from graph 0,0 to graph 1,1 fillcolor rgb '#d4d4d4' fillstyle "
      "solid noborder behind\n";
  text += join("set colorbox user origin screen ",
               layout.screen_x(layout.width - layout.right - Layout::bar_width), ",",
               layout.screen_y(layout.top + layout.panels_height()), " size screen ",
               layout.screen_x(Layout::bar_width), ",",
               static_cast<double>(layout.panels_height()) / layout.height, "\n");
  text += join("set cblabel ", gnuplot_string(map.colour_label), " noenhanced offset 0.8,0\n");
  if (map.title.empty()) return text;
  return text + join("set label 1 ", gnuplot_string(map.title), " at screen ",
                     layout.screen_x((layout.left + layout.width - layout.right) / 2.0), ",",
                     layout.screen_y(24), " center noenhanced font ',14'\n");
}

LinePlot as_curves(const HeatMap& map) {
  LinePlot plot;
  plot.title = map.title;
  plot.x_label = map.x_label;
  plot.y_label = map.colour_label.empty() ? "value" : map.colour_label;
  plot.x_range = map.x_range;
  plot.y_range = map.colour_range;
  plot.scale = map.scale;
  for (const HeatMapPanel& panel : map.panels) {
    require_panel(panel);
    Curve curve;
    curve.name = panel.title;
    for (std::size_t i = 0; i < panel.grid.count(0); ++i)
      curve.x.push_back(panel.grid.coordinate(i, 0));
    curve.y = panel.values;
    curve.style = CurveStyle::line;
    plot.curves.push_back(std::move(curve));
  }
  return plot;
}

// ---- curves
// ---------------------------------------------------------------------------------------

void require_curve(const LinePlot& plot, const Curve& curve) {
  require(curve.x.size() == curve.y.size(), "number of y values of a curve", curve.y.size(),
          "must be that of its x values");
  require(curve.labels.empty() || curve.labels.size() == curve.x.size(),
          "number of labels of a curve", curve.labels.size(), "must be that of its x values, or 0");
  const auto check = [&](double value, bool log, bool may_be_nan, const char* axis) {
    const std::string name = std::string(axis) + " of curve '" + curve.name + "'";
    if (std::isnan(value) && may_be_nan) return;
    if (!std::isfinite(value)) detail::throw_invalid(name, value, "must be finite");
    if (log && value <= 0)
      detail::throw_invalid(name, value, "must be positive on a logarithmic axis");
  };
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    check(curve.x[i], plot.log_x, false, "x");
    check(curve.y[i], plot.log_y, true, "y");
  }
}

// What the curves cover, and a margin.
Range curve_range(const LinePlot& plot, bool y) {
  const bool log = y ? plot.log_y : plot.log_x;
  Extent extent;
  for (const Curve& curve : plot.curves)
    for (const double value : y ? curve.y : curve.x)
      if (!std::isnan(value)) extent.add(log ? std::log10(value) : value);
  Range range = extent.range();
  const double margin = 0.06 * (range[1] - range[0]);
  range = {range[0] - margin, range[1] + margin};
  return log ? Range{std::pow(10.0, range[0]), std::pow(10.0, range[1])} : range;
}

std::string curve_style(const Curve& curve, std::size_t index) {
  const bool line = curve.style != CurveStyle::markers;
  const bool markers = curve.style != CurveStyle::line;
  std::string text = join(" with ",
                          line && markers ? "linespoints"
                          : line          ? "lines"
                                          : "points",
                          " linecolor rgb '", curve_colours[index % curve_colours.size()], "'");
  if (line) text += " linewidth 2";
  if (markers)
    text += join(" pointtype ", curve_markers[index % curve_markers.size()], " pointsize 1.1");
  return text + (curve.name.empty() ? " notitle" : join(" title ", gnuplot_string(curve.name)));
}

// Labels beside their points: of a few places the first where no point and no label is, as far as
// rough sizes of letters tell.
std::string labels(const LinePlot& plot, const Range& x_range, const Range& y_range) {
  constexpr double width = 530, height = 480, letter = 8.2, line = 15, point = 6;
  struct Box {
    double left, right, low, high;
    bool meets(const Box& other) const {
      return left < other.right && other.left < right && low < other.high && other.low < high;
    }
  };
  const auto place = [](double value, const Range& range, bool log) {
    return log ? std::log(value / range[0]) / std::log(range[1] / range[0])
               : (value - range[0]) / (range[1] - range[0]);
  };
  std::vector<Box> taken;
  for (const Curve& curve : plot.curves)
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (std::isnan(curve.y[i])) continue;
      const double x = width * place(curve.x[i], x_range, plot.log_x),
                   y = height * place(curve.y[i], y_range, plot.log_y);
      taken.push_back({x - point, x + point, y - point, y + point});
    }
  std::string script;
  std::size_t at = 0;
  for (const Curve& curve : plot.curves)
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (std::isnan(curve.y[i])) continue;
      const Box dot = taken[at++];
      if (curve.labels.empty()) continue;
      const double x = (dot.left + dot.right) / 2, y = (dot.low + dot.high) / 2;
      const double length = letter * static_cast<double>(curve.labels[i].size());
      double up = 0;
      bool left = false;
      for (const auto& [side, lines] : {std::pair{false, 0.0},
                                        {true, 0.0},
                                        {false, 1.0},
                                        {false, -1.0},
                                        {true, 1.0},
                                        {true, -1.0},
                                        {false, 2.0},
                                        {false, -2.0},
                                        {true, 2.0},
                                        {true, -2.0}}) {
        const double from = side ? x - 8 - length : x + 8;
        const Box box{from, from + length, y + (lines - 0.5) * line, y + (lines + 0.5) * line};
        if (box.left < 0 || box.right > width || box.low < 0 || box.high > height ||
            std::any_of(taken.begin(), taken.end(),
                        [&](const Box& other) { return box.meets(other); }))
          continue;
        left = side;
        up = lines;
        taken.push_back(box);
        break;
      }
      script += join("set label ", gnuplot_string(curve.labels[i]), " at first ", curve.x[i],
                     ", first ", curve.y[i], left ? " right" : " left", " offset char ",
                     left ? -0.9 : 0.9, ", char ", 0.1 + 0.95 * up, " noenhanced\n");
    }
  return script;
}

// The reference line y = factor x^slope lies below the first curve wherever that has values.
std::string reference_line(const LinePlot& plot) {
  const double slope = *plot.reference_slope;
  const Curve& curve = plot.curves.front();
  double factor = std::numeric_limits<double>::infinity();
  Extent extent;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (std::isnan(curve.y[i])) continue;
    factor = std::min(factor, curve.y[i] / std::pow(curve.x[i], slope));
    extent.add(curve.x[i]);
  }
  require(extent.least < extent.greatest, "reference slope", slope,
          "needs a first curve of at least two points");
  return join(", [x=", extent.least, ":", extent.greatest, "] ", 0.6 * factor, " * x**(", slope,
              ") with lines linecolor rgb '#606060' linewidth 1.5 dashtype 2 title ",
              gnuplot_string(join("slope ", slope)));
}

}  // namespace

GridSlice slice(const StructuredGrid<double>& grid, std::span<const double> values, int axis,
                std::size_t index) {
  grid.validate();
  require(grid.dimension >= 2, "dimension of the grid", grid.dimension,
          "must be at least 2 to take a slice");
  require(axis >= 0 && axis < grid.dimension, "axis of the slice", axis,
          "must be an axis of the grid, counted from 0");
  if (index >= grid.count(axis))
    detail::throw_invalid(
        "index of the slice", index,
        "must be below the number of nodes along the axis, " + std::to_string(grid.count(axis)));
  if (values.size() != grid.size())
    detail::throw_invalid(
        "number of values", values.size(),
        "must be one per node, of which there are " + std::to_string(grid.size()));
  GridSlice result;
  result.grid.dimension = grid.dimension - 1;
  for (int d = 0, kept = 0; d < grid.dimension; ++d) {
    if (d == axis) continue;
    result.grid.origin[kept] = grid.origin[d];
    result.grid.spacing[kept] = grid.spacing[d];
    result.grid.counts[kept++] = grid.count(d);
  }
  result.values.reserve(result.grid.size());
  for (std::size_t node = 0; node < grid.size(); ++node)
    if (grid.index(node)[axis] == index) result.values.push_back(values[node]);
  return result;
}

void require_picture_extension(const std::filesystem::path& path) {
  const std::string own = path.extension().string();
  const std::vector<std::string> known{".png", ".svg"};
  for (const std::string& each : known)
    if (edit_distance(own, each) == 0) return;  // ignores case
  throw FileError(path, 0, "'" + own + "' is no extension of a picture: .png or .svg is needed");
}

void draw(const std::filesystem::path& path, const HeatMap& map) {
  require(!map.panels.empty(), "panels of a heat map", 0, "must be at least one");
  for (const HeatMapPanel& panel : map.panels) {
    require_panel(panel);
    require(panel.grid.dimension == map.panels.front().grid.dimension,
            "dimension of a heat map's grid", panel.grid.dimension,
            "must be the same for all panels");
  }
  if (map.panels.front().grid.dimension == 1) return draw(path, as_curves(map));
  const Range x = map.x_range.value_or(common_range(map, 0));
  const Range y = map.y_range.value_or(common_range(map, 1));
  require_range(x, "x range of the picture");
  require_range(y, "y range of the picture");
  const Range colours = map.colour_range.value_or(common_colours(map));
  require_range(colours, "colour range of the picture");
  const Layout layout(map, x, y, colours);
  std::string script;
  for (std::size_t p = 0; p < map.panels.size(); ++p)
    script += data_block(join("p", p), map.panels[p]);
  script += shared_script(map, layout, x, y, colours) + "set multiplot\n";
  for (std::size_t p = 0; p < map.panels.size(); ++p) script += panel_script(map, layout, x, y, p);
  script += "unset multiplot\n";
  detail::run_gnuplot(path, layout.width, layout.height, map.scale, script);
}

void draw(const std::filesystem::path& path, const LinePlot& plot) {
  require(!plot.curves.empty(), "curves of a plot", 0, "must be at least one");
  for (const Curve& curve : plot.curves) require_curve(plot, curve);
  require(!plot.log_x || !plot.x_range || (*plot.x_range)[0] > 0, "x range of the picture",
          plot.x_range ? (*plot.x_range)[0] : 0, "must be positive on a logarithmic axis");
  require(!plot.log_y || !plot.y_range || (*plot.y_range)[0] > 0, "y range of the picture",
          plot.y_range ? (*plot.y_range)[0] : 0, "must be positive on a logarithmic axis");
  if (plot.reference_slope)
    require(plot.log_x && plot.log_y && std::isfinite(*plot.reference_slope), "reference slope",
            *plot.reference_slope, "must be finite, and both axes logarithmic");
  const Range x = plot.x_range.value_or(curve_range(plot, false));
  const Range y = plot.y_range.value_or(curve_range(plot, true));
  require_range(x, "x range of the picture");
  require_range(y, "y range of the picture");

  std::string script;
  for (std::size_t c = 0; c < plot.curves.size(); ++c) {
    script += join("$c", c, " << end\n");
    for (std::size_t i = 0; i < plot.curves[c].x.size(); ++i) {
      const double value = plot.curves[c].y[i];
      script += join(plot.curves[c].x[i], " ", std::isnan(value) ? "NaN" : join(value), "\n");
    }
    script += "end\n";
  }
  script += frame_style;
  script += join("set xrange ", range_text(x), "\nset yrange ", range_text(y), "\n");
  script += plot.log_x ? log_tics("x", x) : linear_tics("x", x, 8);
  script += plot.log_y ? log_tics("y", y) : linear_tics("y", y, 8);
  script += "set grid linetype 1 linecolor rgb '#e4e4e4' linewidth 1\nset tics nomirror\n";
  script += join("set xlabel ", gnuplot_string(plot.x_label), " noenhanced\nset ylabel ",
                 gnuplot_string(plot.y_label), " noenhanced\nset title ",
                 gnuplot_string(plot.title), " noenhanced font ',14'\n");
  script += "set key outside right top vertical Left reverse noenhanced samplen 2.5 spacing 1.3\n";
  script += "set tmargin 3\nset samples 200\n";
  script += labels(plot, x, y);
  script += "plot ";
  for (std::size_t c = 0; c < plot.curves.size(); ++c) {
    script += join(c == 0 ? "$c" : ", $c", c, " using 1:2", curve_style(plot.curves[c], c));
  }
  if (plot.reference_slope) script += reference_line(plot);
  detail::run_gnuplot(path, 960, 600, plot.scale, script + "\n");
}

}  // namespace recon
