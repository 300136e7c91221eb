#include "recon/grid/reconstruct_on_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grid/by_lists.hpp"
#include "grid/node_fit.hpp"
#include "neighbourhood/cloud.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

constexpr std::size_t particles_per_block = 16384;

// A unit of mass must not take the sums out of the range of numbers.
double scale_of(std::span<const double> weights) {
  if (weights.empty()) return 1;
  const double largest = *std::max_element(weights.begin(), weights.end());
  constexpr int most = std::numeric_limits<double>::max_exponent - 1;
  return std::ldexp(1.0, std::min(-std::ilogb(largest), most));
}

template <class Scalar>
BasicGridReconstruction<Scalar> by_moments(ParticleData<Scalar> particles,
                                           const StructuredGrid<Scalar>& grid,
                                           const Options& options, const GridApply& apply) {
  const GridPlan<Scalar> plan(grid, options, particles.components());
  const ParticleBins bins(particles, plan);
  particles.weight_scale = scale_of(particles.weights);
  NodeFits<Scalar> fits(plan, apply.gradients.has_value());
  const LaneLayout lanes = LaneLayout::of(plan);
  sweep<Scalar>(particles, bins, plan, options.progress, [&] {
    return [solver = std::make_shared<RowSolver<Scalar>>(plan, lanes, fits)](
               const FinishedRow<Scalar>& row) { (*solver)(row); };
  });
  fit_from_particles(particles, bins, plan, fits.unsafe(), fits);
  LimitCount limited;
  if (apply.limit != Limit::none) limited = limit_nodes(particles, bins, plan, apply.limit, fits);
  return {std::move(fits.values), std::move(fits.gradients),
          FitReports(std::move(fits.reports), Solver::moment_matrix), std::move(limited)};
}

template <class Scalar>
BasicGridReconstruction<Scalar> of_points(const PointsView<Scalar>& points,
                                          const std::vector<FieldView<Scalar>>& fields,
                                          const StructuredGrid<Scalar>& grid,
                                          const Options& options, const GridApply& apply) {
  options.validate();
  apply.validate();
  grid.validate();
  const ParticleData<Scalar> particles{points, fields, options.particle_weights};
  particles.validate(grid.dimension, options.threads);
  if (!beyond_moments(grid, options, apply)) return by_moments(particles, grid, options, apply);
  const Options all = options.for_grid(grid);
  return by_lists(BasicSources<Scalar>(points, all.sources()), fields, grid, all, apply);
}

// The particles of Sources as the caller has numbered them.
template <class Scalar>
class CallersPoints {
 public:
  CallersPoints(const detail::Cloud<Scalar>& cloud, int threads)
      : dimension_(cloud.points().dimension()) {
    const PointCloud<Scalar>& points = cloud.points();
    const std::span<const std::uint32_t> caller_of = cloud.caller_of();
    for (int d = 0; d < dimension_; ++d) axes_[d].resize(points.size());
    parallel_blocks(
        points.size(), particles_per_block, threads, [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i)
            for (int d = 0; d < dimension_; ++d)
              axes_[d][caller_of[i]] =
                  static_cast<Scalar>(static_cast<double>(points(i, d)) * cloud.stretch()[d]);
        });
  }
  PointsView<Scalar> view() const { return points_of_axes(axes_, dimension_); }

 private:
  int dimension_;
  std::array<std::vector<Scalar>, max_dimension> axes_;
};

template <class Scalar>
BasicGridReconstruction<Scalar> of_sources(const BasicSources<Scalar>& sources,
                                           const std::vector<FieldView<Scalar>>& fields,
                                           const StructuredGrid<Scalar>& grid,
                                           const Options& options, const GridApply& apply) {
  options.validate();
  apply.validate();
  options.validate_with_sources();
  grid.validate();
  const detail::Cloud<Scalar>& cloud = *sources.cloud();
  ParticleData<Scalar>{cloud.points().view(), fields, {}}.validate(grid.dimension, options.threads);
  Options all = options;
  all.domain = cloud.callers_domain();
  all.stretch = cloud.stretch();
  all.particle_weights = cloud.callers_weights();
  if (beyond_moments(grid, all, apply)) {
    const std::array<double, max_dimension> stretch = all.stretch;
    all = all.for_grid(grid);
    if (all.stretch == stretch) return by_lists(sources, fields, grid, all, apply);
    // The natural supports of a grid whose spacings differ want a stretch of their own.
    const CallersPoints<Scalar> points(cloud, options.threads);
    return by_lists(BasicSources<Scalar>(points.view(), all.sources()), fields, grid, all, apply);
  }
  const CallersPoints<Scalar> points(cloud, options.threads);
  return by_moments<Scalar>({points.view(), fields, all.particle_weights}, grid, all, apply);
}

}  // namespace

GridReconstruction reconstruct_on_grid(const PointsView<double>& points,
                                       const std::vector<FieldView<double>>& fields,
                                       const StructuredGrid<double>& grid, const Options& options,
                                       const GridApply& apply) {
  return of_points(points, fields, grid, options, apply);
}
GridReconstruction reconstruct_on_grid(const Sources& sources,
                                       const std::vector<FieldView<double>>& fields,
                                       const StructuredGrid<double>& grid, const Options& options,
                                       const GridApply& apply) {
  return of_sources(sources, fields, grid, options, apply);
}
#ifndef RECON_DOUBLE_ONLY
GridReconstructionF reconstruct_on_grid(const PointsView<float>& points,
                                        const std::vector<FieldView<float>>& fields,
                                        const StructuredGrid<float>& grid, const Options& options,
                                        const GridApply& apply) {
  return of_points(points, fields, grid, options, apply);
}
GridReconstructionF reconstruct_on_grid(const SourcesF& sources,
                                        const std::vector<FieldView<float>>& fields,
                                        const StructuredGrid<float>& grid, const Options& options,
                                        const GridApply& apply) {
  return of_sources(sources, fields, grid, options, apply);
}
#endif

}  // namespace recon
