#include "recon/studies/errors.hpp"

#include <cmath>
#include <limits>

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
  for (const char* field : particle_error_fields) found.push_back({field});
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
FieldError grid_velocity_error(const Simulation<D>& simulation, const Manufactured<D>& exact) {
  recon::detail::require(simulation.mapped(), "grid velocity", "of nodes of another time",
                         "needs a map() before");
  const Nodes<D>& nodes = simulation.nodes();
  const double t = simulation.time(), before = t - simulation.velocity_lag();
  const double density = simulation.problem().densities.front();
  // Newton's method for X + u(X, t) = x.
  const auto particle_at = [&](const Vector<D>& x) -> Vector<D> {
    constexpr int most = 50;
    const double small = 1e-10 * simulation.problem().grid.h();
    Vector<D> X = x;
    for (int i = 0; i < most; ++i) {
      const auto now = exact.at(X, t);
      const Vector<D> off = X + now.displacement - x;
      X -= now.F.inverse() * off;
      if (off.norm() <= small) return X;
    }
    return Vector<D>::Constant(std::numeric_limits<double>::quiet_NaN());
  };
  FieldError error{"grid_velocity"};
  const double lightest = 1e-10 * nodes.heaviest();  // lighter ones feel no forces (step.hpp)
  double count = 0;
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    const double mass = std::abs(nodes.mass[i]);
    if (!(mass > lightest) || nodes.share_of(i) == 0) continue;
    const Vector<D> X = particle_at(simulation.problem().grid.position(i));
    const double squared = (nodes.velocity[i] - exact.at(X, before).velocity).squaredNorm();
    error.l2 += squared * nodes.share_of(i) * mass / density;
    error.rms += squared;
    ++count;
  }
  error.l2 = std::sqrt(error.l2);
  error.rms = std::sqrt(error.rms / count);
  return error;
}

template <int D>
double error_of(const Simulation<D>& simulation, const Manufactured<D>& exact, std::size_t particle,
                const std::string& field) {
  for (std::size_t f = 0; f < std::size(particle_error_fields); ++f)
    if (field == particle_error_fields[f])
      return std::sqrt(squared_errors(simulation, exact, particle)[f]);
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
  template FieldError grid_velocity_error(const Simulation<D>&, const Manufactured<D>&); \
  template std::array<double, 3> exact_angular_momentum(const Simulation<D>&,            \
                                                        const Manufactured<D>&);         \
  template double error_of(const Simulation<D>&, const Manufactured<D>&, std::size_t,    \
                           const std::string&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
