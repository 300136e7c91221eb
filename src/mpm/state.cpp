#include "recon/mpm/state.hpp"

#include "mpm/modes.hpp"

namespace recon::mpm {
namespace {

// Of the linear fields v_p + L_p d.
template <int D>
void start_modes(const Problem<D>& problem, std::size_t count, Particles<D>& particles) {
  particles.modes.assign(particles.size() * count, Vector<D>::Zero());
  const ModeSet set = mode_set(problem.method.velocity);
  for (std::size_t p = 0; p < particles.size(); ++p)
    for (int d = 0; d < D; ++d)
      particles.modes[p * count + static_cast<std::size_t>(linear_mode(set, d))] =
          particles.L[p].col(d);
}

}  // namespace

template <int D>
State<D> start(Problem<D>&& problem) {
  problem.validate();
  const Kept kept = problem.kept();
  State<D> s;
  s.particles = std::move(problem.particles);
  Particles<D>& particles = s.particles;
  if (particles.corners.size() != particles.size() * kept.corners)
    for (std::size_t p = 0; p < particles.size(); ++p)
      particles.corners.push_back(particles.domain(p));
  if (particles.modes.size() != particles.size() * kept.modes)
    start_modes(problem, kept.modes, particles);
  particles.history.resize(particles.size() * kept.history);
  return s;
}

template <int D>
State<D> start(const Problem<D>& problem) {
  return start(Problem<D>(problem));
}

#define RECON_INSTANTIATE(D)                  \
  template State<D> start(const Problem<D>&); \
  template State<D> start(Problem<D>&&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
