// Particles sorted into a regular grid of cells: what CellGrid and the batch search both stand on.
//
// Coordinates lie in one array per axis, those of a cell side by side and by ascending index. The
// cells of a row (along x) follow one another in memory, so a stretch of a row is one stretch of
// particles. Rows come in bands: row(j, k) runs through `band` rows in y for every k before it goes
// on to the next band. So a sweep through the cells of a large grid touches a few planes of a band
// at a time, which stay in the cache. Building costs O(n + cells), in parallel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "neighbourhood/cell_kernel.hpp"
#include "neighbourhood/cell_sort.hpp"
#include "recon/core/error.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

using CellIndex = std::array<std::int64_t, max_dimension>;  // axes that do not exist have index 0

// The edge of cells that hold `particles_per_cell` particles on average over the bounding box.
template <class Scalar>
double density_cell_size(const PointCloud<Scalar>& points, double particles_per_cell) {
  double log_volume = 0;
  int axes = 0;
  for (int d = 0; d < points.dimension() && points.size() > 0; ++d) {
    const double extent =
        static_cast<double>(points.box().upper[d]) - static_cast<double>(points.box().lower[d]);
    if (!(extent > 0)) continue;
    log_volume += std::log(extent);
    ++axes;
  }
  if (axes == 0) return 1;  // all in one place
  const double per_cell = std::log(particles_per_cell / static_cast<double>(points.size()));
  return std::max(std::exp((log_volume + per_cell) / axes), std::numeric_limits<double>::min());
}

template <class S, int D>
class Cells {
 public:
  using Point = std::array<S, D>;

  // Throws InvalidArgument for a cell size that is not positive and finite.
  Cells(const PointCloud<S>& cloud, double cell_size, int threads) {
    require(cell_size > 0 && std::isfinite(cell_size), "cell_size", cell_size,
            "must be positive and finite");
    require(cloud.dimension() == D, "dimension of the points", cloud.dimension(),
            "must be the dimension of the search");
    size_ = std::max(cell_size, 4 * std::numeric_limits<double>::min());
    if (cloud.size() > 0) choose_counts(cloud);
    view_.size = size_;
    view_.inverse = 1 / size_;
    first_.resize(cells() + 1);
    sorted_ = sort_by_key<D>(
        cloud, cells(), [this](const Point& x) { return cell_of(x); }, threads, first_.data());
    for (int d = 0; d < D; ++d) view_.x[d] = sorted_.x[d].get();
    view_.index = sorted_.index.get();
    view_.first = first_.data();
  }
  Cells(const Cells&) = delete;
  Cells& operator=(const Cells&) = delete;

  std::size_t particles() const { return sorted_.size; }
  double size() const { return size_; }  // edge of a cell
  double lower(int d) const { return view_.lower[d]; }
  double upper(int d) const { return view_.upper[d]; }
  std::int64_t count(int d) const { return view_.counts[d]; }
  std::size_t cells() const {
    return static_cast<std::size_t>(count(0)) * static_cast<std::size_t>(count(1)) *
           static_cast<std::size_t>(count(2));
  }
  const CellView<S>& view() const { return view_; }
  const SortedPoints<S, D>& sorted() const { return sorted_; }

  // The cell of a coordinate along an axis; those outside count to the border cells. Never
  // decreases with x, in spite of rounding: so p in [a, b] lies in a cell from cell(a) to cell(b).
  std::int64_t cell(S x, int d) const {
    return cell_on_axis(static_cast<double>(x), view_.lower[d], view_.inverse, view_.counts[d]);
  }
  CellIndex cell_index(const Point& x) const {
    CellIndex at{};
    for (int d = 0; d < D; ++d) at[d] = cell(x[d], d);
    return at;
  }
  std::size_t cell_of(const Point& x) const {
    const CellIndex at = cell_index(x);
    return static_cast<std::size_t>(row_of_cells(view_.counts, at[1], at[2]) + at[0]);
  }

  // Particles in the cell, squared and summed over all cells, per particle: how many share a cell
  // with a particle.
  double mean_company() const {
    double sum = 0;
    for (std::size_t c = 0; c < cells(); ++c) {
      const double here = static_cast<double>(first_[c + 1] - first_[c]);
      sum += here * here;
    }
    return particles() == 0 ? 0 : sum / static_cast<double>(particles());
  }

 private:
  static constexpr double least_cells = 64, most_cells_per_particle = 4, most_cells = 4e9;

  // Cells that cover the bounding box; they grow until they are few enough.
  void choose_counts(const PointCloud<S>& cloud) {
    double longest = 0;
    for (int d = 0; d < D; ++d) {
      view_.lower[d] = static_cast<double>(cloud.box().lower[d]);
      view_.upper[d] = static_cast<double>(cloud.box().upper[d]);
      longest = std::max(longest, upper(d) - lower(d));
    }
    const double most = std::min(
        most_cells,
        std::max(least_cells, most_cells_per_particle * static_cast<double>(cloud.size())));
    size_ = std::max(size_, longest / most);
    for (;; size_ *= 1.25) {
      double total = 1;
      for (int d = 0; d < D; ++d) total *= std::floor((upper(d) - lower(d)) / size_) + 1;
      if (total <= most) break;
    }
    for (int d = 0; d < D; ++d)
      view_.counts[d] = static_cast<std::int64_t>((upper(d) - lower(d)) / size_) + 1;
  }

  double size_;
  CellView<S> view_;
  std::vector<ParticleIndex> first_;
  SortedPoints<S, D> sorted_;
};

}  // namespace recon::detail
