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

#include "recon/core/error.hpp"
#include "recon/local_solve/gram_schmidt.hpp"
#include "recon/local_solve/moment_matrix.hpp"
#include "recon/local_solve/reference.hpp"

namespace recon {

template <class T, Basis B>
class LocalSolve {
 public:
  static constexpr int D = B::dimension;
  static_assert(B::degree <= FitReport::max_degree,
                "recon: the degree of the basis exceeds FitReport::max_degree");
  static_assert(std::numeric_limits<T>::is_specialized,
                "recon: a scalar of your own needs std::numeric_limits");
  // The reference solvers, which are Eigen's, ask more of T than the others.
  static constexpr bool has_references = std::is_floating_point_v<T>;

  explicit LocalSolve(Solver solver, FitTolerances tolerances = {})
      : solver_(solver),
        moment_matrix_(tolerances),
        gram_schmidt_(tolerances),
        reference_(solver, tolerances) {
    detail::require(has_references || !is_reference(), "solver", name_of(solver),
                    "must be moment_matrix or gram_schmidt for a scalar that is not built in");
  }

  FitReport fit(const LocalCloud<T, D>& cloud) {
    FitReport report;
    used_ = solver_;
    if (solver_ == Solver::moment_matrix && moment_matrix_.fit(cloud) &&
        moment_matrix_.gradient_resolved()) {
      report.solver = Solver::moment_matrix;
      report.neighbours = static_cast<std::uint32_t>(cloud.size);
      report.smallest_pivot = detail::to_float(moment_matrix_.smallest_pivot());
      report.amplification = detail::to_float(moment_matrix_.amplification());
      report.gradient_amplification = detail::to_float(moment_matrix_.gradient_amplification());
      detail::report_full<B>(report);
      return report;
    }
    if constexpr (has_references)
      if (is_reference() && reference_.fit(cloud, report)) return report;
    used_ = Solver::gram_schmidt;
    return gram_schmidt_.fit(cloud);
  }

  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    if (used_ == Solver::moment_matrix)
      moment_matrix_.shape_functions(cloud, out);
    else if (used_ == Solver::gram_schmidt)
      gram_schmidt_.shape_functions(cloud, out);
    else if constexpr (has_references)
      reference_.shape_functions(cloud, out);
  }

 private:
  struct NoReference {
    NoReference(Solver, const FitTolerances&) {}
  };
  bool is_reference() const { return solver_ == Solver::qr || solver_ == Solver::svd; }

  Solver solver_, used_ = Solver::gram_schmidt;
  MomentMatrix<T, B> moment_matrix_;
  GramSchmidt<T, B> gram_schmidt_;
  std::conditional_t<has_references, ReferenceFit<T, B>, NoReference> reference_;
};

}  // namespace recon
