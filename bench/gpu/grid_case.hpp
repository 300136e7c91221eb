// The grid velocity workload of README.md on the GPU: moments of degree 1 at the nodes, cubic
// B-splines, 8 particles in a cell, three components; checked against recon::GridMoments.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "flops.hpp"
#include "gpu.hpp"
#include "recon/cuda/grid_moments.hpp"
#include "recon/grid/grid_moments.hpp"
#include "recon/points/make_view.hpp"

namespace recon_gpu {

// Whether the GPU has computed what the library computes: the sums to n eps of the sum of their
// terms' sizes for n particles, solved values to 64 eps a / s as elsewhere. A row of the report.
template <class T>
bool run_grid(const Machine& machine, std::size_t cells, std::ostream& report) {
  constexpr int D = 3, components = 3;
  const std::size_t n = 8 * cells * cells * cells;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> in(0, 1);
  std::vector<std::array<T, D>> places(n);
  std::vector<T> x, u;
  for (auto& place : places) {
    for (T& axis : place) axis = static_cast<T>(in(random));
    x.insert(x.end(), place.begin(), place.end());
    for (int c = 0; c < components; ++c)
      u.push_back(static_cast<T>(std::sin(3 * static_cast<double>(place[c]) + c)));
  }
  recon::StructuredGrid<T> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) {
    grid.spacing[d] = T(1) / static_cast<T>(cells);
    grid.counts[d] = cells + 1;
  }
  recon::Options options;
  options.degree = 1;
  options.weight = recon::Weight::cubic_b_spline;

  OnGpu<T> x_there(x), u_there(u);
  recon::cuda::Sources<D, T> sources({x_there.data(), n});
  recon::cuda::GridMoments<D, T> moments(sources, grid, components, options);
  const std::size_t nodes = moments.nodes(),
                    per_node = static_cast<std::size_t>(moments.per_node());
  OnGpu<T> values(nodes * components);
  const recon::cuda::Field<const T> field{u_there.data(), n, components};
  const recon::cuda::Field<T> out{values.data(), nodes, components};
  moments.sum(field);
  moments.solve(out);
  sources.check();
  const auto first = fetch(moments.values(), nodes * per_node);
  const double order = time_of([&] { sources.update({x_there.data(), n}); });
  const double sum = time_of([&] { moments.sum(field); });
  const double solve = time_of([&] { moments.solve(out); });
  const auto sums = fetch(moments.values(), nodes * per_node);
  const auto solved = fetch(values.data(), nodes * components);
  const auto reports = fetch(moments.reports(), nodes);
  const bool same_bits = std::memcmp(first.data(), sums.data(), sums.size() * sizeof(T)) == 0;

  const recon::FieldView<T> velocity = recon::field_of_flat(u, components);
  const recon::BasicGridMoments<T> library(recon::points_of(places), {velocity}, grid, options);
  const auto fit = library.solve();
  const std::span<const T> expected = library.values();
  const auto wanted = [&](std::size_t i, std::size_t j) {
    return static_cast<double>(expected[i * per_node + j]);
  };
  constexpr auto eps = static_cast<double>(std::numeric_limits<T>::epsilon());
  double of_rounding = 0, pairs = 0;
  std::size_t other_reports = 0;
  for (std::size_t i = 0; i < nodes; ++i) {
    const double count = wanted(i, 0), weights = wanted(i, 1);
    pairs += count;
    for (std::size_t j = 1; j < per_node; ++j) {
      const double off = std::abs(static_cast<double>(sums[i * per_node + j]) - wanted(i, j));
      const double bound = std::max(1.0, count) * eps * weights;
      if (!(off <= 1e-300)) of_rounding = std::fmax(of_rounding, off / bound);
      if (std::isnan(off)) of_rounding = HUGE_VAL;
    }
    const recon::FitReport &ours = reports[i], &theirs = fit.report()[i];
    if (ours.degree != theirs.degree || ours.status != theirs.status ||
        ours.neighbours != theirs.neighbours) {
      ++other_reports;
      continue;
    }
    const double bound = 64 * eps * std::max(1.0, static_cast<double>(theirs.amplification)) /
                         std::max(1e-300, static_cast<double>(theirs.smallest_pivot));
    for (int c = 0; c < components; ++c) {
      const auto value = static_cast<double>(fit.values()(static_cast<Eigen::Index>(i), c));
      const auto own = static_cast<double>(solved[i * components + static_cast<std::size_t>(c)]);
      if (std::isnan(value) && std::isnan(own)) continue;
      of_rounding =
          std::isnan(own) ? HUGE_VAL : std::max(of_rounding, std::abs(own - value) / bound);
    }
  }
  const bool good = of_rounding <= 1 && same_bits && other_reports <= 1 + nodes / 100'000;

  const double each = 1e9 / static_cast<double>(n), all = order + sum + solve;
  const double flops =
      pairs * (recon_bench::grid_flops_per_pair(D, components) + D * recon_bench::weight_flops);
  const double solved_bytes =
      static_cast<double>(nodes) *
      (static_cast<double>(per_node + components) * sizeof(T) + sizeof(recon::FitReport));
  const char* precision = sizeof(T) == 8 ? "double" : "float";
  char line[256];
  std::snprintf(line, sizeof line, "| %s | %.2f | %.2f | %.2f | %s | %.2f | %s |\n", precision,
                all * each, order * each, sum * each,
                percent(flops / sum, machine.peak<T>()).c_str(), solve * each,
                percent(solved_bytes / solve, machine.bytes).c_str());
  report << line;
  std::snprintf(line, sizeof line,
                "%-28s %-6s %s: %zu nodes compared, other reports %zu, numbers within %.3f of what "
                "rounding may do, %s\n",
                "grid velocity, degree 1", precision, good ? "good" : "NOT GOOD", nodes,
                other_reports, of_rounding,
                same_bits ? "the same bits again" : "OTHER BITS in a second run");
  std::cout << line << std::flush;
  return good;
}

}  // namespace recon_gpu
