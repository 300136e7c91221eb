#include "recon/grid/grid_options.hpp"

#include "recon/core/error.hpp"

namespace recon {

namespace {
using detail::require;
}  // namespace

void GridOptions::validate() const {
  require(degree >= 0 && degree <= 2, "degree", degree, "must be 0, 1 or 2");
  require(form == WeightForm::radial || form == WeightForm::tensor_product, "form",
          static_cast<int>(form), "must be an enumerator of recon::WeightForm");
  require(tolerances.rank > 0 && tolerances.rank < 1, "tolerances.rank", tolerances.rank,
          "must lie between 0 and 1");
  require(tolerances.gradient_extent >= 0 && tolerances.gradient_extent < 1,
          "tolerances.gradient_extent", tolerances.gradient_extent, "must be 0 or more, below 1");
  require(tolerances.leverage > 1, "tolerances.leverage", tolerances.leverage, "must exceed 1");
  require(threads >= 0, "threads", threads, "must not be negative (0: all there are)");
  resolved(instruction_set);
}

}  // namespace recon
