// Quadrature over the cells of the grid, with density and stress by least squares.
//
// A cell counts with the part of it that holds material: 1 where the cell and all its neighbours
// hold particles (or lie beyond the grid), 0 where it holds none, else what its particles' volumes
// fill of it, at most 1. So the bodies' borders are where their particles are, and inside nothing
// depends on how particles are spread over cells.
#pragma once

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// Of the particles, as the columns that quadratures reconstruct: density, stress by rows of its
// upper triangle, b (the body force per mass, unless that is empty), and density times velocity
// if asked for.
template <int D>
class QuadratureData {
 public:
  QuadratureData(const Problem<D>& problem, const std::vector<Vector<D>>& b, bool momentum);

  int columns() const { return columns_; }
  FieldView<double> field() const;
  const double* row(std::size_t p) const {
    return data_.data() + p * static_cast<std::size_t>(columns_);
  }

 private:
  int columns_;
  std::vector<double> data_;
};

// Number of the cell that holds x, the first axis fastest as in the grid of the cell centres.
template <int D>
std::size_t cell_of(const Grid<D>& grid, const Vector<D>& x) {
  std::size_t n = 0;
  for (int d = D - 1; d >= 0; --d)
    n = n * static_cast<std::size_t>(grid.cells(d)) + static_cast<std::size_t>(grid.cell(x[d], d));
  return n;
}

// 1 for cells that hold particles, as do all their neighbours, else 0.
template <int D>
std::vector<double> full_cells(const Problem<D>& problem);

// The quadratures `cells` (one point in each, fitted there) and `nodal_cells` (fitted at the nodes,
// linear between them, exact): fits, and adds to the nodes' mass and force. b: body force per mass
// of the particles, or empty.
template <int D>
void integrate_cells(const Problem<D>& problem, const std::vector<Vector<D>>& b, Cells<D>& cells,
                     Nodes<D>& nodes);

}  // namespace recon::mpm
