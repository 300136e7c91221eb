#include <algorithm>
#include <string>

#include "core/instantiate.hpp"
#include "grid/node_fit.hpp"
#include "local_solve/compiled_solve.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/core/sums.hpp"
#include "recon/shape/stencil.hpp"

namespace recon {
namespace {

constexpr std::size_t nodes_per_block = 64;

template <class Scalar, int D>
class ParticleFit {
 public:
  ParticleFit(const ParticleData<Scalar>& particles, const ParticleBins& bins,
              const GridPlan<Scalar>& plan, NodeFits<Scalar>& fits)
      : particles_(particles),
        bins_(bins),
        plan_(plan),
        fits_(fits),
        solve_(detail::make_solve<Scalar, D>(plan.options.degree, Solver::gram_schmidt,
                                             plan.options.tolerances)) {}

  void fit(std::size_t node) {
    find(node);
    weigh(node);
    const LocalCloud<Scalar, D> cloud = stencil_.cloud();
    count_ = cloud.size;
    FitReport& report = fits_.reports[node] = solve_->fit(cloud);
    report.hessian_rank = 0;
    if (report.rank == 0) return;
    phi_.resize(static_cast<std::size_t>(cloud.size) * (1 + D));
    solve_->shape_functions(cloud,
                            ShapeArrays<Scalar, D>::in(phi_.data(), cloud.size, Derivative::diffuse,
                                                       fits_.has_gradients(), false));
    const auto at = static_cast<Eigen::Index>(node);
    int column = 0;
    for (const auto& field : particles_.fields)
      for (int c = 0; c < field.components(); ++c, ++column) {
        fits_.values(at, column) = checked(sum(field, c, phi_.data()), "value", column, node);
        for (int d = 0; d < D && fits_.has_gradients(); ++d)
          fits_.gradients(at, column * D + d) =
              checked(sum(field, c, phi_.data() + (1 + d) * cloud.size) /
                          static_cast<Scalar>(plan_.axes[d].rho),
                      "gradient", column, node);
      }
  }

 private:
  // The particles of all cells that see the node, ascending.
  void find(std::size_t node) {
    const auto at = plan_.grid.index(node);
    std::array<std::int64_t, max_dimension> first, last;  // node i is seen by cells i .. i + n - 1
    for (int d = 0; d < max_dimension; ++d) {
      first[d] = static_cast<std::int64_t>(at[d]);
      last[d] = first[d] + plan_.axes[d].stencil;
    }
    found_.clear();
    for (std::int64_t k = first[2]; k < last[2]; ++k)
      for (std::int64_t j = first[1]; j < last[1]; ++j)
        for (const std::uint32_t p : bins_.row(first[0], last[0], j, k)) {
          const std::int64_t i = plan_.axes[0].cell(static_cast<double>(particles_.points(p, 0)));
          if (i >= first[0] && i < last[0]) found_.push_back(p);
        }
    std::sort(found_.begin(), found_.end());
  }

  void weigh(std::size_t node) {
    const auto index = plan_.grid.index(node);
    std::array<Scalar, D> x, inverse;
    for (int d = 0; d < D; ++d) {
      inverse[d] = static_cast<Scalar>(1 / plan_.axes[d].rho);
      x[d] = plan_.grid.coordinate(index[d], d) * inverse[d];
    }
    stencil_.start(x, Scalar(1), static_cast<int>(found_.size()));
    for (int d = 0; d < D; ++d) {
      const Scalar here = plan_.grid.coordinate(index[d], d);
      Scalar* offsets = stencil_.offsets(d);
      for (std::size_t i = 0; i < found_.size(); ++i)
        offsets[i] = (particles_.points(found_[i], d) - here) * inverse[d];
    }
    if (!particles_.weights.empty()) {
      Scalar* weights = stencil_.particle_weights();
      for (std::size_t i = 0; i < found_.size(); ++i) weights[i] = particles_.weight(found_[i]);
    }
    stencil_.weigh(plan_.options.weight, plan_.form, false);
  }

  Scalar sum(const FieldView<Scalar>& field, int component, const Scalar* phi) const {
    const auto u = [&](int i) { return field(found_[stencil_.place(i)], component); };
    const Scalar total = detail::sum_of<Scalar>(count_, [&](int i) { return phi[i] * u(i); });
    if (std::isfinite(total)) [[likely]]
      return total;
    return detail::scaled_sum_of_products<Scalar>(
        count_, [&](int i) { return phi[i]; }, u);
  }
  static Scalar checked(Scalar result, const char* what, int component, std::size_t node) {
    if (!std::isfinite(result)) [[unlikely]]
      throw_overflow(result, what, component, node);
    return result;
  }

  const ParticleData<Scalar>& particles_;
  const ParticleBins& bins_;
  const GridPlan<Scalar>& plan_;
  NodeFits<Scalar>& fits_;
  std::unique_ptr<detail::CompiledSolve<Scalar, D>> solve_;
  Stencil<Scalar, D> stencil_;
  std::vector<std::uint32_t> found_;
  std::vector<Scalar> phi_;
  int count_ = 0;
};

}  // namespace

template <class Scalar>
void fit_from_particles(const ParticleData<Scalar>& particles, const ParticleBins& bins,
                        const GridPlan<Scalar>& plan, const std::vector<std::size_t>& nodes,
                        NodeFits<Scalar>& fits) {
  with_dimension(plan, [&](auto dimension) {
    parallel_blocks(nodes.size(), nodes_per_block, plan.options.threads,
                    [&](std::size_t begin, std::size_t end) {
                      ParticleFit<Scalar, dimension> fit(particles, bins, plan, fits);
                      for (std::size_t i = begin; i < end; ++i) fit.fit(nodes[i]);
                    });
  });
}

RECON_FLOAT(template void fit_from_particles(const ParticleData<float>&, const ParticleBins&,
                                             const GridPlan<float>&,
                                             const std::vector<std::size_t>&, NodeFits<float>&);)
template void fit_from_particles(const ParticleData<double>&, const ParticleBins&,
                                 const GridPlan<double>&, const std::vector<std::size_t>&,
                                 NodeFits<double>&);

}  // namespace recon
