#include <algorithm>
#include <cmath>
#include <optional>

#include "core/instantiate.hpp"
#include "grid/node_fit.hpp"
#include "recon/core/parallel.hpp"
#include "recon/local_solve/fill_report.hpp"
#include "recon/local_solve/gradient_resolution.hpp"
#include "recon/local_solve/moment_matrix.hpp"

namespace recon {
namespace {

constexpr std::size_t nodes_per_block = 256;

// Says in the report in how many directions the gradient is resolved. Returns how to project onto
// them, where those are not all.
template <class Scalar, int D, int R>
std::optional<detail::GradientResolution<Scalar, D>> gradient_of(
    const MomentMatrix<Scalar, Monomials<D, R>>& matrix, Scalar weight_sum,
    const FitTolerances& tolerances, FitReport& report) {
  if (R == 0 || matrix.gradient_resolved()) return {};
  const auto slopes = matrix.slopes();
  std::array<std::array<Scalar, slopes.size()>, D> components;
  std::array<Scalar*, D> rows;
  for (int d = 0; d < D; ++d) {
    for (std::size_t k = 0; k < slopes.size(); ++k) components[d][k] = slopes[k][d];
    rows[d] = components[d].data();
  }
  const auto resolution =
      detail::GradientResolution<Scalar, D>::of(rows, static_cast<int>(slopes.size()), weight_sum,
                                                D, detail::gradient_limit2<Scalar>(tolerances, R));
  report.gradient_rank = static_cast<std::uint8_t>(resolution.rank);
  report.gradient_amplification = std::sqrt(static_cast<float>(resolution.amplification2));
  if (resolution.rank == D) return {};
  return resolution;
}

// Tries degree R, then lower ones; `terms`: right-hand sides per component. Degree 0 needs no more
// than a positive weight.
template <class Scalar, int D, int R>
void fit_node(const Scalar* moments, const GridPlan<Scalar>& plan, std::size_t node,
              NodeFits<Scalar>& fits) {
  using Basis = Monomials<D, R>;
  MomentMatrix<Scalar, Basis> matrix(plan.options.tolerances);
  typename MomentMatrix<Scalar, Basis>::Moments chosen;
  for (std::size_t a = 0; a < chosen.size(); ++a) chosen[a] = moments[1 + a];
  const Scalar noise = node_noise(plan, plan.grid.index(node));
  if (R > 0 && !(moments[0] >= Scalar(Basis::size) && matrix.factor(chosen, noise))) {
    fit_node<Scalar, D, (R > 0 ? R - 1 : 0)>(moments, plan, node, fits);
    return;
  }
  if (!std::isfinite(chosen[0])) throw_overflow(chosen[0], "sum of the weights", 0, node);
  if (R == 0 && !matrix.factor(chosen, noise)) return;
  // A node may be seen by particles of negligible weight only.
  const int neighbours = std::max(1, static_cast<int>(moments[0]));
  FitReport& report = fits.reports[node];
  report = detail::report_of<Basis>(detail::numbers_of(Solver::moment_matrix, neighbours, matrix),
                                    detail::all_terms<Basis>(), plan.options.degree);
  report.hessian_rank = 0;
  const auto partial =
      gradient_of<Scalar, D, R>(matrix, chosen[0], plan.options.tolerances, report);
  const auto at = static_cast<Eigen::Index>(node);
  for (int c = 0; c < plan.components; ++c) {
    const Scalar* from = moments + 1 + plan.kernel.moments + c * plan.kernel.terms;
    typename MomentMatrix<Scalar, Basis>::Vector b;
    for (int j = 0; j < Basis::size; ++j) b[j] = from[j];
    b = matrix.solve(b);
    if (!std::isfinite(b[0])) throw_overflow(b[0], "value", c, node);
    fits.values(at, c) = b[0];
    if (!fits.has_gradients()) continue;
    std::array<Scalar, D> slope{};
    for (int d = 0; d < D && R > 0; ++d) slope[d] = b[R == 0 ? 0 : 1 + d];
    if (partial) slope = partial->project(slope);
    for (int d = 0; d < D; ++d) {
      const Scalar per_length = slope[d] / static_cast<Scalar>(plan.axes[d].rho);
      if (!std::isfinite(per_length)) throw_overflow(per_length, "gradient", c, node);
      fits.gradients(at, c * D + d) = per_length;
    }
  }
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
