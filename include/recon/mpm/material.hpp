// Materials: how strain becomes stress and strain energy.
//
// In 1-D and 2-D the other directions do not strain (uniaxial strain, plane strain).
//
// A new material is a struct here and a line in `Material`: problem files, checkpoints and the step
// take it from there.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <concepts>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "recon/core/error.hpp"
#include "recon/core/lanes.hpp"
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
  constexpr double p_wave_speed(double density) const {
    return recon::detail::square_root((lambda + 2 * mu) / density);
  }
  // The speed sqrt(E / density) of waves in a thin bar.
  constexpr double bar_wave_speed(double density) const {
    return recon::detail::square_root(mu * (3 * lambda + 2 * mu) / (lambda + mu) / density);
  }
};

// A material has Lame's constants (for the speed of waves), a name and two functions. update()
// turns Cauchy stress (force / area) and strain energy per reference volume into those after a step
// dt with the velocity gradient L (1 / time) that led to the deformation gradient F. out_of_plane()
// is the stress along the directions without strain, in 1-D and 2-D; it follows from F and the
// stress in the other directions. update() takes any type M of matrices with the functions of
// Eigen's that it uses, and is constexpr: a GPU has a type of its own.
//
// One that remembers more than these has `history`, the names of its variables: both functions
// then take them last, as const double* in out_of_plane(). They are 0 at the start. One with more
// constants than Lame's has parameters(): the keys of problem files with the members that they set.
template <class M>
concept MaterialModel = std::derived_from<M, Lame> &&
    requires(const M& material, const Matrix<2>& F, const Matrix<2>& L, double dt,
             Matrix<2>& stress, double& energy) {
  { M::name } -> std::convertible_to<std::string_view>;
  requires requires {
    { material.update(F, L, dt, stress, energy) } -> std::same_as<void>;
    { material.template out_of_plane<2>(F, L) } -> std::convertible_to<double>;
  } || requires(double* history) {
    { M::history[0] } -> std::convertible_to<std::string_view>;
    { material.update(F, L, dt, stress, energy, history) } -> std::same_as<void>;
    { material.template out_of_plane<2>(F, L, history) } -> std::convertible_to<double>;
  };
};

// The number of history variables of a material.
template <class M>
constexpr std::size_t history_of() {
  if constexpr (requires { M::history; })
    return M::history.size();
  else
    return 0;
}

// sigma = (lambda ln J I + mu (F F^T - I)) / J,
// W = lambda (ln J)^2 / 2 + mu ((tr F F^T - D) / 2 - ln J)
// (Gong 2015, eq. 4.33, 4.34, with F F^T: docs/misprints.md, G10).
struct NeoHookean : Lame {
  static constexpr std::string_view name = "neo_hookean";
  template <class M>
  constexpr void update(const M& F, const M&, double, M& stress, double& energy) const {
    constexpr int D = M::RowsAtCompileTime;
    const double J = F.determinant(), log_J = std::log(J);
    const M b = F * F.transpose();
    stress = (mu * (b - M::Identity()) + lambda * log_J * M::Identity()) / J;
    energy = lambda * log_J * log_J / 2 + mu * ((b.trace() - D) / 2 - log_J);
  }
  template <int D>
  double out_of_plane(const Matrix<D>& F, const Matrix<D>&) const {
    const double J = F.determinant();
    return lambda * std::log(J) / J;
  }
};

// Hooke's law of small strain: with e = (F + F^T) / 2 - I
//     sigma = lambda tr(e) I + 2 mu e ,   W = lambda tr(e)^2 / 2 + mu e : e .
// For small displacements only, for which linear theory has its closed forms. It does not know
// rotations: one by an angle a alone has the strain cos(a) - 1 and so a stress. The work of sigma
// on a body that changes its volume differs from W by the strain times W.
struct SmallStrain : Lame {
  static constexpr std::string_view name = "small_strain";
  template <class M>
  constexpr void update(const M& F, const M&, double, M& stress, double& energy) const {
    const M e = (F + F.transpose()) / 2 - M::Identity();
    stress = lambda * e.trace() * M::Identity() + 2 * mu * e;
    energy = lambda * e.trace() * e.trace() / 2 + mu * e.squaredNorm();
  }
  template <int D>
  double out_of_plane(const Matrix<D>& F, const Matrix<D>&) const {
    return lambda * (F.trace() - D);
  }
};

