#include "recon/shape/options.hpp"

#include <cmath>
#include <string>

#include "core/instantiate.hpp"
#include "recon/basis/monomials.hpp"

namespace recon {

namespace {
using detail::require;
}  // namespace

void Options::validate() const {
  require(degree >= 0 && degree <= 4, "degree", degree, "must be 0 to 4");
  require(max_distance > 0, "max_distance", max_distance, "must be positive (infinity: no limit)");
  require(grow.steps >= 0, "grow.steps", grow.steps, "must not be negative");
  require(std::isfinite(grow.factor) && grow.factor > 1, "grow.factor", grow.factor,
          "must exceed 1");
  require(tolerances.rank > 0 && tolerances.rank < 1, "tolerances.rank", tolerances.rank,
          "must lie between 0 and 1");
  require(tolerances.gradient_extent >= 0 && tolerances.gradient_extent < 1,
          "tolerances.gradient_extent", tolerances.gradient_extent, "must be 0 or more, below 1");
  require(tolerances.leverage > 1, "tolerances.leverage", tolerances.leverage, "must exceed 1");
  require(threads >= 0, "threads", threads, "must not be negative (0: all there are)");
  detail::require_form(form.value_or(WeightForm::radial));
  const Solver asked = solver.value_or(Solver::gram_schmidt);
  require(static_cast<int>(asked) <= static_cast<int>(Solver::svd), "solver",
          static_cast<int>(asked), "must be an enumerator of recon::Solver");
  require(unsupported == Unsupported::fill || unsupported == Unsupported::nearest, "unsupported",
          static_cast<int>(unsupported), "must be an enumerator of recon::Unsupported");
  require(search >= SearchMethod::automatic && search <= SearchMethod::brute_force, "search",
          static_cast<int>(search), "must be an enumerator of recon::SearchMethod");
  sources().validate();
}

void Options::validate_with_sources() const {
  const SourcesOptions none;
  const char* const rule = "belongs to the Sources: say it where they are made";
  require(particle_weights.empty(), "particle_weights", particle_weights.size(), rule);
  std::string factors, periodic;
  for (int d = 0; d < max_dimension; ++d) {
    factors += (d ? ", " : "") + detail::to_text(stretch[d]);
    if (domain.periodic[d]) periodic += (periodic.empty() ? "" : ", ") + std::string(1, "xyz"[d]);
  }
  require(stretch == none.stretch, "stretch", "{" + factors + "}", rule);
  require(!domain.any(), "domain", "periodic along " + periodic, rule);
}

Options Options::for_points(int dimension) const {
  validate();
  Options all = *this;
  if (!form) all.form = WeightForm::radial;
  if (!solver) all.solver = Solver::gram_schmidt;
  if (!neighbours) all.neighbours = Nearest{2 * monomial_count(dimension, degree) + 1};
  return all;
}

template <class Scalar>
Options Options::for_grid(const StructuredGrid<Scalar>& grid) const {
  validate();
  grid.validate();
  Options all = *this;
  if (!form) all.form = WeightForm::tensor_product;
  if (!solver) all.solver = degree <= 2 ? Solver::moment_matrix : Solver::gram_schmidt;
  if (neighbours) return all;
  const double natural = natural_support(weight);
  require(natural > 0, "neighbours", "empty",
          "must be said on grids for weights that are no B-splines: they have no natural support");
  const auto spacing = static_cast<double>(grid.spacing[0]);
  all.neighbours = Radius{natural * spacing};
  for (int d = 1; d < grid.dimension; ++d) {
    const double ratio = static_cast<double>(grid.spacing[d]) / spacing;
    if (std::abs(ratio - 1) > 4 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()))
      all.stretch[d] *= ratio;
  }
  return all;
}

RECON_FLOAT(template Options Options::for_grid(const StructuredGrid<float>&) const;)
template Options Options::for_grid(const StructuredGrid<double>&) const;

}  // namespace recon
