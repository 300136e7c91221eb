#include "recon/shape/options.hpp"

#include <cmath>

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
  require(form == WeightForm::radial || form == WeightForm::tensor_product, "form",
          static_cast<int>(form), "must be an enumerator of recon::WeightForm");
  require(static_cast<int>(solver) <= static_cast<int>(Solver::svd), "solver",
          static_cast<int>(solver), "must be an enumerator of recon::Solver");
  sources().validate();
}

}  // namespace recon
