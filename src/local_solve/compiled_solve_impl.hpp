// The implementation of compiled_solve.hpp for one scalar and dimension; included by
// compiled_solve_*.cpp.
#pragma once

#include "local_solve/compiled_solve.hpp"

namespace recon::detail {

template <class Scalar, int D, int R>
class SolveOfDegree final : public CompiledSolve<Scalar, D> {
 public:
  SolveOfDegree(Solver solver, const FitTolerances& tolerances) : solve_(solver, tolerances) {}

  FitReport fit(const LocalCloud<Scalar, D>& cloud) override { return solve_.fit(cloud); }
  void shape_functions(const LocalCloud<Scalar, D>& cloud,
                       const ShapeArrays<Scalar, D>& out) override {
    solve_.shape_functions(cloud, out);
  }
  void shape_functions_of(const Scalar* on_monomials, Scalar* out) override {
    solve_.polynomials().shape_functions_of(on_monomials, out);
  }

 private:
  LocalSolve<Scalar, Monomials<D, R>, std::max(R, 2)> solve_;
};

template <class Scalar, int D>
std::unique_ptr<CompiledSolve<Scalar, D>> make_solve(int degree, Solver solver,
                                                     const FitTolerances& tolerances) {
  return with_degree(degree, [&](auto r) -> std::unique_ptr<CompiledSolve<Scalar, D>> {
    return std::make_unique<SolveOfDegree<Scalar, D, r>>(solver, tolerances);
  });
}

}  // namespace recon::detail
