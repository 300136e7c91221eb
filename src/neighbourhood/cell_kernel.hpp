// The inner loops of the batch search, compiled for several instruction sets (core/dispatch.hpp).
//
//   collect                 the particles in a box, from the cells that it overlaps: the candidates
//   near_ball, near_cube    the candidates near one point
//   select_smallest, ranks  the nearest of a few, by counting for each how many are smaller
//
// Candidates are floats, sixteen to a vector register, about the centre of the box. For particles
// in float these are the coordinates themselves, and squared distances have the bits of
// squared_distance(): nothing is fused. For particles in double they are off by a little; who asks
// must know by how much (brick.hpp), and decide by the coordinates themselves what
// floats cannot tell.
#pragma once

#include <cstdint>
#include <type_traits>

#include "core/dispatch.hpp"
#include "neighbourhood/cell_index.hpp"

namespace recon::detail {

// The number that stands for a coordinate in `collect`: floats stand for themselves, doubles are
// rounded to whole units, of which the longest extent of the particles has units_of_extent.
template <class S>
using Coarse = std::conditional_t<std::is_same_v<S, float>, float, std::int32_t>;
inline constexpr double units_of_extent = 1 << 30;

// Where the particles of each cell lie (cells.hpp): cell i of the row (j, k) has the particles
// first[c] .. first[c + 1] - 1 with c = row_of_cells(counts, j, k) + i. Axes that do not exist have
// one cell. The arrays x can be read 16 elements beyond the last.
template <class S>
struct CellView {
  double lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};  // bounding box of the particles
  double size = 1, inverse = 1;                       // edge of a cell, and 1 / edge
  double units = 1;                                   // of Coarse<S>, in a length
  std::int64_t counts[3] = {1, 1, 1};                 // cells along each axis
  const Coarse<S>* x[3] = {nullptr, nullptr, nullptr};
  const std::uint32_t* first = nullptr;
};

// The cells from..to along each axis, and of their particles those with lower <= x - centre <=
// upper.
template <class S>
struct CellBox {
  std::int64_t from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
  Coarse<S> centre[3] = {0, 0, 0};
  float lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};
};

// What has been collected, and room for more (64 beyond the capacity): x - centre, and the place of
// each. Work is counted in particles looked at; a row of cells counts like work_of_a_row of them.
inline constexpr std::int64_t work_of_a_row = 16;
struct CandidateArrays {
  float* x[3] = {nullptr, nullptr, nullptr};
  std::uint32_t* place = nullptr;
  std::int64_t count = 0, capacity = 0;
  std::int64_t work = 0, work_limit = INT64_MAX;
};
enum class CollectResult { complete, no_room, too_much_work };

// The numbers of candidates, and their squared distances (ball) or largest distances along an axis
// (cube). There must be room for as many as there are candidates, and 64 more.
struct NearArrays {
  float* measure;
  std::uint32_t* candidate;
  std::int64_t count = 0;
};

// How many have rank 0 .. k - 1, the largest measure of them and the least of the others; and how
// many of them measure nearly as much as the largest.
struct Smallest {
  std::int64_t count;
  float largest, next;
  std::int64_t far;
};

// Which of the chosen measure nearly as much as the largest of them: all from (largest - slack) less
// 2^-19 of it on. Room for as many as there are candidates, and 64 more.
struct FarArrays {
  float slack;
  std::uint32_t* candidate;
};

// collect: adds the particles of the box, by ascending place. Stops when the work exceeds its
// limit.
// near_...: adds the candidates begin .. end - 1 of which the measure is at most `limit`, in order.
// ranks: rank[i] = how many values are smaller than values[i]. Reads and writes up to 64 elements
// beyond the last of both arrays. Cost count^2 / lanes.
// select_smallest: puts into `chosen`, in order, those than which fewer than k are smaller; of
// `near` there must be k at least. `probably` is a measure that most likely fewer than k do not
// exceed: those need no ranks, or ranks among themselves only. All arrays have room for 64 more.
// The numbers of the candidates that are nearly the farthest go into `far`.
// rank_smallest: the same in no order, with rank[i] = how many measure less than chosen i.
// count_at_most: how many of the values are at most `limit`.
#define RECON_CELL_KERNELS                                                                         \
  template <class S, int D>                                                                        \
  CollectResult collect(const CellView<S>& cells, const CellBox<S>& box, CandidateArrays& out);    \
  template <int D>                                                                                 \
  void near_ball(const CandidateArrays& from, std::int64_t begin, std::int64_t end,                \
                 const float* x, float limit, NearArrays& out);                                    \
  template <int D>                                                                                 \
  void near_cube(const CandidateArrays& from, std::int64_t begin, std::int64_t end,                \
                 const float* x, float limit, NearArrays& out);                                    \
  template <class T>                                                                               \
  void ranks(T* values, std::int64_t count, T* rank);                                              \
  Smallest select_smallest(const NearArrays& near, std::int64_t k, float probably,                 \
                           NearArrays& rest, float* rank, NearArrays& chosen,                      \
                           const FarArrays& far);                                                  \
  Smallest rank_smallest(const NearArrays& near, std::int64_t k, float probably, NearArrays& rest, \
                         float* rank, NearArrays& chosen, const FarArrays& far);                   \
  std::int64_t count_at_most(const float* values, std::int64_t count, float limit)
RECON_FOR_EACH_SET(RECON_CELL_KERNELS)
#undef RECON_CELL_KERNELS

}  // namespace recon::detail
