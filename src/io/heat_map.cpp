// Heat maps: fields on grids as rectangles of colours.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gnuplot.hpp"
#include "number_text.hpp"
#include "picture_axes.hpp"
#include "recon/core/error.hpp"
#include "recon/io/picture.hpp"

namespace recon {

namespace {

using detail::require;

using detail::Extent;
using detail::gnuplot_string;
using detail::join;
using detail::linear_tics;
using detail::range_text;
using detail::require_range;
using detail::tic_distance;
using detail::tic_figures;

// Eleven points of viridis (van der Walt and Smith, 2015), linear in between.
constexpr const char* palette =
    "set palette defined (0 '#440154', 1 '#482475', 2 '#414487', 3 '#355f8d', 4 '#2a788e', "
    "5 '#21918c', 6 '#22a884', 7 '#44bf70', 8 '#7ad151', 9 '#bddf26', 10 '#fde725')\n";

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

// Values beyond these are outliers; see colour_scale().
Range fences(std::vector<double> values) {
  constexpr std::size_t enough = 20, part = 100;
  const Range none{-std::numeric_limits<double>::infinity(),
                   std::numeric_limits<double>::infinity()};
  if (values.size() < enough) return none;
  const auto aside = static_cast<std::ptrdiff_t>(std::max<std::size_t>(1, values.size() / part));
  std::nth_element(values.begin(), values.begin() + aside, values.end());
  const double low = values[static_cast<std::size_t>(aside)];
  std::nth_element(values.begin(), values.end() - 1 - aside, values.end());
  const double high = *(values.end() - 1 - aside);
  const double width = high - low;
  if (!(width > 0) || !std::isfinite(width)) return none;
  return {low - width, high + width};
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
  static constexpr int note_height = 22;
  int columns, rows, panel_width, panel_height, left, right, top, gap_y, width, height;

  // note: whether there is a line of text below everything.
  Layout(const HeatMap& map, const Range& x, const Range& y, const Range& colours, bool note) {
    const double aspect =
        std::clamp((x[1] - x[0]) / (y[1] - y[0]), 1.0 / 12, 12.0);  // width : height
    const int panels = static_cast<int>(map.panels.size());
    columns = map.columns > 0 ? std::min(map.columns, panels) : aspect > 2 ? 1 : panels;
    rows = (panels + columns - 1) / columns;
    // One area whatever the shape, within bounds; smaller where there are many, down
    // to half the size.
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
    height = top + panels_height() + bottom + (note ? note_height : 0);
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
  if (index == 1) text += "unset colorbox\nunset label 1\nunset label 2\n";
  text += join("plot $p", index, " using 1:2:3 with image notitle");
  if (!panel.dots.empty())
    text +=
        join(", $dots_p", index,
             " using 1:2 with points pointtype 7 pointsize 0.35 linecolor rgb '#202020' notitle");
  return text + "\n";
}

std::string shared_script(const HeatMap& map, const Layout& layout, const Range& x, const Range& y,
                          const Range& colours, const std::string& note) {
  std::string text = std::string(palette) + detail::frame_style;
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
  if (!note.empty())
    text += join("set label 2 ", gnuplot_string(note), " at screen ",
                 layout.screen_x(layout.width - 12.0), ",",
                 layout.screen_y(layout.height - Layout::note_height / 2.0),
                 " right noenhanced textcolor rgb '#404040'\n");
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

}  // namespace

ColourScale colour_scale(const HeatMap& map) {
  std::vector<double> values;
  Extent all, shown;
  for (const HeatMapPanel& panel : map.panels)
    for (const double value : panel.values) {
      if (std::isnan(value)) continue;
      values.push_back(value);
      all.add(value);
    }
  ColourScale scale;
  if (values.empty()) return map.colour_range ? ColourScale{*map.colour_range} : scale;
  scale.least = all.least;
  scale.greatest = all.greatest;
  if (map.colour_range) {
    scale.range = *map.colour_range;
  } else {
    const Range fence = fences(values);
    for (const double value : values)
      if (value >= fence[0] && value <= fence[1]) shown.add(value);
    scale.range = shown.range();
  }
  for (const double value : values) {
    scale.below += value < scale.range[0] ? 1 : 0;
    scale.above += value > scale.range[1] ? 1 : 0;
  }
  return scale;
}

std::string describe_beyond(const ColourScale& scale) {
  const auto side = [](std::size_t count, const char* text, double value) {
    if (count == 0) return std::string();
    char number[32];
    std::snprintf(number, sizeof number, "%.4g", value);
    return join(count, count == 1 ? " node " : " nodes ", text, number);
  };
  const std::string above = side(scale.above, "above, up to ", scale.greatest);
  const std::string below = side(scale.below, "below, down to ", scale.least);
  if (above.empty() && below.empty()) return "";
  return join("beyond the colours: ", above, !above.empty() && !below.empty() ? "; " : "", below);
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
  const ColourScale scale = colour_scale(map);
  require_range(scale.range, "colour range of the picture");
  const std::string note = describe_beyond(scale);
  const Layout layout(map, x, y, scale.range, !note.empty());
  std::string script;
  for (std::size_t p = 0; p < map.panels.size(); ++p)
    script += data_block(join("p", p), map.panels[p]);
  script += shared_script(map, layout, x, y, scale.range, note) + "set multiplot\n";
  for (std::size_t p = 0; p < map.panels.size(); ++p) script += panel_script(map, layout, x, y, p);
  script += "unset multiplot\n";
  detail::run_gnuplot(path, layout.width, layout.height, map.scale, script);
}

}  // namespace recon
