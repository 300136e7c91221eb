// LocalSolve of a degree that is chosen while the program runs: compiled once for each scalar and
// dimension, for all that fits single targets.
#pragma once

#include <algorithm>
#include <memory>
#include <type_traits>

#include "recon/local_solve/local_solve.hpp"

namespace recon::detail {

// The degrees that are compiled.
inline constexpr int max_compiled_degree = 4;

// Calls body(std::integral_constant<int, R>) for the degree R. Throws InvalidArgument for others
// than 0 to 4.
template <class Body>
decltype(auto) with_degree(int degree, Body&& body) {
  switch (degree) {
    case 0:
      return body(std::integral_constant<int, 0>{});
    case 1:
      return body(std::integral_constant<int, 1>{});
    case 2:
      return body(std::integral_constant<int, 2>{});
    case 3:
      return body(std::integral_constant<int, 3>{});
    case 4:
      return body(std::integral_constant<int, 4>{});
    default:
      throw_invalid("degree", degree, "must be 0 to 4");
  }
}

template <class Scalar, int D>
class CompiledSolve {
 public:
  virtual ~CompiledSolve() = default;
  virtual FitReport fit(const LocalCloud<Scalar, D>& cloud) = 0;
  virtual void shape_functions(const LocalCloud<Scalar, D>& cloud,
                               const ShapeArrays<Scalar, D>& out) = 0;
  // Those of a linear functional, after a fit by Gram-Schmidt, from what the functional makes of
  // the monomials up to the degree, or to degree 2 if that is higher.
  virtual void shape_functions_of(const Scalar* on_monomials, Scalar* out) = 0;
};

template <class Scalar, int D>
std::unique_ptr<CompiledSolve<Scalar, D>> make_solve(int degree, Solver solver,
                                                     const FitTolerances& tolerances);

}  // namespace recon::detail