// Hypoelastic: the Jaumann rate of sigma is lambda tr(d) I + 2 mu d with d the symmetric part of L;
// the energy is the work of the stress, J sigma : d per reference volume, by the trapezoidal rule.
struct LinearElastic : Lame {
  static constexpr std::string_view name = "linear_elastic";
  template <class M>
  constexpr void update(const M& F, const M& L, double dt, M& stress, double& energy) const {
    const M d = (L + L.transpose()) / 2, w = (L - L.transpose()) / 2;
    const M before = stress;
    stress += dt * (lambda * d.trace() * M::Identity() + 2 * mu * d + w * before - before * w);
    energy += dt * F.determinant() * ((before + stress) / 2).cwiseProduct(d).sum();
  }
  // The integral of lambda tr(d), to which the rotation adds nothing: that of tr(sigma) is
  // (D lambda + 2 mu) tr(d).
  template <int D>
  double out_of_plane(const Matrix<D>&, const Matrix<D>& stress) const {
    return lambda / (D * lambda + 2 * mu) * stress.trace();
  }
};

// Elastic and plastic: LinearElastic whose Mises stress is at most yield + hardening times the
// plastic strain; what is above after an elastic step is taken from the deviator, along itself
// (radial return: Wilkins 1964; Simo, Hughes 1998, box 3.1). History: the equivalent plastic
// strain, and the stress along the directions without strain. The energy is the work of the stress,
// what is dissipated included.
struct VonMises : Lame {
  static constexpr std::string_view name = "von_mises";
  static constexpr std::array history{"plastic_strain", "stress_beyond"};
  double yield = 0, hardening = 0;  // force / area

  static constexpr auto parameters() {
    return std::array{std::pair{"yield", &VonMises::yield},
                      std::pair{"hardening", &VonMises::hardening}};
  }
  // Throws InvalidArgument unless the yield stress is positive and the hardening not negative.
  void validate() const {
    Lame::validate();
    recon::detail::require(yield > 0 && std::isfinite(yield), "yield", yield,
                           "must be positive and finite");
    recon::detail::require(hardening >= 0 && std::isfinite(hardening), "hardening", hardening,
                           "must be finite and not negative");
  }
  template <class M>
  constexpr void update(const M& F, const M& L, double dt, M& stress, double& energy,
                        double* remembered) const {
    constexpr int D = M::RowsAtCompileTime;
    double &plastic = remembered[0], &beyond = remembered[1];
    const M d = (L + L.transpose()) / 2, before = stress;
    double elastic = 0;
    LinearElastic{{lambda, mu}}.update(F, L, dt, stress, elastic);
    beyond += dt * lambda * d.trace();
    const double mean = (stress.trace() + (3 - D) * beyond) / 3;
    const M deviator = stress - mean * M::Identity();
    const double mises =
        std::sqrt(1.5 * (deviator.squaredNorm() + (3 - D) * (beyond - mean) * (beyond - mean)));
    if (const double above = mises - yield - hardening * plastic; above > 0) {
      const double flow = above / (3 * mu + hardening), left = 1 - 3 * mu * flow / mises;
      stress = mean * M::Identity() + left * deviator;
      beyond = mean + left * (beyond - mean);
      plastic += flow;
    }
    energy += dt * F.determinant() * ((before + stress) / 2).cwiseProduct(d).sum();
  }
  template <int D>
  double out_of_plane(const Matrix<D>&, const Matrix<D>&, const double* remembered) const {
    return remembered[1];
  }
};

// The materials that there are; the first one is the default of problem files.
using Material = std::variant<NeoHookean, LinearElastic, VonMises, SmallStrain>;

inline const Lame& lame(const Material& material) {
  return std::visit([](const auto& m) -> const Lame& { return m; }, material);
}
inline std::string_view name_of(const Material& material) {
  return std::visit([](const auto& m) { return std::decay_t<decltype(m)>::name; }, material);
}
inline std::size_t history_of(const Material& material) {
  return std::visit([](const auto& m) { return history_of<std::decay_t<decltype(m)>>(); },
                    material);
}
// Throws InvalidArgument for constants that are none.
inline void validate_material(const Material& material) {
  std::visit([](const auto& m) { m.validate(); }, material);
}
}  // namespace recon::mpm
