// Particles sorted into a regular grid of cells: what CellGrid and the batch search both stand on.
//
// The particles of a cell lie side by side, by ascending index. The cells of a row (along x) follow
// one another in memory, so a stretch of a row is one stretch of particles. Rows come in bands:
// row(j, k) runs through `band` rows in y for every k before it goes on to the next band. So a sweep
// through the cells of a large grid touches a few planes of a band at a time, which stay in the
// cache. Building costs O(n + cells), in parallel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/counting_sort.hpp"
#include "neighbourhood/cell_kernel.hpp"
#include "neighbourhood/cell_size.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

using CellIndex = std::array<std::int64_t, max_dimension>;  // axes that do not exist have index 0

// The edge of cells that hold `particles_per_cell` particles on average over the bounding box.
template <class Scalar>
double density_cell_size(const PointCloud<Scalar>& points, double particles_per_cell) {
  return size_of_cells(points.size(), points.dimension(), particles_per_cell, [&](int d) {
    return static_cast<double>(points.box().upper[d]) - static_cast<double>(points.box().lower[d]);
  });
}

template <class S, int D>
class Cells {
 public:
  using Point = std::array<S, D>;

  Cells() = default;
  Cells(const Cells&) = delete;
  Cells& operator=(const Cells&) = delete;

  // Sorts the points anew, into the memory that there is. Throws InvalidArgument for a cell size
  // that is not positive and finite.
  void build(const PointCloud<S>& cloud, double cell_size, int threads) {
    require(cell_size > 0 && std::isfinite(cell_size), "cell_size", cell_size,
            "must be positive and finite");
    require(cloud.dimension() == D, "dimension of the points", cloud.dimension(),
            "must be the dimension of the search");
    view_ = {};
    size_ = std::max(cell_size, 4 * std::numeric_limits<double>::min());
    if (cloud.size() > 0) choose_counts(cloud);
    view_.size = size_;
    view_.inverse = 1 / size_;
    const std::size_t n = cloud.size();
    const std::span<std::uint32_t> key = sort_.keys(n);
    recon::parallel_blocks(n, points_per_block, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        key[i] = static_cast<std::uint32_t>(cell_of(cloud.template point<D>(i)));
    });
    sort_.sort(cells(), threads);
    points_.assign_permuted(cloud, sort_.order(), threads);
    make_coarse(threads);
    index_ = sort_.order();
    double squares = 0;
    for (std::size_t c = 0; c < cells(); ++c) {
      const double here = static_cast<double>(sort_.first()[c + 1] - sort_.first()[c]);
      squares += here * here;
    }
    mean_company_ = n == 0 ? 0 : squares / static_cast<double>(n);
    view_.first = sort_.first().data();
  }

  // Gives back what only collect() reads of the view and what only the next build() would use.
  void forget_coarse() {
    for (auto& axis : x_) axis = Array<Coarse<S>>();  // = {} would keep the memory
    forget_scratch();
  }
  void forget_scratch() { sort_.forget_scratch(); }
  // Makes what collect() reads where it has been given back. For one thread at a time.
  void bring_coarse(int threads) const {
    if (x_[0].empty()) make_coarse(threads);
  }

  // From now on particles are numbered by their places; those in order() keep the numbers that they
  // had.
  void number_by_place() { index_ = {}; }
  bool numbered_by_place() const { return index_.empty(); }
  // The number in the cloud of the particle at each place.
  std::span<const std::uint32_t> order() const { return sort_.order(); }

  std::size_t particles() const { return points_.size(); }
  // The particles by place.
  const PointCloud<S>& points() const { return points_; }
  double size() const { return size_; }  // edge of a cell
  double lower(int d) const { return view_.lower[d]; }
  double upper(int d) const { return view_.upper[d]; }
  std::int64_t count(int d) const { return view_.counts[d]; }
  std::size_t cells() const {
    return static_cast<std::size_t>(count(0)) * static_cast<std::size_t>(count(1)) *
           static_cast<std::size_t>(count(2));
  }
  const CellView<S>& view() const { return view_; }
  Point point(std::size_t place) const { return points_.template point<D>(place); }
  ParticleIndex index(std::size_t place) const {
    return index_.empty() ? static_cast<ParticleIndex>(place) : index_[place];
  }

  // A coordinate along an axis, anywhere, on the scale of Coarse<S>.
  double on_coarse_scale(S x, int d) const {
    if constexpr (std::is_same_v<S, float>) return static_cast<double>(x);
    return (x - view_.lower[d]) * view_.units;
  }

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

  // How many particles share the cell of a particle, on average over the particles.
  double mean_company() const { return mean_company_; }

 private:
  void make_coarse(int threads) const {
    const std::size_t n = particles();
    for (auto& axis : x_) axis.resize(n + padding);
    recon::parallel_blocks(n, points_per_block, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p)
        for (int d = 0; d < D; ++d) x_[d][p] = coarse(points_(p, d), d);
    });
    for (auto& axis : x_)
      std::fill_n(axis.begin() + static_cast<std::ptrdiff_t>(n), padding, Coarse<S>(0));
    for (int d = 0; d < D; ++d) view_.x[d] = x_[d].data();
  }

  // Of a coordinate in the box of the particles.
  Coarse<S> coarse(S x, int d) const {
    if constexpr (std::is_same_v<S, float>) return x;
    return static_cast<Coarse<S>>(on_coarse_scale(x, d) + 0.5);
  }

  static constexpr std::size_t padding = 16, points_per_block = 16384;

  // Cells that cover the bounding box; they grow until they are few enough.
  void choose_counts(const PointCloud<S>& cloud) {
    const auto extent = [&](int d) { return upper(d) - lower(d); };
    double longest = 0;
    for (int d = 0; d < D; ++d) {
      view_.lower[d] = static_cast<double>(cloud.box().lower[d]);
      view_.upper[d] = static_cast<double>(cloud.box().upper[d]);
      longest = std::max(longest, extent(d));
    }
    if constexpr (!std::is_same_v<S, float>)
      view_.units = std::min(longest > 0 ? units_of_extent / longest : 1, 1e300);
    size_ = cover_with_cells(size_, cloud.size(), D, extent, view_.counts);
  }

  double size_ = 1, mean_company_ = 0;
  mutable CellView<S> view_;
  CountingSort sort_;
  PointCloud<S> points_;
  mutable std::array<Array<Coarse<S>>, D> x_;  // longer than the particles by `padding`
  std::span<const ParticleIndex> index_{};     // empty: particles are numbered by their places
};

}  // namespace recon::detail
