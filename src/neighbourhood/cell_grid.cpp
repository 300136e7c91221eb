#include "recon/neighbourhood/cell_grid.hpp"

#include "neighbourhood/query.hpp"

namespace recon {

namespace {

constexpr double particles_per_cell = 2;  // where the density chooses the cells
constexpr double least_cells = 64, most_cells_per_particle = 4;

using CellIndex = std::array<std::int64_t, max_dimension>;  // axes that do not exist have index 0

template <class Scalar>
double density_cell_size(const Box<Scalar>& box, std::size_t count, int dimension) {
  double log_volume = 0;
  int axes = 0;
  for (int d = 0; d < dimension && count > 0; ++d) {
    const double extent = static_cast<double>(box.upper[d]) - static_cast<double>(box.lower[d]);
    if (!(extent > 0)) continue;
    log_volume += std::log(extent);
    ++axes;
  }
  if (axes == 0) return 1;  // all in one place
  const double size =
      std::exp((log_volume + std::log(particles_per_cell / static_cast<double>(count))) / axes);
  return std::max(size, std::numeric_limits<double>::min());
}

}  // namespace

template <class S, int D>
struct CellGrid<S, D>::Grid {
  // A particle, kept with those of the same cell and, within a cell, by ascending index.
  struct Particle {
    Point x;
    ParticleIndex index;
  };

  double size = 1;  // edge of a cell
  std::array<double, max_dimension> lower{}, upper{};
  CellIndex counts{1, 1, 1};
  std::vector<Particle> particles;
  std::vector<ParticleIndex> first;  // of cell c; first[c + 1] is one behind its last

  Grid(const PointCloud<S>& cloud, double cell_size) : size(cell_size) {
    require(cell_size > 0 && std::isfinite(cell_size), "cell_size", cell_size,
            "must be positive and finite");
    if (cloud.size() > 0) choose_counts(cloud);
    sort(detail::gathered<D>(cloud));
  }

  // Cells that cover the bounding box; they grow until they are few enough.
  void choose_counts(const PointCloud<S>& cloud) {
    double longest = 0;
    for (int d = 0; d < D; ++d) {
      lower[d] = static_cast<double>(cloud.box().lower[d]);
      upper[d] = static_cast<double>(cloud.box().upper[d]);
      longest = std::max(longest, upper[d] - lower[d]);
    }
    const double most =
        std::max(least_cells, most_cells_per_particle * static_cast<double>(cloud.size()));
    size = std::max(size, longest / most);
    for (;; size *= 1.25) {
      double total = 1;
      for (int d = 0; d < D; ++d) total *= std::floor((upper[d] - lower[d]) / size) + 1;
      if (total <= most) break;
    }
    for (int d = 0; d < D; ++d)
      counts[d] = static_cast<std::int64_t>((upper[d] - lower[d]) / size) + 1;
  }

  void sort(const std::vector<Point>& points) {
    first.assign(static_cast<std::size_t>(counts[0] * counts[1] * counts[2]) + 1, 0);
    for (const Point& x : points) ++first[cell_of(x) + 1];
    for (std::size_t c = 1; c < first.size(); ++c) first[c] += first[c - 1];
    std::vector<ParticleIndex> next(first.begin(), first.end() - 1);
    particles.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      particles[next[cell_of(points[i])]++] = {points[i], static_cast<ParticleIndex>(i)};
  }

  // The cell of a coordinate along an axis; those outside count to the border cells. Never
  // decreases with x, in spite of rounding: so p in [a, b] lies in a cell from cell(a) to cell(b).
  std::int64_t cell(S x, int d) const {
    const double at = (static_cast<double>(x) - lower[d]) / size;
    if (!(at > 0)) return 0;
    return at < static_cast<double>(counts[d]) ? static_cast<std::int64_t>(at) : counts[d] - 1;
  }
  std::size_t cell_of(const Point& x) const {
    std::int64_t c = 0;
    for (int d = D - 1; d >= 0; --d) c = c * counts[d] + cell(x[d], d);
    return static_cast<std::size_t>(c);
  }

  // take(particle) for all in the cells from..to of the row (., j, k); they lie side by side in
  // memory.
  template <class Take>
  void visit_row(std::int64_t from, std::int64_t to, std::int64_t j, std::int64_t k,
                 Take& take) const {
    const std::int64_t row = (k * counts[1] + j) * counts[0];
    const ParticleIndex end = first[static_cast<std::size_t>(row + to + 1)];
    for (ParticleIndex p = first[static_cast<std::size_t>(row + from)]; p < end; ++p)
      take(particles[p]);
  }

