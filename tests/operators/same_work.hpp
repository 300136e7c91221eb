// The same work from several threads: everything that a program may do with recon at once.
#pragma once

#include <array>
#include <cstring>
#include <vector>

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"

namespace recon::testing {

struct SameWork {
  std::vector<std::array<double, 2>> points = random_points<double, 2>(3000, 1);
  std::vector<std::array<double, 2>> moved = random_points<double, 2>(3000, 2);
  std::vector<std::array<double, 2>> targets = random_points<double, 2>(1500, 3);
  std::vector<double> field = [] {
    RandomNumbers random(4);
    std::vector<double> u(3000);
    for (double& value : u) value = random.uniform(-1, 1);
    return u;
  }();
  StructuredGrid<double> grid = grid_covering();
  Sources shared_sources{points_of(points)};
  Reconstruction shared_fit = reconstruct(points_of(points), points_of(targets), {.degree = 2});

  static StructuredGrid<double> grid_covering() {
    StructuredGrid<double> grid;
    grid.dimension = 2;
    grid.origin = {0, 0, 0};
    grid.spacing = {0.05, 0.05, 1};
    grid.counts = {21, 21, 1};
    return grid;
  }

  static void add(std::vector<double>& all, const Eigen::MatrixXd& values) {
    all.insert(all.end(), values.data(), values.data() + values.size());
  }
  void add(std::vector<double>& all, const Reconstruction& fit) const {
    const std::vector<double> at_targets(targets.size(), 0.75);
    add(all, fit.apply(field_of(field)));
    add(all, fit.apply_transpose(field_of(at_targets)));
    add(all, fit.gradient().apply(field_of(field)));
    for (const std::uint32_t index : fit.neighbours().indices) all.push_back(index);
    for (std::size_t t = 0; t < fit.report().size(); ++t)
      all.push_back(static_cast<double>(fit.report()[t].amplification));
  }

  // All that comes out, in one row.
  std::vector<double> results() const {
    std::vector<double> all;
    add(all, shared_fit);
    add(all, reconstruct(shared_sources, points_of(targets), {.degree = 1}));
    Sources own(points_of(points));
    Reconstruction fit =
        reconstruct(own, points_of(targets), {.degree = 1, .neighbours = Radius{0.07}});
    own.update(points_of(moved));
    fit.update(points_of(targets));
    add(all, fit);
    add(all, reconstruct_on_grid(points_of(points), {field_of(field)}, grid).values());
    return all;
  }
};

inline bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace recon::testing
