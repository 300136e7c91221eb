#include "recon/studies/errors.hpp"

#include <cmath>

#include "runs/angular.hpp"

namespace recon::mpm {

namespace {

// |e_p|^2 of all fields.
template <int D>
std::array<double, 4> squared_errors(const Simulation<D>& simulation, const Manufactured<D>& exact,
                                     std::size_t p) {
  const Problem<D>& problem = simulation.problem();
  const Particles<D>& particles = simulation.particles();
  const double t = simulation.time();
  const auto now = exact.at(particles.X[p], t);
  const auto before = exact.at(particles.X[p], t - simulation.velocity_lag());
  Matrix<D> stress = Matrix<D>::Zero();
  double energy = 0;
  material_of_exact(problem.materials).update(now.F, particles.L[p], 0, stress, energy);
  const double density = particles.mass[p] / (particles.volume0[p] * now.F.determinant());
  return {(particles.x[p] - particles.X[p] - now.displacement).squaredNorm(),
          (particles.v[p] - before.velocity).squaredNorm(),
          (particles.density(p) - density) * (particles.density(p) - density),
          (particles.stress[p] - stress).squaredNorm()};
}

}  // namespace

template <int D>
std::vector<FieldError> errors(const Simulation<D>& simulation, const Manufactured<D>& exact) {
  const Particles<D>& particles = simulation.particles();
  std::vector<FieldError> found;
  for (const char* field : error_fields) found.push_back({field});
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto squared = squared_errors(simulation, exact, p);
    for (std::size_t f = 0; f < found.size(); ++f) {
      found[f].l2 += squared[f] * particles.volume(p);
      found[f].rms += squared[f];
    }
  }
  for (FieldError& error : found) {
    error.l2 = std::sqrt(error.l2);
    error.rms = std::sqrt(error.rms / static_cast<double>(particles.size()));
  }
  return found;
}

template <int D>
double error_of(const Simulation<D>& simulation, const Manufactured<D>& exact, std::size_t particle,
                const std::string& field) {
  for (std::size_t f = 0; f < std::size(error_fields); ++f)
    if (field == error_fields[f]) return std::sqrt(squared_errors(simulation, exact, particle)[f]);
  recon::detail::throw_invalid("field", field, "must be displacement, velocity, density or stress");
}

template <int D>
std::array<double, 3> exact_angular_momentum(const Simulation<D>& simulation,
                                             const Manufactured<D>& exact) {
  const Particles<D>& particles = simulation.particles();
  std::array<double, 3> sum{};
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const Vector<D>& X = particles.X[p];
    const Vector<D> x = X + exact.at(X, simulation.time()).displacement;
    const double before = simulation.time() - simulation.velocity_lag();
    add_angular<D>(sum, x, particles.mass[p] * exact.at(X, before).velocity);
  }
  return sum;
}

#define RECON_INSTANTIATE(D)                                                             \
  template std::vector<FieldError> errors(const Simulation<D>&, const Manufactured<D>&); \
  template std::array<double, 3> exact_angular_momentum(const Simulation<D>&,            \
                                                        const Manufactured<D>&);         \
  template double error_of(const Simulation<D>&, const Manufactured<D>&, std::size_t,    \
                           const std::string&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
