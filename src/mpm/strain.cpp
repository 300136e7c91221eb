// Deformation and stress of a block of particles.
#include "core/brief.hpp"
#include "mpm/policies.hpp"

namespace recon::mpm {

Failure turned_inside_out(std::int64_t step, std::size_t p, double det_F) {
  return {step, "particle", p,
          "its volume is no longer positive (det F = " + recon::detail::brief(det_F) + ")"};
}

template <int D>
void strain(const Problem<D>& problem, std::size_t begin, std::size_t end, double dt, State<D>& s) {
  Particles<D>& particles = s.particles;
  for (std::size_t p = begin; p < end; ++p)
    particles.F[p] = deformed(particles.F[p], particles.L[p], dt);
  strain_to(problem, begin, end, dt, s);
}

template <int D>
void strain_to(const Problem<D>& problem, std::size_t begin, std::size_t end, double dt,
               State<D>& s) {
  Particles<D>& particles = s.particles;
  const std::size_t history = particles.history.size() / particles.size();
  for (std::size_t p = begin; p < end; ++p)
    if (!(particles.F[p].determinant() > 0))
      throw turned_inside_out(s.steps, p, particles.F[p].determinant());
  // The particles of a body stand together: its material is asked for all of them.
  for (std::size_t p = begin; p < end;) {
    const std::int32_t body = particles.body[p];
    const auto update = [&](const auto& material) {
      for (; p < end && particles.body[p] == body; ++p)
        strain_particle(material, particles.F[p], particles.L[p], dt, particles.volume0[p],
                        particles.stress[p], particles.energy[p],
                        particles.history.data() + p * history);
    };
    std::visit(update, problem.materials[static_cast<std::size_t>(body)]);
  }
}

#define RECON_INSTANTIATE(D)                                                            \
  template void strain(const Problem<D>&, std::size_t, std::size_t, double, State<D>&); \
  template void strain_to(const Problem<D>&, std::size_t, std::size_t, double, State<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
