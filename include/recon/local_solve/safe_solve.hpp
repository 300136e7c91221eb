// One local fit by the moment matrix where that is safe, and by graded Gram-Schmidt elsewhere; or
// by Gram-Schmidt alone.
//
// It runs in constant expressions and in device code, and allocates nothing with memory of
// compile-time size or of the caller's (core/memory.hpp). LocalSolve adds the reference solvers.
#pragma once

#include <limits>

#include "recon/core/error.hpp"
#include "recon/core/memory.hpp"
#include "recon/local_solve/fill_report.hpp"
#include "recon/local_solve/gram_schmidt.hpp"
#include "recon/local_solve/moment_matrix.hpp"

namespace recon {

// jet_order, Memory: as for GramSchmidt.
template <class T, Basis B, class Memory = Growing, int jet_order = 2>
class SafeSolve {
  using Robust = GramSchmidt<T, B, jet_order, Memory>;

 public:
  static constexpr int D = B::dimension;
  static_assert(B::degree <= FitReport::max_degree,
                "recon: the degree of the basis exceeds FitReport::max_degree");
  static_assert(std::numeric_limits<T>::is_specialized,
                "recon: a scalar of your own needs std::numeric_limits");

  // What is taken from a Workspace for this many particles.
  static constexpr std::size_t bytes_for(int most) { return Robust::bytes_for(most); }

  // Throws InvalidArgument for other solvers than moment_matrix and gram_schmidt.
  constexpr explicit SafeSolve(Solver solver, FitTolerances tolerances = {}, Memory memory = {})
      : solver_(solver), moment_matrix_(tolerances), gram_schmidt_(tolerances, memory) {
    detail::require(solver == Solver::moment_matrix || solver == Solver::gram_schmidt, "solver",
                    name_of(solver),
                    "must be moment_matrix or gram_schmidt for a scalar that is not built in");
  }

  constexpr FitReport fit(const LocalCloud<T, D>& cloud) {
    used_ = solver_;
    if (solver_ == Solver::moment_matrix && moment_matrix_.fit(cloud) &&
        moment_matrix_.gradient_resolved())
      return detail::report_of<B>(
          detail::numbers_of(Solver::moment_matrix, cloud.size, moment_matrix_));
    used_ = Solver::gram_schmidt;
    return gram_schmidt_.fit(cloud);
  }

  constexpr void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    if (used_ == Solver::moment_matrix)
      moment_matrix_.shape_functions(cloud, out);
    else
      gram_schmidt_.shape_functions(cloud, out);
  }

  // The polynomials of the last fit that was by Gram-Schmidt.
  constexpr typename Robust::Result& polynomials() { return gram_schmidt_.result(); }

 private:
  Solver solver_, used_ = Solver::gram_schmidt;
  MomentMatrix<T, B> moment_matrix_;
  Robust gram_schmidt_;
};

}  // namespace recon
