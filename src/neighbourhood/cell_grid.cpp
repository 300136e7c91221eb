#include "recon/neighbourhood/cell_grid.hpp"

#include "core/instantiate.hpp"
#include "neighbourhood/cells.hpp"
#include "neighbourhood/query.hpp"

namespace recon {

namespace {

using detail::CellIndex;

constexpr double particles_per_cell = 2;  // where the density chooses the cells

}  // namespace

template <class S, int D>
struct CellGrid<S, D>::Grid : detail::Cells<S, D> {
  // take(x_p, index) for all in the cells from..to of the row (., j, k); they lie side by side in
  // memory.
  template <class Take>
  void visit_row(std::int64_t from, std::int64_t to, std::int64_t j, std::int64_t k,
                 Take& take) const {
    const std::int64_t row = detail::row_of_cells(this->view().counts, j, k);
    const ParticleIndex end = this->view().first[row + to + 1];
    for (ParticleIndex p = this->view().first[row + from]; p < end; ++p)
      take(this->point(p), this->index(p));
  }

  // take(x_p, index) for all in the cells that the box [low, high] overlaps.
  template <class Take>
  void visit_box(const Point& low, const Point& high, Take take) const {
    CellIndex from{}, to{};
    for (int d = 0; d < D; ++d) {
      from[d] = this->cell(low[d], d);
      to[d] = this->cell(high[d], d);
    }
    for (std::int64_t k = from[2]; k <= to[2]; ++k)
      for (std::int64_t j = from[1]; j <= to[1]; ++j) visit_row(from[0], to[0], j, k, take);
  }

  // take(x_p, index) for all in the cells that are `shell` cells away from the centre (maximum over
  // axes).
  template <class Take>
  void visit_shell(const CellIndex& centre, std::int64_t shell, Take take) const {
    CellIndex from, to;
    for (int d = 0; d < max_dimension; ++d) {
      from[d] = std::max<std::int64_t>(centre[d] - shell, 0);
      to[d] = std::min(centre[d] + shell, this->count(d) - 1);
    }
    for (std::int64_t k = from[2]; k <= to[2]; ++k)
      for (std::int64_t j = from[1]; j <= to[1]; ++j) {
        const bool face = std::abs(k - centre[2]) == shell || std::abs(j - centre[1]) == shell;
        if (face) {
          visit_row(from[0], to[0], j, k, take);
        } else {
          if (centre[0] - shell >= 0) visit_row(from[0], from[0], j, k, take);
          if (centre[0] + shell < this->count(0)) visit_row(to[0], to[0], j, k, take);
        }
      }
  }

  // Nothing outside the shells 0..shell is nearer to x than this (squared); infinite if nothing is
  // left. The distance to the nearest border of the visited cells, together with the distance to
  // the bounding box along the other axes; lowered by what rounding can do.
  double unvisited_distance2(const Point& x, const CellIndex& centre, std::int64_t shell) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double nearest = infinity, outside[D], total = 0;
    for (int d = 0; d < D; ++d) {
      const double at = static_cast<double>(x[d]);
      outside[d] = std::max({0.0, this->lower(d) - at, at - this->upper(d)});
      total += outside[d] * outside[d];
    }
    for (int d = 0; d < D; ++d) {
      const double at = static_cast<double>(x[d]);
      double side = infinity;
      if (centre[d] - shell > 0)
        side = at - (this->lower(d) + static_cast<double>(centre[d] - shell) * this->size());
      if (centre[d] + shell + 1 < this->count(d))
        side = std::min(
            side, this->lower(d) + static_cast<double>(centre[d] + shell + 1) * this->size() - at);
      if (side == infinity) continue;
      side -= 16 * std::numeric_limits<double>::epsilon() *
              (std::abs(this->lower(d)) + std::abs(this->upper(d)) + std::abs(at));
      side = std::max(side, outside[d]);
      nearest = std::min(nearest, total - outside[d] * outside[d] + side * side);
    }
    return nearest * (1 - static_cast<double>(detail::bound_slack<S>)) -
           static_cast<double>(std::numeric_limits<S>::min());
  }
};

template <class S, int D>
CellGrid<S, D>::CellGrid(const PointCloud<S>& points)
    : CellGrid(points, detail::density_cell_size(points, particles_per_cell)) {}
template <class S, int D>
CellGrid<S, D>::CellGrid(const PointCloud<S>& points, double cell_size, int threads)
    : grid_(std::make_unique<Grid>()) {
  grid_->build(points, cell_size, threads);
}
template <class S, int D>
CellGrid<S, D>::CellGrid(CellGrid&&) noexcept = default;
template <class S, int D>
CellGrid<S, D>& CellGrid<S, D>::operator=(CellGrid&&) noexcept = default;
template <class S, int D>
CellGrid<S, D>::~CellGrid() = default;

template <class S, int D>
std::size_t CellGrid<S, D>::size() const {
  return grid_->particles();
}
template <class S, int D>
double CellGrid<S, D>::cell_size() const {
  return grid_->size();
}
template <class S, int D>
std::size_t CellGrid<S, D>::cells() const {
  return grid_->cells();
}

template <class S, int D>
const detail::Cells<S, D>& CellGrid<S, D>::sorted_cells() const {
  return *grid_;
}
template <class S, int D>
detail::Cells<S, D>& CellGrid<S, D>::sorted_cells() {
  return *grid_;
}

template <class S, int D>
void CellGrid<S, D>::within(const Point& x, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  found.clear();
  const S half = reach(radius), radius2 = radius * radius;
  Point low, high;
  for (int d = 0; d < D; ++d) {
    low[d] = x[d] - half;
    high[d] = x[d] + half;
  }
  grid_->visit_box(low, high, [&](const Point& particle, ParticleIndex index) {
    const S distance2 = squared_distance(x, particle);
    if (distance2 <= radius2) found.push_back({index, distance2});
  });
  detail::sort_by_index(found);
}

template <class S, int D>
void CellGrid<S, D>::nearest(const Point& x, std::size_t k, Found& found) const {
  nearest_within(x, k, std::numeric_limits<S>::max(), found);
}

template <class S, int D>
void CellGrid<S, D>::nearest_within(const Point& x, std::size_t k, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  detail::NearestSet<S> set(found, std::min(k, size()), radius * radius);
  if (k == 0 || size() == 0) return;
  const CellIndex centre = grid_->cell_index(x);
  double unvisited = 0;
  for (std::int64_t shell = 0; unvisited <= static_cast<double>(set.worst()); ++shell) {
    grid_->visit_shell(centre, shell, [&](const Point& particle, ParticleIndex index) {
      set.offer(index, squared_distance(x, particle));
    });
    unvisited = grid_->unvisited_distance2(x, centre, shell);
    if (std::isinf(unvisited)) break;
  }
  set.sort();
}

template <class S, int D>
void CellGrid<S, D>::in_box(const Point& lower, const Point& upper, Found& found) const {
  detail::require_finite(lower, "lower corner");
  detail::require_finite(upper, "upper corner");
  found.clear();
  grid_->visit_box(lower, upper, [&](const Point& particle, ParticleIndex index) {
    if (detail::inside(particle, lower, upper)) found.push_back({index, 0});
  });
  detail::sort_by_index(found);
}

#define RECON_INSTANTIATE(S, D) template class CellGrid<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon
