// The largest stable time step of a method, and how it carries waves: a bar in 1-D, small motion.
//
// At the shortest wave (k h = pi) a linear step of velocity v and stress s, re-mapped every time,
// has the matrix [[1, -W Q K], [K, 1 - Q K^2]] with K = 2 c_p dt / h. W is what is left of an
// alternating velocity that goes from the nodes to the particles and back by the velocity map; Q
// what is left of an alternating stress in the quadrature (1 over particles). It is stable for
//     c_p dt / h <= 1 / sqrt(Q (2 - W)) ,
// and waves obey sin(omega dt / 2) = (c_p dt / h) sin(k h / 2) whatever the number of particles
// (Gong 2015, eq. 7.29 corrected: docs/misprints.md, G28). c_p = sqrt((lambda + 2 mu) / density).
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
  double kh = 0, measured = 0, analytic = 0;  // omega dt / (k c_p dt): 1 without dispersion
};
// The dispersion of waves at c_p dt / h = courant.
std::vector<DispersionPoint> dispersion(const Method& method, int per_cell, double courant);

}  // namespace recon::mpm
