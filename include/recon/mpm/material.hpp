// Materials: how strain becomes stress and strain energy.
//
// In 1-D and 2-D the other directions do not strain (uniaxial strain, plane strain).
#pragma once

#include <Eigen/LU>
#include <cmath>
#include <concepts>
#include <variant>

#include "recon/core/error.hpp"
#include "recon/mpm/types.hpp"

namespace recon::mpm {

struct Lame {
  double lambda = 0, mu = 0;

  // Throws InvalidArgument unless young > 0 and -1 < poisson < 0.5.
  static Lame from(double young, double poisson) {
    recon::detail::require(young > 0 && std::isfinite(young), "young", young,
                           "must be positive and finite");
    recon::detail::require(poisson > -1 && poisson < 0.5, "poisson", poisson,
                           "must lie between -1 and 0.5");
    return {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
  }
  // Throws InvalidArgument unless mu > 0 and 3 lambda + 2 mu > 0 and both are finite, as
  // from() gives them.
  void validate() const {
    recon::detail::require(mu > 0 && std::isfinite(mu), "mu", mu, "must be positive and finite");
    recon::detail::require(3 * lambda + 2 * mu > 0 && std::isfinite(lambda), "lambda", lambda,
                           "must be finite and above -2 mu / 3");
  }
  double p_wave_speed(double density) const { return std::sqrt((lambda + 2 * mu) / density); }
  // The speed sqrt(E / density) of waves in a thin bar.
  double bar_wave_speed(double density) const {
    return std::sqrt(mu * (3 * lambda + 2 * mu) / (lambda + mu) / density);
  }
};

// A material has Lame's constants (for the speed of waves) and two functions. update() turns Cauchy
// stress (force / area) and strain energy per reference volume into those after a step dt with the
// velocity gradient L (1 / time) that led to the deformation gradient F. out_of_plane() is the
// stress along the directions without strain, in 1-D and 2-D; it follows from F and the stress in
// the other directions.
template <class M>
concept MaterialModel = std::derived_from<M, Lame> &&
    requires(const M& material, const Matrix<2>& F, const Matrix<2>& L, double dt,
             Matrix<2>& stress, double& energy) {
  { material.template update<2>(F, L, dt, stress, energy) } -> std::same_as<void>;
  { material.template out_of_plane<2>(F, L) } -> std::convertible_to<double>;
};

// sigma = (lambda ln J I + mu (F F^T - I)) / J,
// W = lambda (ln J)^2 / 2 + mu ((tr F F^T - D) / 2 - ln J)
// (Gong 2015, eq. 4.33, 4.34, with F F^T: docs/misprints.md, G10).
struct NeoHookean : Lame {
  template <int D>
  void update(const Matrix<D>& F, const Matrix<D>&, double, Matrix<D>& stress,
              double& energy) const {
    const double J = F.determinant(), log_J = std::log(J);
    const Matrix<D> b = F * F.transpose();
    stress = (mu * (b - Matrix<D>::Identity()) + lambda * log_J * Matrix<D>::Identity()) / J;
    energy = lambda * log_J * log_J / 2 + mu * ((b.trace() - D) / 2 - log_J);
  }
  template <int D>
  double out_of_plane(const Matrix<D>& F, const Matrix<D>&) const {
    const double J = F.determinant();
    return lambda * std::log(J) / J;
  }
};

// Hypoelastic: the Jaumann rate of sigma is lambda tr(d) I + 2 mu d with d the symmetric part of L;
// the energy is the work of the stress, J sigma : d per reference volume, by the trapezoidal rule.
struct LinearElastic : Lame {
  template <int D>
  void update(const Matrix<D>& F, const Matrix<D>& L, double dt, Matrix<D>& stress,
              double& energy) const {
    const Matrix<D> d = (L + L.transpose()) / 2, w = (L - L.transpose()) / 2;
    const Matrix<D> before = stress;
    stress +=
        dt * (lambda * d.trace() * Matrix<D>::Identity() + 2 * mu * d + w * before - before * w);
    energy += dt * F.determinant() * ((before + stress) / 2).cwiseProduct(d).sum();
  }
  // The integral of lambda tr(d), to which the rotation adds nothing: that of tr(sigma) is
  // (D lambda + 2 mu) tr(d).
  template <int D>
  double out_of_plane(const Matrix<D>&, const Matrix<D>& stress) const {
    return lambda / (D * lambda + 2 * mu) * stress.trace();
  }
};

static_assert(MaterialModel<NeoHookean> && MaterialModel<LinearElastic>);

using Material = std::variant<NeoHookean, LinearElastic>;

inline const Lame& lame(const Material& material) {
  return std::visit([](const auto& m) -> const Lame& { return m; }, material);
}

}  // namespace recon::mpm
