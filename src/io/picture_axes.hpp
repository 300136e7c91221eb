// What heat maps and line plots share: ranges, and tics of axes, as gnuplot's commands.
#pragma once

#include <algorithm>
#include <limits>
#include <string>

#include "recon/io/picture.hpp"

namespace recon::detail {

constexpr const char* frame_style =
    "set border 31 linewidth 1 linecolor rgb '#404040'\n"
    "set tics textcolor rgb '#202020'\n";

// A range as gnuplot writes it: "[0:1]".
std::string range_text(const Range& range);

// Throws InvalidArgument unless lower < upper are finite and differ by more than rounding.
void require_range(const Range& range, const char* name);

// The least and the greatest of the numbers that were added.
struct Extent {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  void add(double value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  // The range, never empty: where there is one value (but for rounding), or none, with some
  // room around it.
  Range range() const;
};

// A distance of tics, 1, 2 or 5 times a power of ten, that cuts the range into at
// most `most` parts.
double tic_distance(const Range& range, int most);
// The number of digits that tell one tic from the next.
int tic_figures(const Range& range, double step);

// The commands for the tics of an axis ("x", "y", "cb").
std::string linear_tics(const std::string& axis, const Range& range, int most);
// Tics of a log axis: decades or, on less than two of them, 1, 2 and 5 times each power of ten.
std::string log_tics(const std::string& axis, const Range& range);

}  // namespace recon::detail
