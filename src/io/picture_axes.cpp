#include "picture_axes.hpp"

#include <cmath>

#include "number_text.hpp"

namespace recon::detail {

std::string range_text(const Range& range) {
  return join("[", range[0], ":", range[1], "]");
}

namespace {
// Ranges narrower than this part of their numbers show rounding.
constexpr double narrowest = 1e-9;
}  // namespace

void require_range(const Range& r, const char* name) {
  const bool finite = std::isfinite(r[0]) && std::isfinite(r[1]) && std::isfinite(r[1] - r[0]);
  require(finite && r[1] - r[0] > narrowest * std::max(std::abs(r[0]), std::abs(r[1])), name,
          r[1] - r[0], "needs finite lower < upper that differ by more than rounding");
}

Range Extent::range() const {
  if (least > greatest) return {0, 1};
  const double size = std::max(std::abs(least), std::abs(greatest));
  constexpr double smallest = 1e-280;  // what gnuplot can divide
  if (greatest - least > std::max(narrowest * size, smallest)) return {least, greatest};
  const double room = size < smallest ? 1 : 0.1 * size;
  return {least - room, greatest + room};
}

double tic_distance(const Range& range, int most) {
  const double least = (range[1] - range[0]) / std::max(most, 1);
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * power >= least * (1 - 1e-9)) return step * power;
  return 10 * power;
}

int tic_figures(const Range& range, double step) {
  const double size = std::max(std::abs(range[0]), std::abs(range[1]));
  return std::max(6, static_cast<int>(std::log10(size / step)) + 2);
}

std::string linear_tics(const std::string& axis, const Range& range, int most) {
  const double step = tic_distance(range, most);
  return join("set ", axis, "tics ", step, "\nset format ", axis, " '%.", tic_figures(range, step),
              "h'\n");
}

// Each tic by itself: gnuplot would begin its own where the range does.
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

}  // namespace recon::detail
