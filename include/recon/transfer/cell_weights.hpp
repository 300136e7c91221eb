// What particles stand for in the cells of a grid: weights W_cp, volumes, with which
//     sigma_c V_c = sum_p W_cp sigma_p
// is integrated at cell centres x_c, and their transpose, which takes values of cells back to the
// particles.
//
// Inside of what the particles fill (is_inside(), cells.hpp) they are the rows of moving least
// squares of degree 1 at x_c, W_cp = V_c phi_cp with the weights k_cp (as IMPM has it: Gong 2015,
// eq. 5.9), so that linear fields have their value at the centre whatever the cloud; in all other
// cells W_cp = k_cp V_p, which is positive and, as the k of a particle sum to one over the cells,
// keeps the volumes. k are B-splines of degree 1 or 2 about the centres; cells beyond a face are
// mirrored into those within.
//
// With the linear functions N_i of the grid a particle then has
//     G_ip = sum_c W_cp grad N_i(x_c) / W_p ,   W_p = sum_c W_cp ,
// so that forces of particles with these volumes, f_i = -sum_p W_p sigma_p G_ip, are those of the
// cells, -sum_c (sum_p W_cp sigma_p) grad N_i(x_c), and their strains sum_i v_i G_ip^T the transpose.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   const std::vector<recon::SpaceVector<2>> places(1, {0.3, 0.4});
//   const std::vector<double> volumes(1, 0.01);
//   recon::CellWeights<2> weights;
//   weights.fill(grid, 2, places, volumes);
//   double volume = 0;  // W_p
//   weights.for_cells(grid, places[0], volumes[0],
//                     [&](std::size_t, double part) { volume += part; });
// ```
#pragma once

#include <span>
#include <vector>

#include "recon/transfer/cells.hpp"
#include "recon/transfer/point_functions.hpp"

namespace recon {

template <int D>
class CellWeights {
 public:
  // Of particles at these places with these volumes, k of this degree. Throws InvalidArgument for
  // another degree than 1 or 2, sizes that differ, and places or volumes that are not finite. The
  // same bits for any number of threads; threads <= 0: default_threads().
  void fill(const CartesianGrid<D>& grid, int degree, std::span<const SpaceVector<D>> places,
            std::span<const double> volumes, int threads = 0);

  // Whether there was no fill().
  bool empty() const { return row_.empty(); }
  // For each cell 1 where the weights are those of least squares, else 0.
  std::vector<double> fitted() const;

  // Calls each(c, W_cp) for the cells of a particle of the fill(). Where their sum W_p is not above
  // a tenth of its volume, all W_cp are k_cp V_p.
  template <class Each>
  void for_cells(const CartesianGrid<D>& grid, const SpaceVector<D>& x, double volume,
                 const Each& each) const {
    const Block block(grid, degree_, x);
    const Parts parts(*this, grid, block, volume);
    for (int n = 0; n < block.count; ++n) each(parts.cell[n], parts.weight[n]);
  }
  // Replaces the gradients of the functions that the particle has at x, those of
  // CellFunctions<degree> with a border other than linear_cells, by G_ip, and returns W_p.
  template <class Count>
  double gradients(const CartesianGrid<D>& grid, const SpaceVector<D>& x, double volume,
                   NodeFunctions<D, Count>& at) const;

 private:
  // The cells of a particle: on each axis the first and their number, k without and with those that
  // are mirrored, and (x - x_c) / h.
  struct Block {
    static constexpr int widest = 3;
    std::array<int, D> first, size;
    std::array<std::array<double, widest>, D> plain{}, mirrored{}, offset;
    int count = 1;
    Block(const CartesianGrid<D>& grid, int degree, const SpaceVector<D>& x) {
      for (int d = 0; d < D; ++d) {
        const double s = (x[d] - grid.lower()[d]) / grid.h();
        if (degree == 1)
          along(d, s, grid.cells(d), detail::CellSplines<1>(s, grid.cells(d)));
        else
          along(d, s, grid.cells(d), detail::CellSplines<2>(s, grid.cells(d)));
        count *= size[d];
      }
    }
    template <class Splines>
    void along(int d, double s, int cells, const Splines& of) {
      first[d] = std::max(of.first, 0);
      size[d] = std::min(of.first + Splines::count, cells) - first[d];
      for (int n = 0; n < Splines::count; ++n) {
        const int cell = of.first + n, within = std::clamp(cell, 0, cells - 1) - first[d];
        mirrored[d][within] += of.k[n];
        if (cell != within + first[d]) continue;
        plain[d][within] = of.k[n];
        offset[d][within] = s - cell - 0.5;
      }
    }
    // The places along the axes of cell n of them.
    std::array<int, D> place(int n) const {
      std::array<int, D> at;
      for (int d = 0; d < D; ++d, n /= size[d - 1]) at[d] = n % size[d];
      return at;
    }
  };
  // The least-squares functional of a cell, sum_p k_cp (row . (1, offset)) u_p; zero where there is
  // none.
  using Row = Eigen::Matrix<double, D + 1, 1>;

  // The cells of a block, W_cp and their sum.
  struct Parts {
    static constexpr int most = detail::to_the_power<Block::widest>(D);
    std::array<std::size_t, most> cell;
    std::array<double, most> weight;
    double sum = 0;

    Parts(const CellWeights& all, const CartesianGrid<D>& grid, const Block& block, double volume) {
      std::array<double, most> kept;
      for (int n = 0; n < block.count; ++n) {
        const std::array<int, D> at = block.place(n);
        double plain = 1;
        cell[n] = 0;
        kept[n] = volume;
        for (int d = D - 1; d >= 0; --d) {
          cell[n] = cell[n] * static_cast<std::size_t>(grid.cells(d)) +
                    static_cast<std::size_t>(block.first[d] + at[d]);
          plain *= block.plain[d][at[d]];
          kept[n] *= block.mirrored[d][at[d]];
        }
        const Row& row = all.row_[cell[n]];
        double fitted = row[0];
        for (int d = 0; d < D; ++d) fitted += row[d + 1] * block.offset[d][at[d]];
        weight[n] = row[0] == 0 ? kept[n] : fitted * plain * std::pow(grid.h(), D);
        sum += weight[n];
      }
      if (sum > volume / 10) return;
      weight = kept;
      sum = volume;
    }
  };

  int degree_ = 2;
  std::vector<Row> row_;
};

template <int D>
template <class Count>
double CellWeights<D>::gradients(const CartesianGrid<D>& grid, const SpaceVector<D>& x,
                                 double volume, NodeFunctions<D, Count>& at) const {
  const Block block(grid, degree_, x);
  const Parts parts(*this, grid, block, volume);
  for (std::size_t k = 0; k < at.size(); ++k) at.G[k].setZero();
  const double slope = 1 / (grid.h() * (1 << (D - 1)) * parts.sum);
  for (int n = 0; n < block.count; ++n) {
    const std::array<int, D> place = block.place(n);
    for (int corner = 0; corner < 1 << D; ++corner) {
      std::size_t node = 0;
      for (int d = D - 1; d >= 0; --d)
        node = node * static_cast<std::size_t>(block.size[d] + 1) +
               static_cast<std::size_t>(place[d] + (corner >> d & 1));
      for (int d = 0; d < D; ++d)
        at.G[node][d] += (corner >> d & 1 ? slope : -slope) * parts.weight[n];
    }
  }
  return parts.sum;
}

extern template class CellWeights<1>;
extern template class CellWeights<2>;
extern template class CellWeights<3>;

}  // namespace recon
