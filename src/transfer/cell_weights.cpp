#include "recon/transfer/cell_weights.hpp"

#include <Eigen/Cholesky>

#include "recon/transfer/scatter.hpp"

namespace recon {

template <int D>
void CellWeights<D>::fill(const CartesianGrid<D>& grid, int degree,
                          std::span<const SpaceVector<D>> places, std::span<const double> volumes,
                          int threads) {
  // Of the mean square of the offsets along the best direction: a cloud that is flatter than that
  // has no slope across.
  constexpr double flattest = 1e-3;
  detail::require(degree == 1 || degree == 2, "degree of the cells' splines", degree,
                  "must be 1 or 2");
  detail::require(places.size() == volumes.size(), "volumes", volumes.size(),
                  "must be one for each place");
  for (std::size_t p = 0; p < places.size(); ++p) {
    grid.require_point(places[p]);
    if (!std::isfinite(volumes[p]))
      detail::throw_invalid("volume of particle " + std::to_string(p), volumes[p],
                            "must be finite");
  }
  degree_ = degree;
  using Moments = Eigen::Matrix<double, D + 1, D + 1>;
  std::vector<Moments> moments(grid.cell_count(), Moments::Zero());
  struct None {};
  const auto rows = [&](std::size_t p) {
    const Block at(grid, degree, places[p]);
    return std::pair(at.first[D - 1], at.first[D - 1] + at.size[D - 1] - 1);
  };
  scatter_by_rows<None>(places.size(), threads, rows, [&](std::size_t p, None&) {
    const Block block(grid, degree, places[p]);
    for (int n = 0; n < block.count; ++n) {
      const std::array<int, D> at = block.place(n);
      std::size_t cell = 0;
      double k = 1;
      Row m;
      m[0] = 1;
      for (int d = D - 1; d >= 0; --d) {
        cell = cell * static_cast<std::size_t>(grid.cells(d)) +
               static_cast<std::size_t>(block.first[d] + at[d]);
        k *= block.plain[d][at[d]];
        m[d + 1] = block.offset[d][at[d]];
      }
      moments[cell] += k * m * m.transpose();
    }
  });
  const std::vector<double> filled = sums_in_cells(grid, places, [](std::size_t) { return 1.0; });
  row_.assign(moments.size(), Row::Zero());
  parallel_blocks(row_.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (!(filled[c] > 0) || !is_inside(grid, filled, c)) continue;
      const Eigen::LDLT<Moments> factors(moments[c] / moments[c](0, 0));
      if (!(factors.vectorD().minCoeff() > flattest)) continue;
      row_[c] = factors.solve(Row::Unit(0)) / moments[c](0, 0);
      if (!(row_[c][0] > 0)) row_[c].setZero();
    }
  });
}

template <int D>
std::vector<double> CellWeights<D>::fitted() const {
  std::vector<double> fitted;
  for (const Row& row : row_) fitted.push_back(row[0] != 0 ? 1 : 0);
  return fitted;
}

template class CellWeights<1>;
template class CellWeights<2>;
template class CellWeights<3>;

}  // namespace recon
