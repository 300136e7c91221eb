// The largest stable time step of a method, and how it carries waves: a bar in 1-D, small motion.
//
// At the shortest wave (k h = pi) a linear step of velocity v and stress s, re-mapped every time,
// has the matrix [[1, -W Q K], [K, 1 - Q K^2]] with K = 2 c_p dt / h. W is what is left of an
// alternating velocity that goes from the nodes to the particles and back by the velocity map; Q
// what is left of an alternating stress in the quadrature (1 over particles). It is stable for
//     c_p dt / h <= 1 / sqrt(Q (2 - W)) ,
// with c_p = sqrt((lambda + 2 mu) / density). On a grid that stays, with nothing re-mapped (W = Q =
// 1), waves obey
//     sin(omega dt / 2) = (c_p dt / h) sin(k h / 2)
// whatever the number of particles (Gong 2015, eq. 7.29 corrected: docs/misprints.md, G28). Where
// the grid is made anew in every step, as in all methods of the driver, short waves are slower than
// that, and damped: dispersion() measures both.
#pragma once

#include <vector>

#include "recon/mpm/method.hpp"

namespace recon::mpm {

struct StabilityLimit {
  std::string method;
  int per_cell = 0;
  double measured = 0;  // greatest c_p dt / h at which noise does not grow
  double W = 0, Q = 1, analytic = 0;
};
// The largest stable step of a method, measured and by the formula above. In 2-D and 3-D, and for
// 8-node elements always, the formula is missing (NaN), and the measurement is to two hundredths.
StabilityLimit stability_limit(const Method& method, int per_cell, int dimension = 1);

// Whether small noise stays small at this c_p dt / h, with so many particles per cell and axis, in
// a bar that fills its grid. The bar is held all around or, if `free`, surrounded by empty cells.
bool is_stable(const Method& method, int dimension, int per_cell, double courant,
               bool free = false);

struct DispersionPoint {
  double kh = 0;
  double measured = 0;  // omega / (k c_p): 1 without dispersion
  double analytic = 0;  // the same on a grid that stays
  double damping = 0;   // the part of the amplitude that a period takes away
};
// The dispersion and damping of standing waves at c_p dt / h = courant, by the second to the fourth
// extreme of their displacement; NaN where a wave does not come to the fourth. What eigenvalues say:
// step_waves.hpp.
std::vector<DispersionPoint> dispersion(const Method& method, int per_cell, double courant);

}  // namespace recon::mpm
