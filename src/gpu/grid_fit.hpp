// Linear fits at the points of a grid to particles of a GPU, as reconstruct_on_grid() makes them:
// by the moment matrix where that is safe, and by graded Gram-Schmidt from the particles elsewhere.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>

#include "cuda/fold.hpp"
#include "cuda/grid_moments_on.hpp"

namespace recon::mpm {

template <int D>
using LinearTerms = Monomials<D, 1>;

// Of point after point: the values by the moment matrix, `supported` where there is a particle, and
// `unsafe` where the matrix is not.
template <int D>
struct FitByMoments {
  cuda::NodeWeights<D, double> nodes;
  FitTolerances tolerances;
  int components;
  const double* moments;
  double* values;
  std::uint32_t *supported, *unsafe;

  RECON_DEVICE void operator()(std::size_t node) const {
    constexpr int M = Monomials<D, 2>::size, m = LinearTerms<D>::size;
    using Numbers = std::numeric_limits<double>;
    const double* const from = moments + node * static_cast<std::size_t>(1 + M + components * m);
    double* const to = values + node * static_cast<std::size_t>(components);
    const double weight_sum = from[1];
    for (int c = 0; c < components; ++c) to[c] = 0;
    supported[node] = weight_sum > 0 ? 1 : 0;
    unsafe[node] = supported[node];
    const bool in_range =
        weight_sum >= Numbers::min() / Numbers::epsilon() && weight_sum <= Numbers::max();
    if (!in_range || !(from[0] >= m)) return;
    double x[D];
    nodes.place(node, x);
    MomentMatrix<double, LinearTerms<D>> matrix(tolerances);
    typename MomentMatrix<double, LinearTerms<D>>::Moments chosen{};
    for (std::size_t a = 0; a < chosen.size(); ++a) chosen[a] = from[1 + a];
    if (!matrix.factor(chosen, nodes.noise(x)) || !matrix.gradient_resolved()) return;
    unsafe[node] = 0;
    for (int c = 0; c < components; ++c) {
      std::array<double, m> b{};
      for (int j = 0; j < m; ++j) b[static_cast<std::size_t>(j)] = from[1 + M + c * m + j];
      to[c] = matrix.solve(b)[0];
    }
  }
};

// How many particles have a weight at the points of a list.
template <int D>
struct CountWeighted {
  cuda::CloudView<D, double> cloud;
  cuda::NodeWeights<D, double> nodes;
  const std::uint32_t* list;
  RECON_DEVICE std::uint32_t operator()(std::size_t i) const {
    std::uint32_t count = 0;
    double x[D];
    nodes.place(list[i], x);
    cuda::for_weighted(cloud, nodes, x, [&](const auto&, double, std::uint32_t) { ++count; });
    return count;
  }
};

// The points of a list, by a few workers that share them out (cuda/fit.hpp).
template <int D>
struct FitByParticles {
  using Solve = SafeSolve<double, LinearTerms<D>, Given>;
  cuda::CloudView<D, double> cloud;
  const std::uint32_t* order;
  cuda::NodeWeights<D, double> nodes;
  FitTolerances tolerances;
  cuda::Field<const double> field;
  const std::uint32_t* list;
  std::size_t count, workers;
  std::byte* memory;  // `bytes` for each worker
  std::size_t bytes;
  int most;  // particles of a point
  double* values;
  std::uint32_t* supported;

  static constexpr std::size_t bytes_for(int most) {
    const auto many = static_cast<std::size_t>(most);
    const std::size_t all = Solve::bytes_for(most) + Stencil<double, D, Given>::bytes_for(most) +
                            Workspace::bytes_for<double>(many) +
                            Workspace::bytes_for<std::uint32_t>(many);
    return (all + 255) / 256 * 256;
  }

  RECON_DEVICE void operator()(std::size_t w) const {
    Workspace workspace({memory + w * bytes, bytes});
    const Given given(workspace, most);
    Stencil<double, D, Given> stencil(given);
    Solve solve(Solver::gram_schmidt, tolerances, given);
    const auto many = static_cast<std::size_t>(most);
    double* const phi = workspace.take<double>(many).data();
    std::uint32_t* const found = workspace.take<std::uint32_t>(many).data();
    for (std::size_t i = w; i < count; i += workers) fit(list[i], stencil, solve, phi, found);
  }

