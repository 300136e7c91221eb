// Which cell a coordinate lies in, and where the cells of a row stand: what the searches on the
// processor and on a GPU have in common (cells.hpp says how cells are laid out).
#pragma once

#include <cstdint>

namespace recon::detail {

inline constexpr std::int64_t rows_of_a_band = 8;

// `static`: every instruction set has its own copy.
static constexpr std::int64_t cell_on_axis(double x, double lower, double inverse,
                                           std::int64_t count) {
  const double at = (x - lower) * inverse, last = static_cast<double>(count - 1);
  const double positive = at > 0 ? at : 0;
  return static_cast<std::int64_t>(positive < last ? positive : last);
}

// The number of the first cell of row (j, k).
static constexpr std::int64_t row_of_cells(const std::int64_t* counts, std::int64_t j,
                                           std::int64_t k) {
  const std::int64_t in_band = j % rows_of_a_band, band = j - in_band;
  const std::int64_t left = counts[1] - band;
  const std::int64_t height = left < rows_of_a_band ? left : rows_of_a_band;
  return (band * counts[2] + k * height + in_band) * counts[0];
}

}  // namespace recon::detail
