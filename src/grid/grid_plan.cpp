#include "grid/grid_plan.hpp"
#include "core/instantiate.hpp"

#include <limits>
#include <string>

namespace recon {
namespace {

constexpr double widest_support = 8;  // spacings

struct AxisSupport {
  double spacings, length;
};

// The support along axis d: of Radius or, without a rule, the natural one.
template <class Scalar>
AxisSupport support_along(const StructuredGrid<Scalar>& grid, const Options& options, int d) {
  const auto spacing = static_cast<double>(grid.spacing[d]);
  AxisSupport support{natural_support(options.weight) * options.stretch[d], 0};
  if (options.neighbours) {
    support.length = std::get<Radius>(*options.neighbours).radius * options.stretch[d];
    support.spacings = support.length / spacing;
  }
  // Rounding of a support that was meant to be whole or half spacings must not add a node.
  const double whole = std::round(2 * support.spacings) / 2;
  if (std::abs(support.spacings - whole) <
      16 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * whole)
    support.spacings = whole;
  if (!options.neighbours) support.length = support.spacings * spacing;
  return support;
}

}  // namespace

template <class Scalar>
std::optional<InvalidArgument> beyond_moments(const StructuredGrid<Scalar>& grid,
                                              const Options& options, const GridApply& apply) {
  const auto beyond = [](const char* argument, const auto& value, const char* rule) {
    return InvalidArgument(argument, detail::to_text(value),
                           rule + std::string(" for sums of moments"));
  };
  if (options.degree > 2) return beyond("degree", options.degree, "must be 0, 1 or 2");
  if (options.domain.any()) return beyond("domain", "periodic", "must not be periodic");
  if (options.visible) return beyond("visible", "a function", "must not be said");
  if (options.grow.steps > 0) return beyond("grow.steps", options.grow.steps, "must be 0");
  if (std::isfinite(options.max_distance))
    return beyond("max_distance", options.max_distance, "must be infinite");
  if (options.unsupported != Unsupported::fill)
    return beyond("unsupported", "nearest", "must be fill");
  if (options.search != SearchMethod::automatic)
    return beyond("search", static_cast<int>(options.search), "must be automatic");
  if (options.solver.value_or(Solver::moment_matrix) != Solver::moment_matrix)
    return beyond("solver", name_of(*options.solver), "must be moment_matrix");
  if (apply.gradients == Derivative::exact) return beyond("gradients", "exact", "must be diffuse");
  if (options.neighbours ? !std::holds_alternative<Radius>(*options.neighbours)
                         : natural_support(options.weight) == 0)
    return beyond("neighbours", options.neighbours ? "a support for each node" : "empty",
                  "must be Radius or, with a B-spline as weight, empty");
  for (int d = 0; d < grid.dimension; ++d) {
    const AxisSupport support = support_along(grid, options, d);
    if (!(support.spacings > 0 && support.spacings <= widest_support))
      return beyond("support in grid spacings", support.spacings, "must be positive and at most 8");
    const auto length = static_cast<Scalar>(support.length);
    if (!(length * length >= std::numeric_limits<Scalar>::min()))
      return beyond("support", support.length, "must not be so small that its square underflows");
  }
  return {};
}

template <class Scalar>
GridPlan<Scalar>::GridPlan(const StructuredGrid<Scalar>& grid_, const Options& options_,
                           int components_)
    : grid(grid_),
      options(options_),
      form(options_.form.value_or(WeightForm::tensor_product)),
      components(components_) {
  options.particle_weights = {};
  set = resolved(options.instruction_set);
  kernel = RECON_DISPATCH(set, row_kernel<Scalar>)(grid.dimension, options.degree);
  weight = options.weight.function<Scalar>(set);

  for (int d = grid.dimension; d < max_dimension; ++d) node_offsets[d] = {Scalar(0)};
  for (int d = 0; d < grid.dimension; ++d) {
    GridAxis& axis = axes[d];
    const auto spacing = static_cast<double>(grid.spacing[d]);
    const AxisSupport support = support_along(grid, options, d);
    axis.support = support.spacings;
    axis.per_support = 1 / axis.support;
    axis.rho = support.length;
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
  const int factors = form == WeightForm::tensor_product ? grid.dimension : 1;
  least_weight = std::numeric_limits<Scalar>::epsilon() * std::numeric_limits<Scalar>::epsilon();
  for (int d = 0; d < factors; ++d) least_weight *= largest;
}

RECON_FLOAT(template std::optional<InvalidArgument> beyond_moments(const StructuredGrid<float>&,
                                                                   const Options&,
                                                                   const GridApply&);)
template std::optional<InvalidArgument> beyond_moments(const StructuredGrid<double>&,
                                                       const Options&, const GridApply&);
RECON_FLOAT(template struct GridPlan<float>;)
template struct GridPlan<double>;

}  // namespace recon
