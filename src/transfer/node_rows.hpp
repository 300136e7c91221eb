// Sums between particles and the nodes that they see, with the data of a node in a row of four or
// eight numbers: a particle adds a row, or reads one, with a few vector instructions a node,
// whatever its functions are.
//
// Who writes rows from several threads sees to it that no two threads write to one node
// (scatter_by_rows). A call serves one particle; it costs next to nothing beside the sums.
#pragma once

#include "recon/core/array.hpp"
#include "recon/transfer/domain_functions.hpp"
#include "transfer/row_kernel.hpp"

namespace recon::detail {

template <int D, class Count>
NodeList list_of(const NodeFunctions<D, Count>& at) {
  return {at.node.data(), at.S.data(), at.G.data()->data(), at.size()};
}

// Of the products of functions of the axes, which must stay where they are; without modes.
template <int D, class Count>
ProductList product_of(const CartesianGrid<D>& grid,
                       const std::array<AxisFunctions<Count>, D>& axes) {
  ProductList list;
  std::array<int, D> first;
  std::size_t stride = 1;
  for (int d = 0; d < D; ++d) {
    first[d] = axes[d].first;
    list.count[d] = axes[d].count;
    list.stride[d] = stride;
    list.S[d] = axes[d].S.data();
    list.G[d] = axes[d].G.data();
    list.M[d] = nullptr;
    stride *= static_cast<std::size_t>(grid.cells(d)) + 1;
  }
  list.first = grid.number(first);
  return list;
}

// Rows of `width` numbers for all nodes, each within one line of the cache.
class NodeRows {
 public:
  // Not set to anything.
  NodeRows(std::size_t nodes, int width)
      : width_(static_cast<std::size_t>(width)), memory_(nodes * width_ + line) {
    const auto beyond = reinterpret_cast<std::uintptr_t>(memory_.data()) / sizeof(double) % line;
    rows_ = memory_.data() + (line - beyond) % line;
  }
  NodeRows(NodeRows&&) = default;
  NodeRows& operator=(NodeRows&&) = default;

  double* data() { return rows_; }
  const double* data() const { return rows_; }
  double* operator[](std::size_t node) { return rows_ + node * width_; }
  const double* operator[](std::size_t node) const { return rows_ + node * width_; }

 private:
  static constexpr std::size_t line = 64 / sizeof(double);
  std::size_t width_;
  Array<double> memory_;
  double* rows_;
};

// The kernels of the best instruction set.
template <int D>
struct RowKernels {
  static RowKernels best() { return RowKernels(resolved(InstructionSet::automatic)); }
  explicit RowKernels(InstructionSet set)
      : list_{RECON_DISPATCH(set, give<D>), RECON_DISPATCH(set, take<D>),
              RECON_DISPATCH(set, give_four), RECON_DISPATCH(set, take_four)},
        product_{RECON_DISPATCH(set, give_product<D>), RECON_DISPATCH(set, take_product<D>),
                 RECON_DISPATCH(set, give_four_product<D>),
                 RECON_DISPATCH(set, take_four_product<D>)},
        corners_{RECON_DISPATCH(set, give_corners<D>), RECON_DISPATCH(set, take_corners<D>),
                 RECON_DISPATCH(set, give_four_corners<D>),
                 RECON_DISPATCH(set, take_four_corners<D>)},
        take_modes(RECON_DISPATCH(set, take_modes)),
        find_corners_(RECON_DISPATCH(set, find_corners<D>)),
        find_parallelepiped_(RECON_DISPATCH(set, find_parallelepiped<D>)) {}

  template <class List>
  void give(const List& at, const Given& given, double* rows) const {
    of<List>().give(at, given, rows);
  }
  template <class List>
  void take(const List& at, const double* rows, const double* sloping, std::ptrdiff_t stride,
            Taken& taken) const {
    of<List>().take(at, rows, sloping, stride, taken);
  }
  template <class List>
  void give_four(const List& at, const double* four, double* rows) const {
    of<List>().give_four(at, four, rows);
  }
  template <class List>
  void take_four(const List& at, const double* rows, double* four) const {
    of<List>().take_four(at, rows, four);
  }
  // The list of the corners of a domain. Throws as its functions do.
  void find(const CartesianGrid<D>& grid, const CornerDomain<D>& domain, CornerList& list) const {
    if (!find_corners_(of_corners(grid), domain.corners[0].data(), domain.weight.data(),
                       domain.slope[0].data(), list)) [[unlikely]]
      for (const SpaceVector<D>& corner : domain.corners) grid.require_point(corner);
  }
  void find(const CartesianGrid<D>& grid, const ParallelepipedDomain<D>& domain,
            CornerList& list) const {
    const SpaceMatrix<D> inverse = Cpdi1Functions::inverse_of(domain);
    if (!find_parallelepiped_(of_corners(grid), domain.x.data(), domain.half_edges.data(),
                              inverse.data(), list)) [[unlikely]]
      for (const SpaceVector<D>& corner : corners_of(domain)) grid.require_point(corner);
  }

 private:
  template <class List>
  struct Kernels {
    void (*give)(const List&, const Given&, double*);
    void (*take)(const List&, const double*, const double*, std::ptrdiff_t, Taken&);
    void (*give_four)(const List&, const double*, double*);
    void (*take_four)(const List&, const double*, double*);
  };
  template <class List>
  const Kernels<List>& of() const {
    if constexpr (std::is_same_v<List, NodeList>)
      return list_;
    else if constexpr (std::is_same_v<List, ProductList>)
      return product_;
    else
      return corners_;
  }
  Kernels<NodeList> list_;
  Kernels<ProductList> product_;
  Kernels<CornerList> corners_;

 public:
  void (*take_modes)(const NodeList&, const ModeList&, const double*, double*);

 private:
  static CornerGrid of_corners(const CartesianGrid<D>& grid) {
    CornerGrid of{{}, grid.h(), grid.inverse_h(), {}};
    for (int d = 0; d < D; ++d) {
      of.lower[d] = grid.lower()[d];
      of.cells[d] = grid.cells(d);
    }
    return of;
  }
  bool (*find_corners_)(const CornerGrid&, const double*, const double*, const double*,
                        CornerList&);
  bool (*find_parallelepiped_)(const CornerGrid&, const double*, const double*, const double*,
                               CornerList&);
};

}  // namespace recon::detail
