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

// Functions that are products of those of the axes: at node first + sum_d k_d stride_d they are
// prod_d S_d[k_d], and so are their gradients with one G_d. No list of nodes is made of them.
struct ProductList {
  std::size_t first;
  std::size_t stride[3];  // that of the first axis is 1
  int count[3];
  const double *S[3], *G[3];
  // S times an affine mode of its axis; all null where there are none.
  const double* M[3];
};

// Linear functions at the corners of a domain, of which S = sum_a weight_a N(x_a) and
// G = sum_a slope_a N(x_a): corner a lies in the cell whose first node is first[a], at xi[.][a],
// which runs from 0 to 1 over it along each axis.
struct CornerList {
  std::uint32_t stride[3];
  std::uint32_t first[8];
  alignas(32) double xi[3][8];
  alignas(32) double weight[8];
  alignas(32) double slope[3][8];
};
// A grid, for that.
struct CornerGrid {
  double lower[3], h, per_h;
  int cells[3];
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
  ModeList modes;              // of a list of nodes
  const double* coefficients;  // four of each mode, or of the mode of each axis
};

// What a particle takes: sum_i S_i row_i of rows of eight, and sum_i G_id row_i of rows of four.
struct Taken {
  alignas(32) double value[8];
  alignas(32) double slope[3][4];
  alignas(32) double moment[3][4];  // sum_i S_i s_d(x_i) row_i of the modes of a product
};

// give: as Given says.
// take: `sloping` are the first four numbers of rows that follow each other by `stride`.
// take_modes: out[4 r + c] = sum_i S_i s_r(x_i) row_i[c], of the first four numbers of rows of eight.
// give_four, take_four: S times four numbers, and their sums, with rows of four.
// The same for products, with the modes of their axes, and for corners, without modes and squares.
// find_corners: the list of corners of D coordinates each, with a weight and D numbers of slope.
// find_parallelepiped: that of Cpdi1Functions, of x, its half edges and their inverse, the columns one
// after the other. Both return false where a corner may not be finite.
#define RECON_ROW_KERNELS                                                                         \
  template <int D>                                                                                \
  void give(const NodeList& at, const Given& given, double* rows);                                \
  template <int D>                                                                                \
  void take(const NodeList& at, const double* rows, const double* sloping, std::ptrdiff_t stride, \
            Taken& taken);                                                                        \
  void take_modes(const NodeList& at, const ModeList& modes, const double* rows, double* out);    \
  void give_four(const NodeList& at, const double* four, double* rows);                           \
  void take_four(const NodeList& at, const double* rows, double* four);                           \
  template <int D>                                                                                \
  void give_product(const ProductList& at, const Given& given, double* rows);                     \
  template <int D>                                                                                \
  void take_product(const ProductList& at, const double* rows, const double* sloping,             \
                    std::ptrdiff_t stride, Taken& taken);                                         \
  template <int D>                                                                                \
  void give_four_product(const ProductList& at, const double* four, double* rows);                \
  template <int D>                                                                                \
  void take_four_product(const ProductList& at, const double* rows, double* four);                \
  template <int D>                                                                                \
  bool find_corners(const CornerGrid& grid, const double* corners, const double* weight,          \
                    const double* slope, CornerList& at);                                         \
  template <int D>                                                                                \
  bool find_parallelepiped(const CornerGrid& grid, const double* x, const double* half_edges,     \
                           const double* inverse, CornerList& at);                                \
  template <int D>                                                                                \
  void give_corners(const CornerList& at, const Given& given, double* rows);                      \
  template <int D>                                                                                \
  void take_corners(const CornerList& at, const double* rows, const double* sloping,              \
                    std::ptrdiff_t stride, Taken& taken);                                         \
  template <int D>                                                                                \
  void give_four_corners(const CornerList& at, const double* four, double* rows);                 \
  template <int D>                                                                                \
  void take_four_corners(const CornerList& at, const double* rows, double* four)
RECON_FOR_EACH_SET(RECON_ROW_KERNELS)
#undef RECON_ROW_KERNELS

}  // namespace recon::detail
