#include "recon/grid/grid_moments.hpp"

#include "core/instantiate.hpp"
#include "grid/node_fit.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

using detail::require;

constexpr std::size_t numbers_per_block = 65536;

// From the lanes of a finished row to [node][quantity], and back.
template <class Scalar, class Copy>
void for_each_number(const GridPlan<Scalar>& plan, const LaneLayout& lanes, std::int64_t width,
                     const Copy& copy) {
  const auto quantities = static_cast<std::size_t>(plan.quantities());
  const auto count = static_cast<std::size_t>(lanes.lanes);
  for (std::int64_t i = 0; i < width; ++i)
    for (std::size_t q = 0; q < quantities; ++q)
      copy((lanes.entry(i) * quantities + q) * count + lanes.lane(i),
           static_cast<std::size_t>(i) * quantities + q);
}

template <class Scalar>
void require_moments(const StructuredGrid<Scalar>& grid, const Options& options,
                     const GridApply& apply) {
  grid.validate();
  options.validate();
  apply.validate();
  if (const auto beyond = beyond_moments<Scalar>(grid, options, apply)) throw *beyond;
}

// The weights enter the sums as they are.
template <class Scalar>
void require_representable(std::span<const double> weights) {
  using Limits = std::numeric_limits<Scalar>;
  for (std::size_t p = 0; p < weights.size(); ++p)
    if (!(weights[p] >= Limits::min() && weights[p] <= Limits::max())) [[unlikely]]
      detail::throw_invalid("particle_weights of particle " + std::to_string(p), weights[p],
                            "must be in the range of the precision of the moments");
}

}  // namespace

template <class Scalar>
BasicGridMoments<Scalar>::BasicGridMoments(const PointsView<Scalar>& points,
                                           const std::vector<FieldView<Scalar>>& fields,
                                           const StructuredGrid<Scalar>& grid,
                                           const Options& options) {
  require_moments<Scalar>(grid, options, {});
  const ParticleData<Scalar> particles{points, fields, options.particle_weights};
  particles.validate(grid.dimension, options.threads);
  require_representable<Scalar>(options.particle_weights);
  const auto plan = std::make_shared<const GridPlan<Scalar>>(grid, options, particles.components());
  plan_ = plan;
  const ParticleBins bins(particles, *plan);
  values_.resize(grid.size() * static_cast<std::size_t>(plan->quantities()));
  const LaneLayout lanes = LaneLayout::of(*plan);
  RowSink<Scalar> keep = [&](const FinishedRow<Scalar>& row) {
    Scalar* to = values_.data() +
                 plan->node(row.first, row.j, row.k) * static_cast<std::size_t>(plan->quantities());
    for_each_number(*plan, lanes, row.width,
                    [&](std::size_t in_row, std::size_t here) { to[here] = row.moments[in_row]; });
  };
  sweep<Scalar>(particles, bins, *plan, {}, [&] { return keep; });
}

template <class Scalar>
int BasicGridMoments<Scalar>::per_node() const {
  return plan_->quantities();
}

template <class Scalar>
BasicGridMoments<Scalar>& BasicGridMoments<Scalar>::operator+=(const BasicGridMoments& other) {
  const GridPlan<Scalar>&a = *plan_, &b = *other.plan_;
  require(a.components == b.components, "components of the moments", b.components,
          "must be those of the moments they are added to");
  require(a.dimension() == b.dimension() && a.options.degree == b.options.degree &&
              a.form == b.form && a.options.weight.named() == b.options.weight.named(),
          "options of the moments", "different",
          "must have the dimension, degree, weight and form of the moments they are added to");
  for (int d = 0; d < a.dimension(); ++d)
    require(a.grid.origin[d] == b.grid.origin[d] && a.grid.spacing[d] == b.grid.spacing[d] &&
                a.grid.counts[d] == b.grid.counts[d] && a.axes[d].rho == b.axes[d].rho,
            "grid of the moments along axis", d,
            "must have the nodes and the support of the moments they are added to");
  parallel_blocks(values_.size(), numbers_per_block, a.options.threads,
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i) values_[i] += other.values_[i];
                  });
  return *this;
}

template <class Scalar>
BasicGridReconstruction<Scalar> BasicGridMoments<Scalar>::solve(const GridApply& apply) const {
  const GridPlan<Scalar>& plan = *plan_;
  require_moments<Scalar>(plan.grid, plan.options, apply);
  require(apply.limit == Limit::none, "limit", "range",
          "must be none for moments: the range of the data is not among them");
  NodeFits<Scalar> fits(plan, apply.gradients.has_value());
  const LaneLayout lanes = LaneLayout::of(plan);
  const auto rows = static_cast<std::size_t>(plan.axes[1].nodes * plan.axes[2].nodes);
  const auto row_size = static_cast<std::size_t>(plan.quantities() * lanes.lanes * lanes.groups);
  parallel_blocks(rows, 16, plan.options.threads, [&](std::size_t begin, std::size_t end) {
    RowSolver<Scalar> solve(plan, lanes, fits);
    AlignedArray<Scalar> moments;
    for (std::size_t r = begin; r < end; ++r)
      for (std::int64_t first = 0; first < plan.axes[0].nodes; first += lanes.width) {
        const auto j = static_cast<std::int64_t>(r) % plan.axes[1].nodes;
        const auto k = static_cast<std::int64_t>(r) / plan.axes[1].nodes;
        const std::int64_t width = std::min(lanes.width, plan.axes[0].nodes - first);
        const Scalar* from =
            values_.data() + plan.node(first, j, k) * static_cast<std::size_t>(plan.quantities());
        moments.reset(row_size);
        for_each_number(plan, lanes, width, [&](std::size_t in_row, std::size_t here) {
          moments.data()[in_row] = from[here];
        });
        solve({first, width, j, k, moments.data()});
      }
  });
  fit_reduced(values_.data(), plan, fits.unsafe(), fits);
  return {std::move(fits.values), std::move(fits.gradients),
          FitReports(std::move(fits.reports), Solver::moment_matrix)};
}

RECON_FLOAT(template class BasicGridMoments<float>;)
template class BasicGridMoments<double>;

}  // namespace recon
