#include "recon/operators/functional.hpp"

#include "recon/core/error.hpp"

namespace recon {

Functional Functional::partial(int nx, int ny, int nz) {
  for (const int order : {nx, ny, nz})
    detail::require(order >= 0, "order of a partial derivative", order, "must not be negative");
  detail::require(nx + ny + nz <= 2, "order of the partial derivative", nx + ny + nz,
                  "must be at most 2");
  return Functional(Kind::partial, {nx, ny, nz});
}

}  // namespace recon
