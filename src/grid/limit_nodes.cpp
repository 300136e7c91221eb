#include <cmath>

#include "core/instantiate.hpp"
#include "grid/node_fit.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

constexpr std::size_t nodes_per_block = 256;

// Limits one node after another; has the buffers for that.
template <class Scalar>
class NodeLimiter {
 public:
  using Ranges = std::vector<detail::DataRange<Scalar>>;  // one for each component

  NodeLimiter(const ParticleData<Scalar>& particles, const ParticleBins& bins,
              const GridPlan<Scalar>& plan, Limit kind, const Ranges& all, NodeFits<Scalar>& fits)
      : particles_(particles),
        bins_(bins),
        plan_(plan),
        kind_(kind),
        all_(all),
        fits_(fits),
        ranges_(all.size()) {}

  // Takes the data of a particle into the ranges.
  static void add(const ParticleData<Scalar>& particles, std::size_t p, Ranges& ranges) {
    std::size_t column = 0;
    for (const auto& field : particles.fields)
      for (int c = 0; c < field.components(); ++c) ranges[column++].add(field(p, c));
  }

  // Goes through the particles in the support until all values are known to lie in the range.
  std::uint32_t limit(std::size_t node) {
    start(node);
    if (!all_held()) gather();
    std::uint32_t limited = 0;
    const auto amplification = static_cast<Scalar>(fits_.reports[node].amplification);
    for (int c = 0; c < plan_.components; ++c) {
      const detail::DataRange<Scalar>& range = ranges_[c];
      Scalar& value = fits_.values(static_cast<Eigen::Index>(node), c);
      if (range.least > range.greatest || range.holds(value)) continue;
      limited += range.limit(value, kind_, all_[c], amplification);
    }
    return limited;
  }

 private:
  void start(std::size_t node) {
    node_ = node;
    ranges_.assign(ranges_.size(), {});
    const auto index = plan_.grid.index(node);
    for (int d = 0; d < max_dimension; ++d) {
      first_[d] = static_cast<std::int64_t>(index[d]);
      x_[d] = d < plan_.dimension() ? plan_.grid.coordinate(index[d], d) : Scalar(0);
    }
  }

  void gather() {
    const auto n = plan_.stencil();
    for (std::int64_t k = first_[2]; k < first_[2] + n[2]; ++k)
      for (std::int64_t j = first_[1]; j < first_[1] + n[1]; ++j)
        for (const std::uint32_t p : bins_.row(first_[0], first_[0] + n[0], j, k)) {
          if (!in_support(p)) continue;
          add(particles_, p, ranges_);
          if (all_held()) return;
        }
  }

  // |xi_d| < 1 on each axis, or |xi| < 1.
  bool in_support(std::uint32_t p) const {
    Scalar sum = 0;
    for (int d = 0; d < std::min(max_dimension, plan_.dimension()); ++d) {
      const Scalar xi = (particles_.points(p, d) - x_[d]) / static_cast<Scalar>(plan_.axes[d].rho);
      if (!(std::abs(xi) < 1)) return false;
      sum += xi * xi;
    }
    return plan_.form == WeightForm::tensor_product || sum < 1;
  }

  bool all_held() const {
    for (int c = 0; c < plan_.components; ++c)
      if (!ranges_[c].holds(fits_.values(static_cast<Eigen::Index>(node_), c))) return false;
    return true;
  }

  const ParticleData<Scalar>& particles_;
  const ParticleBins& bins_;
  const GridPlan<Scalar>& plan_;
  const Limit kind_;
  const Ranges& all_;
  NodeFits<Scalar>& fits_;
  std::size_t node_ = 0;
  std::array<std::int64_t, max_dimension> first_{};  // node i is seen by cells i .. i + n - 1
  std::array<Scalar, max_dimension> x_{};
  Ranges ranges_;
};

}  // namespace

template <class Scalar>
LimitCount limit_nodes(const ParticleData<Scalar>& particles, const ParticleBins& bins,
                       const GridPlan<Scalar>& plan, Limit kind, NodeFits<Scalar>& fits) {
  LimitCount count;
  count.components.assign(fits.reports.size(), 0);
  typename NodeLimiter<Scalar>::Ranges all(static_cast<std::size_t>(plan.components));
  for (std::size_t p = 0; p < particles.points.size(); ++p)
    NodeLimiter<Scalar>::add(particles, p, all);
  parallel_blocks(fits.reports.size(), nodes_per_block, plan.options.threads,
                  [&](std::size_t begin, std::size_t end) {
                    NodeLimiter<Scalar> limiter(particles, bins, plan, kind, all, fits);
                    for (std::size_t i = begin; i < end; ++i)
                      if (fits.reports[i].status != FitStatus::no_support)
                        count.components[i] = limiter.limit(i);
                  });
  count.total();
  return count;
}

RECON_FLOAT(template LimitCount limit_nodes(const ParticleData<float>&, const ParticleBins&,
                                            const GridPlan<float>&, Limit, NodeFits<float>&);)
template LimitCount limit_nodes(const ParticleData<double>&, const ParticleBins&,
                                const GridPlan<double>&, Limit, NodeFits<double>&);

}  // namespace recon
