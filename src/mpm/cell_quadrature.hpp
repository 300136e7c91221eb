// Quadrature over the cells of the grid, with density and stress by least squares.
//
// A cell counts with the part of it that holds material: 1 where the cell and all its neighbours
// hold particles (or lie beyond the grid), 0 where it holds none, else the part that the volumes of
// its particles fill, at most 1. So a body ends where its particles end, and inside it nothing
// depends on how particles are spread over cells.
#pragma once

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// The data of the particles in the columns that quadratures reconstruct: density, the stress (row
// after row of its upper triangle), b (the body force per mass, unless that is empty), and density
// times velocity if asked for.
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

// 1 for cells that hold particles, as do all their neighbours, else 0.
template <int D>
std::vector<double> full_cells(const Problem<D>& problem);

// Fits and adds to the mass and force of the nodes, for the quadratures `cells` (fitted at the
// centre of each cell, its only point) and `nodal_cells` (fitted at the nodes, linear between them,
// integrated exactly). b: body force per mass of the particles, or empty.
template <int D>
void integrate_cells(const Problem<D>& problem, const std::vector<Vector<D>>& b, Cells<D>& cells,
                     Nodes<D>& nodes);

}  // namespace recon::mpm
