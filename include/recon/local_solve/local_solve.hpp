// One local fit with any solver; what a solver cannot do is handed over to Gram-Schmidt.
//
// ```cpp
//   recon::LocalSolve<double, recon::Monomials<3, 1>> solve(recon::Solver::moment_matrix);
//   recon::FitReport report = solve.fit(cloud);     // cloud: LocalCloud, the caller's arrays
//   solve.shape_functions(cloud, {.value = phi});   // phi[p] for each particle
// ```
//
// T is float, double, long double or a number type of your own (docs/concepts.md), for which there
// are the solvers moment_matrix and gram_schmidt; B any Basis. Objects keep their work space from
// target to target: one per thread, no allocation once warm. Throws InvalidArgument for a solver
// that T does not have.
#pragma once

#include <type_traits>

#include "recon/local_solve/reference.hpp"
#include "recon/local_solve/safe_solve.hpp"

namespace recon {

// jet_order: as for GramSchmidt.
template <class T, Basis B, int jet_order = 2>
class LocalSolve {
 public:
  static constexpr int D = B::dimension;
  // The reference solvers, which are Eigen's, ask more of T than the others.
  static constexpr bool has_references = std::is_floating_point_v<T>;

  explicit LocalSolve(Solver solver, FitTolerances tolerances = {}, Growing = {})
      : is_reference_(has_references && (solver == Solver::qr || solver == Solver::svd)),
        safe_(is_reference_ ? Solver::gram_schmidt : solver, tolerances),
        reference_(solver, tolerances) {}

  FitReport fit(const LocalCloud<T, D>& cloud) {
    if constexpr (has_references) {
      FitReport report;
      by_reference_ = is_reference_ && reference_.fit(cloud, report);
      if (by_reference_) return report;
    }
    return safe_.fit(cloud);
  }

  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    if constexpr (has_references)
      if (by_reference_) return reference_.shape_functions(cloud, out);
    safe_.shape_functions(cloud, out);
  }

  // The polynomials of the last fit that was by Gram-Schmidt.
  typename GramSchmidt<T, B, jet_order>::Result& polynomials() { return safe_.polynomials(); }

 private:
  struct NoReference {
    NoReference(Solver, const FitTolerances&) {}
  };

  bool is_reference_, by_reference_ = false;
  SafeSolve<T, B, Growing, jet_order> safe_;
  std::conditional_t<has_references, ReferenceFit<T, B>, NoReference> reference_;
};

}  // namespace recon
