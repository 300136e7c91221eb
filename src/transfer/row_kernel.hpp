// The inner loops of sums between a particle and the nodes that it sees (node_rows.hpp), compiled for
// several instruction sets (core/dispatch.hpp).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/dispatch.hpp"

namespace recon::detail {

// NodeFunctions as kernels see them: G has D numbers a node.
struct NodeList {
  const std::uint32_t* node;
  const double *S, *G;
  std::size_t count;
};

// Polynomials at these nodes: that of mode r at node k is value[r * of_mode + k * of_node].
struct ModeList {
  const double* value = nullptr;
  std::ptrdiff_t of_mode = 0, of_node = 0;
  std::size_t count = 0;
};

// What a particle gives to a node, a row of eight: numbers 0 to 3 get S (value + sum_r s_r c_r), with
// the polynomials s_r of `modes`; numbers 4 to 6 get sum_d G_d slope_d, and number 7 gets
// |G|^2 times `squared`.
struct Given {
  alignas(32) double value[4];
  alignas(32) double slope[3][4];  // the last number of each is 0
  double squared;
  ModeList modes;
  const double* coefficients;  // four of each mode
};

// What a particle takes: sum_i S_i row_i of rows of eight, and sum_i G_id row_i of rows of four.
struct Taken {
  alignas(32) double value[8];
  alignas(32) double slope[3][4];
};

// give: as Given says.
// take: `sloping` are the first four numbers of rows that follow each other by `stride`.
// take_modes: out[4 r + c] = sum_i S_i s_r(x_i) row_i[c], of the first four numbers of rows of eight.
// give_four, take_four: S times four numbers, and their sums, with rows of four.
#define RECON_ROW_KERNELS                                                                         \
  template <int D>                                                                                \
  void give(const NodeList& at, const Given& given, double* rows);                                \
  template <int D>                                                                                \
  void take(const NodeList& at, const double* rows, const double* sloping, std::ptrdiff_t stride, \
            Taken& taken);                                                                        \
  void take_modes(const NodeList& at, const ModeList& modes, const double* rows, double* out);    \
  void give_four(const NodeList& at, const double* four, double* rows);                           \
  void take_four(const NodeList& at, const double* rows, double* four)
RECON_FOR_EACH_SET(RECON_ROW_KERNELS)
#undef RECON_ROW_KERNELS

}  // namespace recon::detail
