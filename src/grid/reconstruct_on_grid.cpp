#include "recon/grid/reconstruct_on_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grid/node_fit.hpp"

namespace recon {
namespace {

// A unit of mass must not take the sums out of the range of numbers.
template <class Scalar>
Scalar scale_of(const FieldView<Scalar>& weights) {
  Scalar largest = 0;
  for (std::size_t p = 0; p < weights.size(); ++p) largest = std::max(largest, weights(p, 0));
  if (!(largest > 0)) return 1;
  constexpr int most = std::numeric_limits<Scalar>::max_exponent - 1;
  return std::ldexp(Scalar(1), std::min(-std::ilogb(largest), most));
}

template <class Scalar>
BasicGridReconstruction<Scalar> reconstruct(ParticleData<Scalar> particles,
                                            const StructuredGrid<Scalar>& grid,
                                            const GridOptions& options) {
  const GridPlan<Scalar> plan(grid, options, particles.components());
  const ParticleBins bins(particles, plan);
  particles.weight_scale = scale_of(particles.weights);
  NodeFits<Scalar> fits(plan);
  const LaneLayout lanes = LaneLayout::of(plan);
  sweep<Scalar>(particles, bins, plan, [&] {
    return [solver = std::make_shared<RowSolver<Scalar>>(plan, lanes, fits)](
               const FinishedRow<Scalar>& row) { (*solver)(row); };
  });
  fit_from_particles(particles, bins, plan, fits.unsafe(), fits);
  LimitCount limited;
  if (options.limit != Limit::none) limited = limit_nodes(particles, bins, plan, fits);
  return {std::move(fits.values), std::move(fits.gradients),
          FitReports(std::move(fits.reports), Solver::moment_matrix), std::move(limited)};
}

}  // namespace

GridReconstruction reconstruct_on_grid(const PointsView<double>& points,
                                       const std::vector<FieldView<double>>& fields,
                                       const StructuredGrid<double>& grid,
                                       const GridOptions& options,
                                       const FieldView<double>& particle_weights) {
  return reconstruct<double>({points, fields, particle_weights}, grid, options);
}
GridReconstructionF reconstruct_on_grid(const PointsView<float>& points,
                                        const std::vector<FieldView<float>>& fields,
                                        const StructuredGrid<float>& grid,
                                        const GridOptions& options,
                                        const FieldView<float>& particle_weights) {
  return reconstruct<float>({points, fields, particle_weights}, grid, options);
}

}  // namespace recon
