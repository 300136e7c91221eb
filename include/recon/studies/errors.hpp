// How far a simulation is from its manufactured solution.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "recon/runs/manufactured.hpp"
#include "recon/runs/simulation.hpp"

namespace recon::mpm {

// The errors of one field over all particles: l2 = sqrt(sum_p |e_p|^2 V_p) with V_p the
// current volumes (Gong 2015, eq. 4.40, 4.47, 4.48), and rms = sqrt(sum_p |e_p|^2 / N) (Tran
// et al. 2019, eq. 47).
inline constexpr const char* particle_error_fields[] = {"displacement", "velocity", "density",
                                                        "stress"};
// The same with what grid_velocity_error() says.
inline constexpr const char* error_fields[] = {"displacement", "velocity", "density", "stress",
                                               "grid_velocity"};
struct FieldError {
  std::string field;  // one of error_fields
  double l2 = 0, rms = 0;
};

// The errors of the fields of particles. The velocity is compared at its own time, which is half a
// step before that of the other fields. Throws InvalidArgument for a material that has no exact
// solutions.
template <int D>
std::vector<FieldError> errors(const Simulation<D>& simulation, const Manufactured<D>& exact);

// The error of the nodes' velocities that map() computed last, as boundaries hold them:
//     l2 = sqrt(sum_i |v_i - v(X_i)|^2 |m_i| / rho0) ,   rms over the nodes that feel forces,
// with the mass of a node over the density at rest as its volume. X_i is the particle of the exact
// motion that is at the node at time(), and v(X_i) its velocity at the time of the particles'
// velocities, half a step earlier: what the map takes to the nodes. The motion is continued to
// nodes outside of the body. Throws InvalidArgument without a map().
template <int D>
FieldError grid_velocity_error(const Simulation<D>& simulation, const Manufactured<D>& exact);

// The error |e_p| of one particle; `field` is one of particle_error_fields.
template <int D>
double error_of(const Simulation<D>& simulation, const Manufactured<D>& exact, std::size_t particle,
                const std::string& field);

// The angular momentum sum_p m_p x_p x v_p of the exact motion, with positions at time() and
// velocities at the time of those of the particles; in 2-D only the last component is not 0.
template <int D>
std::array<double, 3> exact_angular_momentum(const Simulation<D>& simulation,
                                             const Manufactured<D>& exact);

}  // namespace recon::mpm
