// Updates in files of their own.
#pragma once

#include "mpm/policies.hpp"

namespace recon::mpm {

// y' = f(y) for position, velocity and deformation; f is the map and the rates of flip.
template <int D>
std::unique_ptr<const UpdatePolicy<D>> make_runge_kutta(const Problem<D>& problem);

}  // namespace recon::mpm
