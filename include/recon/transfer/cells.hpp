// The cells of a grid: their Gauss points, sums over the particles in each, and which of them lie
// inside of what the particles fill.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   const std::vector<recon::SpaceVector<2>> places(5, {0.3, 0.4});
//   const auto mass_in = recon::sums_in_cells(grid, places, [](std::size_t) { return 0.5; });
//   const bool inside = recon::is_inside(grid, mass_in, grid.cell_number(places[0]));
//   const recon::CellPoints<2> gauss(grid, 2);  // four points, exact for cubics on each axis
//   double integral = 0;                        // of x y over a cell
//   for (std::size_t g = 0; g < gauss.per_cell(); ++g)
//     integral += gauss.volume() * gauss.at(3, g).prod();
// ```
//
// Cells are numbered as CartesianGrid::cell_number() does: the first axis runs fastest.
#pragma once

#include <cmath>
#include <vector>

#include "recon/transfer/cartesian_grid.hpp"

namespace recon {

// The indices of a cell along the axes, from its number.
template <int D>
std::array<int, D> cell_index(const CartesianGrid<D>& grid, std::size_t cell) {
  std::array<int, D> index;
  for (int d = 0; d < D; ++d) {
    const auto cells = static_cast<std::size_t>(grid.cells(d));
    index[d] = static_cast<int>(cell % cells);
    cell /= cells;
  }
  return index;
}

// The lower corner of a cell, from its number.
template <int D>
SpaceVector<D> cell_corner(const CartesianGrid<D>& grid, std::size_t cell) {
  const std::array<int, D> index = cell_index(grid, cell);
  SpaceVector<D> corner;
  for (int d = 0; d < D; ++d) corner[d] = grid.node(index[d], d);
  return corner;
}

// One point in the middle of each cell, exact for linear functions, or the two Gauss points of each
// axis, exact for cubics on each. Throws InvalidArgument for another number per axis, and for a
// grid without cells.
template <int D>
class CellPoints {
 public:
  CellPoints(const CartesianGrid<D>& grid, int per_axis) : grid_(grid) {
    detail::require(per_axis == 1 || per_axis == 2, "points of a cell along an axis", per_axis,
                    "must be 1 or 2");
    if (grid.size() == 0) detail::throw_no_cells();
    const double offset = per_axis == 1 ? 0 : grid.h() / (2 * std::sqrt(3.0));
    const int count = per_axis == 1 ? 1 : 1 << D;
    for (int g = 0; g < count; ++g) {
      SpaceVector<D> place;
      for (int d = 0; d < D; ++d) place[d] = grid.h() / 2 + (g >> d & 1 ? offset : -offset);
      places_.push_back(place);
    }
    volume_ = std::pow(grid.h(), D) / count;
  }
  std::size_t per_cell() const { return places_.size(); }
  // The volume that each stands for, length^D.
  double volume() const { return volume_; }
  // The offset of point g from the lower corner of its cell.
  const SpaceVector<D>& place(std::size_t g) const { return places_[g]; }
  SpaceVector<D> at(std::size_t cell, std::size_t g) const {
    return places_[g] + cell_corner(grid_, cell);
  }

 private:
  CartesianGrid<D> grid_;
  std::vector<SpaceVector<D>> places_;
  double volume_;
};

// The sum of amount(p) over the points in each cell. Points beyond the grid count in the outermost
// cells. Throws InvalidArgument for points that are not finite.
template <int D, class Points, class Amount>
std::vector<double> sums_in_cells(const CartesianGrid<D>& grid, const Points& points,
                                  const Amount& amount) {
  std::vector<double> sums(grid.cell_count());
  for (std::size_t p = 0; p < points.size(); ++p) sums[grid.cell_number(points[p])] += amount(p);
  return sums;
}

// Whether a cell and all its neighbours within the grid, 3^D - 1 at most, have sums above 0: then
// no border of what the particles fill runs through it. Throws InvalidArgument unless there is one
// sum for each cell.
template <int D>
bool is_inside(const CartesianGrid<D>& grid, const std::vector<double>& sums, std::size_t cell) {
  detail::require(sums.size() == grid.cell_count(), "sums of cells", sums.size(),
                  "must be one for each cell");
  detail::require(cell < sums.size(), "number of the cell", cell, "must be one of the grid's");
  const std::array<int, D> at = cell_index(grid, cell);
  int neighbours = 1;
  for (int d = 0; d < D; ++d) neighbours *= 3;
  for (int n = 0; n < neighbours; ++n) {
    std::size_t number = 0, stride = 1;
    bool in_grid = true;
    for (int d = 0, rest = n; d < D; ++d, rest /= 3) {
      const int index = at[d] + rest % 3 - 1;
      in_grid = in_grid && index >= 0 && index < grid.cells(d);
      number += stride * static_cast<std::size_t>(index);
      stride *= static_cast<std::size_t>(grid.cells(d));
    }
    if (in_grid && !(sums[number] > 0)) return false;
  }
  return true;
}

}  // namespace recon
