// Curves.
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
using detail::log_tics;
using detail::range_text;
using detail::require_range;

// Okabe and Ito's colours, which stay apart without red-green vision; yellow left out.
constexpr std::array curve_colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#e69f00", "#56b4e9", "#000000"};
constexpr std::array curve_markers{7, 5, 9, 13, 11, 6, 4};
// The first curve is solid, the others lie over those before them with gaps to look through.
constexpr std::array curve_dashes{"(12,6)", "(3,4)",          "(12,4,3,4)",
                                  "(6,6)",  "(16,4,3,4,3,4)", "(9,9)"};

void require_curve(const LinePlot& plot, const Curve& curve) {
  require(curve.x.size() == curve.y.size(), "number of y values of a curve", curve.y.size(),
          "must be that of its x values");
  require(curve.labels.empty() || curve.labels.size() == curve.x.size(),
          "number of labels of a curve", curve.labels.size(), "must be that of its x values, or 0");
  const auto check = [&](double value, bool log, const char* axis) {
    const std::string name = std::string(axis) + " of curve '" + curve.name + "'";
    if (std::isnan(value)) return;
    if (!std::isfinite(value)) detail::throw_invalid(name, value, "must be finite");
    if (log && value <= 0)
      detail::throw_invalid(name, value, "must be positive on a logarithmic axis");
  };
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    check(curve.x[i], plot.log_x, "x");
    check(curve.y[i], plot.log_y, "y");
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

bool is_gap(const Curve& curve, std::size_t i) {
  return std::isnan(curve.x[i]) || std::isnan(curve.y[i]);
}

// Points of a curve as gnuplot's data, where `takes(i)` is true; a blank line interrupts the line.
template <class Takes>
std::string data_block(const std::string& name, const Curve& curve, const Takes& takes) {
  std::string points;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (is_gap(curve, i))
      points += '\n';
    else if (takes(i))
      points += join(curve.x[i], " ", curve.y[i], "\n");
  }
  if (points.find_first_not_of('\n') == std::string::npos) return "";
  return join("$", name, " << end\n", points, "end\n");
}

// Of many points some are marked, on each curve others, so that curves that coincide show. A point
// that no line reaches always is.
bool is_marked(const Curve& curve, std::size_t i, std::size_t index, std::size_t curves) {
  const std::size_t points = curve.x.size();
  const bool alone = (i == 0 || is_gap(curve, i - 1)) && (i + 1 == points || is_gap(curve, i + 1));
  if (alone || curve.style == CurveStyle::markers) return true;
  if (curve.style == CurveStyle::line) return false;
  constexpr std::size_t few = 20, marks = 12;
  if (points <= few || !curve.labels.empty()) return true;
  const std::size_t stride = std::max((points + marks - 1) / marks, curves);
  return i % stride == index * stride / curves % stride;
}

std::string line_style(std::size_t index, std::size_t curves) {
  if (index == 0) return curves == 1 ? " linewidth 2" : " linewidth 3";
  return join(" linewidth 2 dashtype ", curve_dashes[(index - 1) % curve_dashes.size()]);
}

// Later curves have smaller markers, which do not hide those below.
std::string marker_style(std::size_t index, std::size_t curves) {
  const double size =
      curves == 1 ? 1.1 : 1.4 - 0.6 * static_cast<double>(index) / static_cast<double>(curves - 1);
  return join(" pointtype ", curve_markers[index % curve_markers.size()], " pointsize ", size);
}

// What is drawn of a curve, and its entry in the legend: `script` gets the data, `plots` the parts
// of the plot command.
void add_curve(const LinePlot& plot, std::size_t index, std::string& script,
               std::vector<std::string>& plots) {
  const Curve& curve = plot.curves[index];
  const std::size_t curves = plot.curves.size();
  const bool line = curve.style != CurveStyle::markers, marks = curve.style != CurveStyle::line;
  const std::string colour =
      join(" linecolor rgb '", curve_colours[index % curve_colours.size()], "'");
  const std::string lines = line_style(index, curves), markers = marker_style(index, curves);
  const std::string all =
      line ? data_block(join("c", index), curve, [](std::size_t) { return true; }) : "";
  const std::string marked = data_block(
      join("m", index), curve, [&](std::size_t i) { return is_marked(curve, i, index, curves); });
  script += all + marked;
  if (!all.empty())
    plots.push_back(join("$c", index, " using 1:2 with lines", colour, lines, " notitle"));
  if (!marked.empty())
    plots.push_back(join("$m", index, " using 1:2 with points", colour, markers, " notitle"));
  if (curve.name.empty() && !plots.empty()) return;
  plots.push_back(join("NaN with ",
                       line && marks ? "linespoints"
                       : line        ? "lines"
                                     : "points",
                       colour, line ? lines : "", marks ? markers : "",
                       curve.name.empty() ? " notitle" : " title " + gnuplot_string(curve.name)));
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
      if (is_gap(curve, i)) continue;
      const double x = width * place(curve.x[i], x_range, plot.log_x),
                   y = height * place(curve.y[i], y_range, plot.log_y);
      taken.push_back({x - point, x + point, y - point, y + point});
    }
  std::string script;
  std::size_t at = 0;
  for (const Curve& curve : plot.curves)
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (is_gap(curve, i)) continue;
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
    if (is_gap(curve, i)) continue;
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
  std::vector<std::string> plots;
  for (std::size_t c = 0; c < plot.curves.size(); ++c) add_curve(plot, c, script, plots);
  script += detail::frame_style;
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
  for (std::size_t p = 0; p < plots.size(); ++p) script += (p == 0 ? "" : ", ") + plots[p];
  if (plot.reference_slope) script += reference_line(plot);
  detail::run_gnuplot(path, 960, 600, plot.scale, script + "\n");
}

}  // namespace recon
