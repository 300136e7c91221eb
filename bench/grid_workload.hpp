// The grid workload: jittered particles, 8 (or another cube) in each cell of the unit cube; a velocity to the nodes
// with cubic, or a stress and a density to the cell centres with quadratic B-splines (tensor
// products), degree 1.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "recon/grid/grid_moments.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"

namespace recon_bench {

struct GridSetting {
  const char* name;
  bool at_nodes;
  recon::Weight weight;
  int components, nodes_per_axis;  // that one particle counts at
};
inline constexpr GridSetting grid_settings[] = {
    {"velocity to nodes, cubic", true, recon::Weight::cubic_b_spline, 3, 4},
    {"stress and density to cell centres, quadratic", false, recon::Weight::quadratic_b_spline, 7,
     3}};

template <class Scalar>
class GridWorkload {
 public:
  using Point = std::array<Scalar, 3>;
  using Field = double (*)(const Point&, int component);

  // (per_axis cells)^3 particles that carry a field. uneven: their places are x^2 along each axis,
  // so that cells at the origin have hundreds of them and those at the other end few.
  GridWorkload(const GridSetting& setting, std::size_t cells, Field field = &linear,
               std::size_t per_axis = 2, bool uneven = false)
      : setting_(setting),
        points_(recon::jittered_points<Scalar, 3>(per_axis * cells, jitter, seed)),
        values_(points_.size() * static_cast<std::size_t>(setting.components)) {
    if (uneven)
      for (Point& x : points_)
        for (Scalar& c : x) c *= c;
    const Scalar spacing = 1 / static_cast<Scalar>(cells);
    grid_ = {3, {0, 0, 0}, {spacing, spacing, spacing}, {cells + 1, cells + 1, cells + 1}};
    if (!setting.at_nodes) grid_ = recon::cell_centres(grid_);
    for (std::size_t p = 0; p < points_.size(); ++p)
      for (int c = 0; c < setting.components; ++c)
        values_[index(p, c)] = static_cast<Scalar>(field(points_[p], c));
  }

  std::size_t particles() const { return points_.size(); }
  const recon::PointList<Scalar, 3>& places() const { return points_; }
  // Where the field is a velocity.
  std::vector<Point> velocities() const {
    std::vector<Point> u(points_.size());
    for (std::size_t p = 0; p < u.size(); ++p)
      for (int c = 0; c < 3; ++c) u[p][static_cast<std::size_t>(c)] = values_[index(p, c)];
    return u;
  }
  const recon::StructuredGrid<Scalar>& grid() const { return grid_; }

  recon::Options options(int threads, recon::InstructionSet set) const {
    recon::Options options;
    options.degree = 1;
    options.weight = setting_.weight;
    options.threads = threads;
    options.instruction_set = set;
    return options;
  }

  auto reconstruct(int threads,
                   recon::InstructionSet set = recon::InstructionSet::automatic) const {
    return recon::reconstruct_on_grid(points(), fields(), grid_, options(threads, set));
  }
  auto moments(int threads) const {
    return recon::BasicGridMoments<Scalar>(points(), fields(), grid_,
                                           options(threads, recon::InstructionSet::automatic));
  }

  // What degree 1 must reproduce at the nodes, and what it must not.
  static double curved(const Point& x, int component) { return std::sin(5 * linear(x, component)); }
  static double linear(const Point& x, int component) {
    return 1 + component + (2 - component) * static_cast<double>(x[0]) +
           3 * static_cast<double>(x[1]) - 0.5 * component * static_cast<double>(x[2]);
  }

  recon::PointsView<Scalar> points() const { return recon::points_of(points_); }
  // One field of 3 components, or one of 6 and one of 1, in one array.
  std::vector<recon::FieldView<Scalar>> fields() const {
    constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Scalar));
    const std::ptrdiff_t stride = setting_.components * bytes;
    const auto field = [&](int first, int count) {
      return recon::FieldView<Scalar>(points_.size(), count, values_.data() + first, stride, bytes);
    };
    if (setting_.components == 3) return {field(0, 3)};
    return {field(0, 6), field(6, 1)};
  }

 private:
  static constexpr double jitter = 0.4;
  static constexpr std::uint64_t seed = 1;

  std::size_t index(std::size_t particle, int component) const {
    return particle * static_cast<std::size_t>(setting_.components) +
           static_cast<std::size_t>(component);
  }

  GridSetting setting_;
  recon::PointList<Scalar, 3> points_;
  std::vector<Scalar> values_;
  recon::StructuredGrid<Scalar> grid_;
};

}  // namespace recon_bench
