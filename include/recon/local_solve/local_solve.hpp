// One local fit with any solver, including the hand-over of what a solver cannot do to
// Gram-Schmidt.
//
//   LocalSolve<double, Monomials<3, 1>> solve(Solver::moment_matrix);
//   FitReport report = solve.fit(cloud);            // cloud: LocalCloud, the caller's arrays
//   solve.shape_functions(cloud, {.value = phi});   // phi[p] for each particle
//
// T is any type with arithmetic and square roots (float, double, long double); B any Basis. Objects
// keep their work space from target to target: one per thread, no allocation once warm.
#pragma once

#include "recon/local_solve/gram_schmidt.hpp"
#include "recon/local_solve/moment_matrix.hpp"
#include "recon/local_solve/reference.hpp"

namespace recon {

template <class T, Basis B>
class LocalSolve {
 public:
  static constexpr int D = B::dimension;

  explicit LocalSolve(Solver solver, FitTolerances tolerances = {})
      : solver_(solver),
        moment_matrix_(tolerances),
        gram_schmidt_(tolerances),
        reference_(solver, tolerances) {}

  FitReport fit(const LocalCloud<T, D>& cloud) {
    FitReport report;
    used_ = solver_;
    if (solver_ == Solver::moment_matrix && moment_matrix_.fit(cloud)) {
      report.solver = Solver::moment_matrix;
      report.neighbours = static_cast<std::uint32_t>(cloud.size);
      report.smallest_pivot = static_cast<float>(moment_matrix_.smallest_pivot());
      report.amplification = static_cast<float>(moment_matrix_.amplification());
      detail::report_full<B>(report);
      return report;
    }
    if ((solver_ == Solver::qr || solver_ == Solver::svd) && reference_.fit(cloud, report))
      return report;
    used_ = Solver::gram_schmidt;
    return gram_schmidt_.fit(cloud);
  }

  void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    if (used_ == Solver::moment_matrix)
      moment_matrix_.shape_functions(cloud, out);
    else if (used_ == Solver::gram_schmidt)
      gram_schmidt_.shape_functions(cloud, out);
    else
      reference_.shape_functions(cloud, out);
  }

 private:
  Solver solver_, used_ = Solver::gram_schmidt;
  MomentMatrix<T, B> moment_matrix_;
  GramSchmidt<T, B> gram_schmidt_;
  ReferenceFit<T, B> reference_;
};

}  // namespace recon
