#include <cmath>
#include <type_traits>

#include "core/instantiate.hpp"
#include "grid/node_fit.hpp"
#include "grid/solve_moments.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

constexpr std::size_t nodes_per_block = 256;

// Fits a node with the highest degree up to R that is safe.
template <class Scalar, int D, int R>
void fit_node(const Scalar* moments, const GridPlan<Scalar>& plan, std::size_t node,
              NodeFits<Scalar>& fits) {
  const auto at = static_cast<Eigen::Index>(node);
  detail::solve_moments<Scalar, D, R>(
      moments, node_noise(plan, plan.grid.index(node)), plan.options.tolerances,
      plan.options.degree,
      [&](const auto& matrix, bool safe, Scalar weight_sum, const FitReport& report,
          const auto& partial) {
        constexpr int terms = std::decay_t<decltype(matrix)>::m;
        if (!std::isfinite(weight_sum)) throw_overflow(weight_sum, "sum of the weights", 0, node);
        if (!safe) return;
        fits.reports[node] = report;
        for (int c = 0; c < plan.components; ++c) {
          const Scalar* from = moments + 1 + plan.kernel.moments + c * plan.kernel.terms;
          std::array<Scalar, terms> b;
          for (int j = 0; j < terms; ++j) b[j] = from[j];
          b = matrix.solve(b);
          if (!std::isfinite(b[0])) throw_overflow(b[0], "value", c, node);
          fits.values(at, c) = b[0];
          if (!fits.has_gradients()) continue;
          std::array<Scalar, D> slope{};
          for (int d = 0; d < D && terms > 1; ++d) slope[d] = b[terms == 1 ? 0 : 1 + d];
          if (partial) slope = partial->project(slope);
          for (int d = 0; d < D; ++d) {
            const Scalar per_length = slope[d] / static_cast<Scalar>(plan.axes[d].rho);
            if (!std::isfinite(per_length)) throw_overflow(per_length, "gradient", c, node);
            fits.gradients(at, c * D + d) = per_length;
          }
        }
      });
}

}  // namespace

template <class Scalar>
void fit_reduced(const Scalar* moments, const GridPlan<Scalar>& plan,
                 const std::vector<std::size_t>& nodes, NodeFits<Scalar>& fits) {
  const auto per_node = static_cast<std::size_t>(plan.quantities());
  with_shape(plan, [&](auto dimension, auto degree) {
    parallel_blocks(nodes.size(), nodes_per_block, plan.options.threads,
                    [&](std::size_t begin, std::size_t end) {
                      for (std::size_t i = begin; i < end; ++i)
                        fit_node<Scalar, dimension, degree>(moments + nodes[i] * per_node, plan,
                                                            nodes[i], fits);
                    });
  });
}

RECON_FLOAT(template void fit_reduced(const float*, const GridPlan<float>&,
                                      const std::vector<std::size_t>&, NodeFits<float>&);)
template void fit_reduced(const double*, const GridPlan<double>&, const std::vector<std::size_t>&,
                          NodeFits<double>&);

}  // namespace recon
