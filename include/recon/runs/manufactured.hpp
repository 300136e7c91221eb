// Manufactured solutions: a motion is prescribed, and the body force that makes it exact follows.
//
//     b(X, t) = d2u/dt2 - Div P(F) / rho0,   F = I + du/dX,   P = mu F + (lambda ln J - mu) F^-T
// for a neo-Hookean material. A motion is one formula u(X, t); its derivatives are taken by jets
// (jet.hpp), so that nothing is derived by hand.
//
//   vibration       u_d = G sin(pi X_d) sin(c pi t), any dimension; period 2 / c
//                   (Gong 2015, eq. 4.35, 4.41)
//   axis_vibration  u_d = G sin(2 pi X_d) sin(c pi t)  (Tran et al. 2019, eq. 48 with L = 1)
//   wave_along_x    the same along the first axis alone, as the source has it
//   ring            u_r = G sin(c pi t / (2 r)) (c3 R^3 + c2 R^2 + c1 R), r_i = 0.4, r_o = 0.6,
//                   r = 0.5; free of traction for nu = 0
//                   (eq. 57-59; docs/misprints.md, T17, T20)
//   vortex          a turn by G sin(c pi t) (1 - 32 (R - 1)^2 + 256 (R - 1)^4) about the origin,
//                   0.75 <= R <= 1.25 (eq. 60-65; docs/misprints.md, T22, T23)
// G is a length (vortex: radian), c = sqrt(E / rho0), unit lengths where the formulas have none.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recon/mpm/problem.hpp"

namespace recon::mpm {

template <int D>
class Manufactured {
 public:
  struct State {
    Vector<D> displacement, velocity, body_force;
    Matrix<D> F, velocity_gradient;  // d v_i / d x_j
  };

  virtual ~Manufactured() = default;
  virtual std::string name() const = 0;
  // The exact state at time t of the particle with the reference position X.
  virtual State at(const Vector<D>& X, double t) const = 0;
  // The time after which the motion repeats itself.
  virtual double period() const = 0;
};

// Throws InvalidArgument for an unknown name, and for one that is not defined in D dimensions.
template <int D>
std::shared_ptr<const Manufactured<D>> make_manufactured(std::string_view name, double G,
                                                         const NeoHookean& material,
                                                         double density);

std::vector<std::string> manufactured_names();

// Throws InvalidArgument unless there is one body and it is neo-Hookean: exact solutions are for
// these.
const NeoHookean& material_of_exact(const std::vector<Material>& materials);

// Sets velocities, velocity gradients and the body force of the problem to those of the motion.
template <int D>
void follow(const std::shared_ptr<const Manufactured<D>>& exact, Problem<D>& problem);

}  // namespace recon::mpm
