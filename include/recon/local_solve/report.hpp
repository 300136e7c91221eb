// The outcome of the fit at one target: how many particles, which terms, how well conditioned.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace recon {

// How the local least-squares problem is solved.
enum class Solver : std::uint8_t {
  moment_matrix,  // MLS: LDLT of the moment matrix; hands ill-conditioned targets to gram_schmidt
  gram_schmidt,   // IMLS: graded Gram-Schmidt, robust to any degeneracy
  qr,             // reference: pivoted Householder QR of the weighted basis
  svd             // reference: singular value decomposition of the weighted basis
};

enum class FitStatus : std::uint8_t {
  full,        // all terms up to the asked degree
  reduced,     // some terms dropped: `degree` says what is still reproduced
  nearest,     // no particle in the support: the value of the nearest one (if the caller chose so)
  no_support,  // no particle in the support: no value
  too_far      // farther from every particle than Options::max_distance allows: no value
};

constexpr std::string_view name_of(Solver solver) {
  constexpr std::array<std::string_view, 4> names{"moment_matrix", "gram_schmidt", "qr", "svd"};
  const auto place = static_cast<std::size_t>(solver);
  return place < names.size() ? names[place] : "unknown";
}
constexpr std::string_view name_of(FitStatus status) {
  constexpr std::array<std::string_view, 5> names{"full", "reduced", "nearest", "no_support",
                                                  "too_far"};
  const auto place = static_cast<std::size_t>(status);
  return place < names.size() ? names[place] : "unknown";
}

struct FitReport {
  static constexpr int max_degree = 8;

  std::uint32_t neighbours = 0;  // particles with positive weight
  std::uint8_t rank = 0;         // independent terms kept
  std::int8_t degree = -1;       // all polynomials up to this degree are reproduced; -1: none
  FitStatus status = FitStatus::no_support;
  Solver solver = Solver::gram_schmidt;  // the one that gave the result
  // The number of directions in which the gradient is resolved: those in which linear terms are
  // kept and the particles extend at least FitTolerances::gradient_extent support radii.
  // gradient() is 0 in the others. It is below the dimension on lines and in sheets, however
  // noisy, and 0 at degree 0.
  std::uint8_t gradient_rank = 0;
  // The number of directions in which all second derivatives are resolved. It is gradient_rank, and
  // hessian() is 0 in the other directions; or it is 0,
  // - where there are none: at degree 0 and 1, and where sums over a grid formed the fit,
  // - where they cannot be told from a slope that is not resolved (on a thin bowl, or where the
  //   particles lie near a curve by chance): hessian() is 0 there,
  // - where fewer second-degree terms are kept than gradient_rank directions have, r (r + 1) / 2
  //   (four particles; particles on a circle): hessian() is what the kept terms tell of it, not the
  //   whole of it.
  std::uint8_t hessian_rank = 0;
  // The number of independent directions kept within each degree: {1, 1, 0} on a line in 2-D.
  std::array<std::uint8_t, max_degree + 1> kept{};
  // The smallest pivot of the moment matrix scaled to unit diagonal, = min_j (|p_j| / |q_j|)^2 with
  // p_j the part of term q_j that is independent of the terms before it. The reciprocal condition
  // number of that matrix is at most this, and can be much smaller (27 times was met). 1 for
  // orthogonal terms, 0 where there is no fit.
  float smallest_pivot = 0;
  // A bound of sum_p |phi_p|, the factor by which the fit can amplify errors in the data:
  // sqrt(sum_p w_p * e^T M^-1 e) with e the basis at the target. It is 1 for Shepard, and grows as
  // the target leaves the particles. Where the bound exceeds FitTolerances::leverage, as beside a
  // dense cluster, sum_p |phi_p| itself stands here, and decides.
  float amplification = 0;
  // The same for the slopes of the local polynomial in the resolved directions: sqrt(sum_p w_p *
  // e_d^T M^-1 e_d), the largest over the axes d, a bound of rho sum_p |d phi_p / d x_d|. Errors
  // of the data divided by the support radius, times this, are those of the gradient. 0 where
  // nothing is resolved.
  float gradient_amplification = 0;

  friend bool operator==(const FitReport&, const FitReport&) = default;
};

}  // namespace recon
