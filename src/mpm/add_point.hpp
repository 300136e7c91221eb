// Quadrature points of cells, and their contributions to the nodes.
#pragma once

#include <cmath>

#include "recon/mpm/nodes.hpp"
#include "recon/transfer/node_functions.hpp"

namespace recon::mpm {

// One point in the middle of each cell, or two Gauss points on each axis.
template <int D>
class CellPoints {
 public:
  CellPoints(const Grid<D>& grid, int per_axis) : grid_(grid) {
    const double offset = per_axis == 1 ? 0 : grid.h() / (2 * std::sqrt(3.0));
    const int count = per_axis == 1 ? 1 : 1 << D;
    for (int g = 0; g < count; ++g) {
      Vector<D> place;
      for (int d = 0; d < D; ++d) place[d] = grid.h() / 2 + (g >> d & 1 ? offset : -offset);
      places_.push_back(place);
    }
    volume_ = std::pow(grid.h(), D) / count;
  }
  std::size_t per_cell() const { return places_.size(); }
  double volume() const { return volume_; }
  // The offset of the point from the lower corner of the cell.
  const Vector<D>& place(std::size_t g) const { return places_[g]; }
  Vector<D> at(std::size_t cell, std::size_t g) const {
    Vector<D> x = places_[g];
    for (int d = 0; d < D; ++d) {
      const auto cells = static_cast<std::size_t>(grid_.cells(d));
      x[d] += grid_.node(static_cast<int>(cell % cells), d);
      cell /= cells;
    }
    return x;
  }

 private:
  const Grid<D>& grid_;
  std::vector<Vector<D>> places_;
  double volume_;
};

// Adds the contributions of a point with this volume and these values (columns of QuadratureData):
// rho N_i to the mass, rho b N_i - sigma grad N_i to the force, and rho v N_i to the momentum, if
// there is one; each times the volume.
template <int D, class Count>
void add_point(const NodeFunctions<D, Count>& shape, double volume, const double* values,
               bool body_force, bool momentum, Nodes<D>& nodes) {
  const double mass = volume * *values++;
  Matrix<D> stress;
  for (int r = 0; r < D; ++r)
    for (int c = r; c < D; ++c) stress(r, c) = stress(c, r) = *values++;
  Vector<D> push = Vector<D>::Zero(), carried = Vector<D>::Zero();
  for (int d = 0; d < D && body_force; ++d) push[d] = mass * *values++;
  for (int d = 0; d < D && momentum; ++d) carried[d] = volume * *values++;
  const Matrix<D> pull = -volume * stress;
  for (std::size_t n = 0; n < shape.size(); ++n) {
    const std::uint32_t i = shape.node[n];
    nodes.mass[i] += shape.S[n] * mass;
    nodes.force[i] += shape.S[n] * push + pull * shape.G[n];
    if (momentum) nodes.momentum[i] += shape.S[n] * carried;
  }
}

}  // namespace recon::mpm
