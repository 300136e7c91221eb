// Sums between particles and the nodes that they see, with the data of a node in a row of four or
// eight numbers: a particle adds a row, or reads one, with a few vector instructions a node,
// whatever its functions are.
//
// Who writes rows from several threads sees to it that no two threads write to one node
// (scatter_by_rows). A call serves one particle; it costs next to nothing beside the sums.
#pragma once

#include "recon/core/array.hpp"
#include "recon/transfer/node_functions.hpp"
#include "transfer/row_kernel.hpp"

namespace recon::detail {

template <int D, class Count>
NodeList list_of(const NodeFunctions<D, Count>& at) {
  return {at.node.data(), at.S.data(), at.G.data()->data(), at.size()};
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
      : give(RECON_DISPATCH(set, give<D>)),
        take(RECON_DISPATCH(set, take<D>)),
        take_modes(RECON_DISPATCH(set, take_modes)),
        give_four(RECON_DISPATCH(set, give_four)),
        take_four(RECON_DISPATCH(set, take_four)) {}

  void (*give)(const NodeList&, const Given&, double*);
  void (*take)(const NodeList&, const double*, const double*, std::ptrdiff_t, Taken&);
  void (*take_modes)(const NodeList&, const ModeList&, const double*, double*);
  void (*give_four)(const NodeList&, const double*, double*);
  void (*take_four)(const NodeList&, const double*, double*);
};

}  // namespace recon::detail
