// The inner loops of the batch search, compiled for several instruction sets (core/dispatch.hpp).
//
//   gather_ball, gather_cube  the particles near one point, from the cells around it
//   ranks                     the place of each of a few numbers among them, by counting
//
// Squared distances have the bits of squared_distance(): nothing is fused.
#pragma once

#include <cstdint>

#include "core/dispatch.hpp"

namespace recon::detail {

inline constexpr std::int64_t rows_of_a_band = 8;

// Where the particles of each cell lie (cells.hpp): cell i of the row (j, k) has the particles
// first[c] .. first[c + 1] - 1 with c = row_of_cells(counts, j, k) + i. Axes that do not exist have
// one cell. The arrays x and index can be read 16 elements beyond the last.
template <class S>
struct CellView {
  double lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};  // bounding box of the particles
  double size = 1, inverse = 1;                       // edge of a cell, and 1 / edge
  std::int64_t counts[3] = {1, 1, 1};                 // cells along each axis
  const S* x[3] = {nullptr, nullptr, nullptr};
  const std::uint32_t* index = nullptr;
  const std::uint32_t* first = nullptr;
};

// `static`: every instruction set has its own copy.
static inline std::int64_t cell_on_axis(double x, double lower, double inverse,
                                        std::int64_t count) {
  const double at = (x - lower) * inverse, last = static_cast<double>(count - 1);
  const double positive = at > 0 ? at : 0;
  return static_cast<std::int64_t>(positive < last ? positive : last);
}

static inline std::int64_t row_of_cells(const std::int64_t* counts, std::int64_t j,
                                        std::int64_t k) {
  const std::int64_t in_band = j % rows_of_a_band, band = j - in_band;
  const std::int64_t left = counts[1] - band;
  const std::int64_t height = left < rows_of_a_band ? left : rows_of_a_band;
  return (band * counts[2] + k * height + in_band) * counts[0];
}

// The particles gathered so far, and room for more. Work is counted in candidates looked at; a row
// of cells counts like work_of_a_row of them.
inline constexpr std::int64_t work_of_a_row = 16;
template <class S>
struct Gathered {
  S* distance2;
  std::uint32_t* index;
  std::int64_t count = 0, capacity = 0;
  std::int64_t work = 0, work_limit = INT64_MAX;
  std::int64_t work_per_found = 0;  // added to the work for each particle found; may be negative
};
enum class GatherResult { complete, no_room, too_much_work };

// Adds all particles with squared_distance(x, p) <= radius * radius (ball), or with
// |x_d - p_d| <= radius on every axis (cube), in no particular order. Stops when the work exceeds
// its limit.
#define RECON_CELL_KERNELS                                                                    \
  template <class S, int D>                                                                   \
  GatherResult gather_ball(const CellView<S>& cells, const S* x, S radius, Gathered<S>& out); \
  template <class S, int D>                                                                   \
  GatherResult gather_cube(const CellView<S>& cells, const S* x, S radius, Gathered<S>& out); \
  template <class T>                                                                          \
  void ranks(T* values, std::int64_t count, T* rank)
// ranks: rank[i] = how many values are smaller than values[i]. Reads and writes up to 64 elements
// beyond the last of both arrays. Cost count^2 / lanes.
RECON_FOR_EACH_SET(RECON_CELL_KERNELS)
#undef RECON_CELL_KERNELS

}  // namespace recon::detail
