// Quadrature over the cells of the grid, with density and stress by least squares.
//
// A cell counts with the part of it that holds material: 1 where the cell and all its neighbours
// hold particles (or lie beyond the grid), 0 where it holds none, else the part that the volumes of
// its particles fill, at most 1. So a body ends where its particles end, and inside it nothing
// depends on how particles are spread over cells.
#pragma once

#include "mpm/policies.hpp"

namespace recon::mpm {

// The data of the particles in the columns that quadratures reconstruct: density, the stress (row
// after row of its upper triangle), b (the body force per mass, unless that is empty), and density
// times velocity if asked for.
template <int D>
class QuadratureData {
 public:
  QuadratureData(const Particles<D>& particles, const std::vector<Vector<D>>& b, bool momentum,
                 int threads);

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
std::vector<double> full_cells(const Grid<D>& grid, const Particles<D>& particles);

}  // namespace recon::mpm
