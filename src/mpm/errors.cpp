#include "recon/mpm/errors.hpp"

#include <cmath>

namespace recon::mpm {

template <int D>
std::vector<FieldError> errors(const Simulation<D>& simulation) {
  const Problem<D>& problem = simulation.problem();
  const Particles<D>& particles = simulation.particles();
  require(problem.exact != nullptr, "problem", problem.title, "has no exact solution");
  const double t = simulation.time();
  std::vector<FieldError> found{{"displacement"}, {"velocity"}, {"density"}, {"stress"}};
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto now = problem.exact->at(particles.X[p], t);
    const auto before = problem.exact->at(particles.X[p], t - simulation.last_step() / 2);
    Matrix<D> stress = Matrix<D>::Zero();
    double energy = 0;
    std::get<NeoHookean>(problem.materials[particles.body[p]])
        .update(now.F, particles.L[p], 0, stress, energy);
    const double density = particles.mass[p] / (particles.volume0[p] * now.F.determinant());
    const double squared[] = {(particles.x[p] - particles.X[p] - now.displacement).squaredNorm(),
                              (particles.v[p] - before.velocity).squaredNorm(),
                              (particles.density(p) - density) * (particles.density(p) - density),
                              (particles.stress[p] - stress).squaredNorm()};
    for (int f = 0; f < 4; ++f) {
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

template std::vector<FieldError> errors(const Simulation<1>&);
template std::vector<FieldError> errors(const Simulation<2>&);
template std::vector<FieldError> errors(const Simulation<3>&);

}  // namespace recon::mpm
