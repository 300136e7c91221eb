// What a particle sees of the grid: nodes i with S_ip and G_ip, the value and the gradient of their
// functions N_i at the particle or averaged over its domain.
#pragma once

#include <array>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/mpm/grid.hpp"

namespace recon::mpm {

// Nodes with their S and G (1 / length). A node may occur more than once. resize()
// keeps the memory.
template <int D>
struct ShapeFunctions {
  std::vector<std::uint32_t> node;
  std::vector<double> S;
  std::vector<Vector<D>> G;

  void resize(std::size_t count) {
    node.resize(count);
    S.resize(count);
    G.resize(count);
  }
  std::size_t size() const { return node.size(); }

  // value() is sum_i S_i u_i, and gradient() is sum_i u_i (x) G_i.
  template <class Values>
  Vector<D> value(const Values& u) const {
    Vector<D> sum = Vector<D>::Zero();
    for (std::size_t k = 0; k < size(); ++k) sum += S[k] * u[node[k]];
    return sum;
  }
  template <class Values>
  Matrix<D> gradient(const Values& u) const {
    Matrix<D> sum = Matrix<D>::Zero();
    for (std::size_t k = 0; k < size(); ++k) sum += u[node[k]] * G[k].transpose();
    return sum;
  }
};

namespace detail {

// The functions of one axis at `count` consecutive nodes from `first` on.
struct AxisShape {
  static constexpr int most = 34;
  int first = 0, count = 0;
  std::array<double, most> S, G;
};

// The products of the functions of all axes; the first axis runs fastest.
template <int D>
void tensor_product(const Grid<D>& grid, const std::array<AxisShape, D>& axes,
                    ShapeFunctions<D>& out) {
  std::size_t count = 1;
  for (const AxisShape& axis : axes) count *= static_cast<std::size_t>(axis.count);
  out.resize(count);
  const AxisShape& line = axes[0];
  std::array<int, D> k{}, index;
  index[0] = line.first;
  for (std::size_t n = 0; n < count;) {
    // The product over the other axes, and the products in which one factor is a derivative.
    double S = 1;
    Vector<D> G = Vector<D>::Ones();
    for (int d = 1; d < D; ++d) {
      const double value = axes[d].S[k[d]];
      index[d] = axes[d].first + k[d];
      S *= value;
      for (int e = 1; e < D; ++e) G[e] *= e == d ? axes[d].G[k[d]] : value;
    }
    const std::uint32_t first = grid.number(index);
    for (int i = 0; i < line.count; ++i, ++n) {
      out.node[n] = first + static_cast<std::uint32_t>(i);
      out.S[n] = line.S[i] * S;
      out.G[n][0] = line.G[i] * S;
      for (int e = 1; e < D; ++e) out.G[n][e] = line.S[i] * G[e];
    }
    for (int d = 1; d < D && ++k[d] == axes[d].count; ++d) k[d] = 0;
  }
}

}  // namespace detail

}  // namespace recon::mpm
