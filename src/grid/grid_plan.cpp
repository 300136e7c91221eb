#include "grid/grid_plan.hpp"

#include <limits>

#include "recon/core/error.hpp"

namespace recon {
namespace {

using detail::require;

constexpr double widest_support = 8;  // spacings

// (P + 1) / 2 for the B-spline of degree P, in spacings; 0 for other weights.
double natural_support(const WeightFunction& weight) {
  if (!weight.named()) return 0;
  switch (*weight.named()) {
    case Weight::linear_b_spline:
      return 1;
    case Weight::quadratic_b_spline:
      return 1.5;
    case Weight::cubic_b_spline:
      return 2;
    case Weight::quartic_b_spline:
      return 2.5;
    case Weight::quintic_b_spline:
      return 3;
    default:
      return 0;
  }
}

}  // namespace

template <class Scalar>
GridPlan<Scalar>::GridPlan(const StructuredGrid<Scalar>& grid_, const GridOptions& options_,
                           int components_)
    : grid(grid_), options(options_), components(components_) {
  grid.validate();
  options.validate();
  set = resolved(options.instruction_set);
  kernel = RECON_DISPATCH(set, row_kernel<Scalar>)(grid.dimension, options.degree);
  weight = options.weight.function<Scalar>(set);

  for (int d = grid.dimension; d < max_dimension; ++d) node_offsets[d] = {Scalar(0)};
  for (int d = 0; d < grid.dimension; ++d) {
    GridAxis& axis = axes[d];
    const auto spacing = static_cast<double>(grid.spacing[d]);
    const double rho = options.support[d];
    require(std::isfinite(rho) && rho >= 0, "support", rho, "must be positive and finite, or 0");
    axis.support = rho > 0 ? rho / spacing : natural_support(options.weight);
    require(axis.support > 0, "support", rho,
            "must be given for weights that are no B-splines: a length along each axis");
    // Rounding of a support that was meant to be whole or half spacings must not add a node.
    if (std::abs(2 * axis.support - std::round(2 * axis.support)) < 1e-6)
      axis.support = std::round(2 * axis.support) / 2;
    require(axis.support > 0 && axis.support <= widest_support, "support in grid spacings",
            axis.support, "must be positive and at most 8");
    axis.per_support = 1 / axis.support;
    axis.rho = rho > 0 ? rho : axis.support * spacing;
    const auto length = static_cast<Scalar>(axis.rho);
    require(length * length >= std::numeric_limits<Scalar>::min(), "support", axis.rho,
            "must not be so small that its square underflows");
    axis.stencil = static_cast<int>(std::ceil(2 * axis.support));
    axis.nodes = static_cast<std::int64_t>(grid.counts[d]);
    axis.cells = axis.nodes + axis.stencil - 1;
    axis.origin = static_cast<double>(grid.origin[d]);
    axis.per_spacing = 1 / spacing;
    for (int a = 0; a < axis.stencil; ++a)
      node_offsets[d].push_back(static_cast<Scalar>(axis.node_offset(a)));
  }

  // As in Stencil: what is below eps^2 of the largest weight changes nothing.
  Scalar zero = 0, largest = 0;
  options.weight.evaluate(&zero, &largest, nullptr, 1);
  const int factors = options.form == WeightForm::tensor_product ? grid.dimension : 1;
  least_weight = std::numeric_limits<Scalar>::epsilon() * std::numeric_limits<Scalar>::epsilon();
  for (int d = 0; d < factors; ++d) least_weight *= largest;
}

template struct GridPlan<float>;
template struct GridPlan<double>;

}  // namespace recon