  RECON_DEVICE void fit(std::size_t node, Stencil<double, D, Given>& stencil, Solve& solve,
                        double* phi, std::uint32_t* found) const {
    int n = 0;
    double here[D];
    nodes.place(node, here);
    cuda::for_weighted(cloud, nodes, here,
                       [&](const auto&, double, std::uint32_t place) { found[n++] = place; });
    std::array<double, D> x{};
    for (std::size_t d = 0; d < D; ++d) x[d] = here[d] / nodes.rho[d];
    stencil.start(x, 1.0, n);
    for (int d = 0; d < D; ++d) {
      double* const offsets = stencil.offsets(d);
      for (int p = 0; p < n; ++p)
        offsets[p] = (cloud.x[std::size_t{found[p]} * D + static_cast<std::size_t>(d)] - here[d]) /
                     nodes.rho[d];
    }
    stencil.weigh(nodes.weight, nodes.form, false);
    const LocalCloud<double, D> local = stencil.cloud();
    const FitReport report = solve.fit(local);
    supported[node] = report.rank > 0 ? 1 : 0;
    double* const to = values + node * static_cast<std::size_t>(field.components);
    for (int c = 0; c < field.components; ++c) to[c] = 0;
    if (report.rank == 0) return;
    solve.shape_functions(
        local, ShapeArrays<double, D>::in(phi, local.size, Derivative::diffuse, false, false));
    for (int p = 0; p < local.size; ++p) {
      const double* const u =
          field.data +
          static_cast<std::ptrdiff_t>(order[found[stencil.place(p)]]) * field.point_stride;
      for (int c = 0; c < field.components; ++c) to[c] += phi[p] * u[c * field.component_stride];
    }
  }
};

template <class Executor, int D>
class GridFitOn {
  template <class U>
  using Array = typename Executor::template Array<U>;

 public:
  using Sources = cuda::SourcesOn<Executor, D, double>;

  // At the points of `grid`, to fields of so many components of the particles of `sources`.
  GridFitOn(std::shared_ptr<Sources> sources, const StructuredGrid<double>& grid, int components,
            Weight weight)
      : executor_(sources->executor()),
        sources_(sources),
        moments_(std::move(sources), grid, components, {.degree = 1, .weight = weight}),
        components_(components) {
    executor_->provide(values_, grid.size() * static_cast<std::size_t>(components));
    for (auto* array : {&supported_, &unsafe_, &unsafe_at_})
      executor_->provide(*array, grid.size() + 1);
    executor_->provide(list_, grid.size());
  }

  // To the particles where the sources have them now; `data` has their components in a row.
  void fit(const double* data) {
    Executor& run = *executor_;
    const cuda::Field<const double> field{data, sources_->size(), components_};
    const std::size_t count = moments_.nodes();
    moments_.sum(field);
    run.for_each(count, FitByMoments<D>{moments_.weights(), moments_.tolerances(), components_,
                                        moments_.values(), values_.data(), supported_.data(),
                                        unsafe_.data()});
    run.for_each(1, cuda::SetFlag{unsafe_.data() + count});
    run.scan(unsafe_.data(), unsafe_at_.data(), count + 1);
    std::uint32_t unsafe = 0;
    run.to_host(unsafe_at_.data() + count, &unsafe, 1);
    if (unsafe > 0) fit_by_particles(field, unsafe);
  }

  const double* values() const { return values_.data(); }
  // 1 for the points that have a fit.
  const std::uint32_t* supported() const { return supported_.data(); }

 private:
  void fit_by_particles(const cuda::Field<const double>& field, std::size_t unsafe) {
    Executor& run = *executor_;
    run.for_each(moments_.nodes(), cuda::Select{unsafe_.data(), unsafe_at_.data(), list_.data()});
    using Count = CountWeighted<D>;
    const std::uint32_t* const longest = cuda::fold<std::uint32_t>(
        run, longest_, unsafe, Count{sources_->view(), moments_.weights(), list_.data()},
        cuda::Larger{});
    std::uint32_t most = 0;
    run.to_host(longest, &most, 1);
    using Fit = FitByParticles<D>;
    const std::size_t bytes = Fit::bytes_for(static_cast<int>(most));
    const std::size_t fewest = cuda::least_of<std::size_t>(unsafe, Executor::fewest_workers);
    const std::size_t workers =
        cuda::least_of(unsafe, cuda::most_of(fewest, Executor::bytes_of_workers / bytes));
    run.provide(memory_, workers * bytes);
    run.for_each(workers,
                 Fit{sources_->view(), sources_->order(), moments_.weights(), moments_.tolerances(),
                     field, list_.data(), unsafe, workers, memory_.data(), bytes,
                     static_cast<int>(most), values_.data(), supported_.data()});
  }

  std::shared_ptr<Executor> executor_;
  std::shared_ptr<Sources> sources_;
  cuda::GridMomentsOn<Executor, D, double, cuda::Degrees<1>> moments_;
  int components_;
  Array<double> values_;
  Array<std::uint32_t> supported_, unsafe_, unsafe_at_, list_, longest_;
  Array<std::byte> memory_;
};

}  // namespace recon::mpm
