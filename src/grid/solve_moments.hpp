// One node from its moments: the highest degree at which the moment matrix is safe, on the
// processor and on a GPU.
#pragma once

#include <array>
#include <optional>

#include "recon/local_solve/fill_report.hpp"
#include "recon/local_solve/gradient_resolution.hpp"
#include "recon/local_solve/moment_matrix.hpp"

namespace recon::detail {

// How to project gradients onto the directions in which they are resolved, where those are not all;
// the report says in how many they are.
template <class Scalar, int D, int R>
constexpr std::optional<GradientResolution<Scalar, D>> gradient_of_moments(
    const MomentMatrix<Scalar, Monomials<D, R>>& matrix, Scalar weight_sum,
    const FitTolerances& tolerances, FitReport& report) {
  if (R == 0 || matrix.gradient_resolved()) return {};
  const auto slopes = matrix.slopes();
  std::array<std::array<Scalar, Monomials<D, R>::size>, D> components{};
  std::array<Scalar*, D> rows{};
  for (int d = 0; d < D; ++d) {
    for (int k = 0; k < Monomials<D, R>::size; ++k) components[d][k] = slopes[k][d];
    rows[d] = components[d].data();
  }
  const auto resolution = GradientResolution<Scalar, D>::of(
      rows, Monomials<D, R>::size, weight_sum, D, gradient_limit2<Scalar>(tolerances, R));
  report.gradient_rank = static_cast<std::uint8_t>(resolution.rank);
  report.gradient_amplification = square_root(to_float(resolution.amplification2));
  if (resolution.rank == D) return {};
  return resolution;
}

// Tries degree R, then lower ones; degree 0 needs no more than a positive weight. moments: the
// number of particles, then at least the moments up to degree 2 R. Calls use(matrix, safe,
// weight_sum, report, partial) once, with the matrix of the degree that it came to, and as `partial`
// gradient_of_moments(). `asked` is the degree that the report is judged by.
template <class Scalar, int D, int R, class Use>
constexpr void solve_moments(const Scalar* moments, const Scalar& noise,
                             const FitTolerances& tolerances, int asked, const Use& use) {
  using Basis = Monomials<D, R>;
  MomentMatrix<Scalar, Basis> matrix(tolerances);
  typename MomentMatrix<Scalar, Basis>::Moments chosen{};
  for (std::size_t a = 0; a < chosen.size(); ++a) chosen[a] = moments[1 + a];
  const bool safe = (R == 0 || moments[0] >= Scalar(Basis::size)) && matrix.factor(chosen, noise);
  if constexpr (R > 0)
    if (!safe) return solve_moments<Scalar, D, R - 1>(moments, noise, tolerances, asked, use);
  FitReport report;
  std::optional<GradientResolution<Scalar, D>> partial;
  if (safe) {
    // A node may be seen by particles of negligible weight only.
    const int neighbours = moments[0] > Scalar(1) ? static_cast<int>(moments[0]) : 1;
    report = report_of<Basis>(numbers_of(Solver::moment_matrix, neighbours, matrix),
                              all_terms<Basis>(), asked);
    report.hessian_rank = 0;
    partial = gradient_of_moments<Scalar, D, R>(matrix, chosen[0], tolerances, report);
  }
  use(matrix, safe, chosen[0], report, partial);
}

}  // namespace recon::detail