  // take(particle) for all in the cells that the box [low, high] overlaps.
  template <class Take>
  void visit_box(const Point& low, const Point& high, Take take) const {
    CellIndex from{}, to{};
    for (int d = 0; d < D; ++d) {
      from[d] = cell(low[d], d);
      to[d] = cell(high[d], d);
    }
    for (std::int64_t k = from[2]; k <= to[2]; ++k)
      for (std::int64_t j = from[1]; j <= to[1]; ++j) visit_row(from[0], to[0], j, k, take);
  }

  // take(particle) for all in the cells that are `shell` cells away from the centre (maximum over
  // axes).
  template <class Take>
  void visit_shell(const CellIndex& centre, std::int64_t shell, Take take) const {
    CellIndex from, to;
    for (int d = 0; d < max_dimension; ++d) {
      from[d] = std::max<std::int64_t>(centre[d] - shell, 0);
      to[d] = std::min(centre[d] + shell, counts[d] - 1);
    }
    for (std::int64_t k = from[2]; k <= to[2]; ++k)
      for (std::int64_t j = from[1]; j <= to[1]; ++j) {
        const bool face = std::abs(k - centre[2]) == shell || std::abs(j - centre[1]) == shell;
        if (face) {
          visit_row(from[0], to[0], j, k, take);
        } else {
          if (centre[0] - shell >= 0) visit_row(from[0], from[0], j, k, take);
          if (centre[0] + shell < counts[0]) visit_row(to[0], to[0], j, k, take);
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
      outside[d] = std::max({0.0, lower[d] - at, at - upper[d]});
      total += outside[d] * outside[d];
    }
    for (int d = 0; d < D; ++d) {
      const double at = static_cast<double>(x[d]);
      double side = infinity;
      if (centre[d] - shell > 0)
        side = at - (lower[d] + static_cast<double>(centre[d] - shell) * size);
      if (centre[d] + shell + 1 < counts[d])
        side = std::min(side, lower[d] + static_cast<double>(centre[d] + shell + 1) * size - at);
      if (side == infinity) continue;
      side -= 16 * std::numeric_limits<double>::epsilon() *
              (std::abs(lower[d]) + std::abs(upper[d]) + std::abs(at));
      side = std::max(side, outside[d]);
      nearest = std::min(nearest, total - outside[d] * outside[d] + side * side);
    }
    return nearest * (1 - static_cast<double>(detail::bound_slack<S>)) -
           static_cast<double>(std::numeric_limits<S>::min());
  }
};

template <class S, int D>
CellGrid<S, D>::CellGrid(const PointCloud<S>& points)
    : CellGrid(points, density_cell_size(points.box(), points.size(), points.dimension())) {}
template <class S, int D>
CellGrid<S, D>::CellGrid(const PointCloud<S>& points, double cell_size)
    : grid_(std::make_unique<Grid>(points, cell_size)) {}
template <class S, int D>
CellGrid<S, D>::CellGrid(CellGrid&&) noexcept = default;
template <class S, int D>
CellGrid<S, D>& CellGrid<S, D>::operator=(CellGrid&&) noexcept = default;
template <class S, int D>
CellGrid<S, D>::~CellGrid() = default;

template <class S, int D>
std::size_t CellGrid<S, D>::size() const {
  return grid_->particles.size();
}
template <class S, int D>
double CellGrid<S, D>::cell_size() const {
  return grid_->size;
}
template <class S, int D>
std::size_t CellGrid<S, D>::cells() const {
  return grid_->first.size() - 1;
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
  grid_->visit_box(low, high, [&](const auto& particle) {
    const S distance2 = squared_distance(x, particle.x);
    if (distance2 <= radius2) found.push_back({particle.index, distance2});
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
  CellIndex centre{};
  for (int d = 0; d < D; ++d) centre[d] = grid_->cell(x[d], d);
  double unvisited = 0;
  for (std::int64_t shell = 0; unvisited <= static_cast<double>(set.worst()); ++shell) {
    grid_->visit_shell(centre, shell, [&](const auto& particle) {
      set.offer(particle.index, squared_distance(x, particle.x));
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
  grid_->visit_box(lower, upper, [&](const auto& particle) {
    if (detail::inside(particle.x, lower, upper)) found.push_back({particle.index, 0});
  });
  detail::sort_by_index(found);
}

template class CellGrid<float, 1>;
template class CellGrid<float, 2>;
template class CellGrid<float, 3>;
template class CellGrid<double, 1>;
template class CellGrid<double, 2>;
template class CellGrid<double, 3>;

}  // namespace recon
