// How far a simulation is from its manufactured solution.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// Of one field, over all particles: l2 = sqrt(sum_p |e_p|^2 V_p), V_p the current volumes
// (Gong 2015, eq. 4.40, 4.47, 4.48), and rms = sqrt(sum_p |e_p|^2 / N) (Tran et al. 2019, eq. 47).
inline constexpr const char* error_fields[] = {"displacement", "velocity", "density", "stress"};
struct FieldError {
  std::string field;  // one of error_fields
  double l2 = 0, rms = 0;
};

// The velocity is compared half a step before the time of the other fields, where it is known.
// Throws InvalidArgument without an exact solution.
template <int D>
std::vector<FieldError> errors(const Simulation<D>& simulation);

// |e_p| of one particle; `field` is one of error_fields.
template <int D>
double error_of(const Simulation<D>& simulation, std::size_t particle, const std::string& field);

// sum_p m_p x_p x v_p of the exact motion, the position at time() and the velocity where that of
// the particles is known; the last component alone in 2-D. Throws as errors().
template <int D>
std::array<double, 3> exact_angular_momentum(const Simulation<D>& simulation);

}  // namespace recon::mpm
