#include "recon/mpm/problem.hpp"

#include "recon/core/parallel.hpp"

namespace recon::mpm {

template <int D>
void Problem<D>::follow_exact() {
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto state = exact->at(particles.X[p], 0);
    particles.v[p] = state.velocity;
    particles.L[p] = state.velocity_gradient;
  }
  body_force = [exact = exact](const Particles<D>& at, double t, int concurrency,
                               std::vector<Vector<D>>& out) {
    parallel_blocks(at.size(), 1024, concurrency, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) out[p] += exact->at(at.X[p], t).body_force;
    });
  };
}

template <int D>
void Problem<D>::validate() const {
  require(particles.size() > 0, "particles", particles.size(), "must be at least one");
  require(materials.size() == densities.size(), "densities", densities.size(),
          "must be one for each material");
  require(gravity.allFinite(), "gravity", gravity.transpose(), "must be finite");
  method.validate(D);
  if (is_element(method.basis))
    for (int d = 0; d < D; ++d)
      require(grid.cells(d) % 2 == 0, "cells of the grid along an axis", grid.cells(d),
              "must be even with elements of 2 x 2 cells");
  for (const double density : densities)
    require(density > 0 && std::isfinite(density), "density", density,
            "must be positive and finite");
  for (std::size_t p = 0; p < particles.size(); ++p) {
    require(particles.x[p].allFinite() && grid.contains(particles.x[p]), "position of a particle",
            particles.x[p].transpose(), "must lie in the grid");
    require(particles.v[p].allFinite(), "velocity of a particle", particles.v[p].transpose(),
            "must be finite");
    require(particles.mass[p] > 0 && std::isfinite(particles.mass[p]), "mass of a particle",
            particles.mass[p], "must be positive and finite");
    require(particles.volume(p) > 0, "volume of a particle", particles.volume(p),
            "must be positive");
    const int body = particles.body[p];
    require(body >= 0 && static_cast<std::size_t>(body) < materials.size(), "body of a particle",
            body, "must be the number of a material");
  }
  for (const Boundary<D>& boundary : boundaries) {
    require(boundary.axis >= 0 && boundary.axis < D, "axis of a boundary", boundary.axis,
            "must be an axis of the grid");
    const double plane = (boundary.at - grid.lower()[boundary.axis]) / grid.h();
    require(std::abs(plane - std::round(plane)) < 1e-6 && plane > -0.5 &&
                plane < grid.cells(boundary.axis) + 0.5,
            "place of a boundary", boundary.at, "must be a plane of nodes of the grid");
  }
  for (const Load<D>& load : loads)
    require(load.particle < particles.size() && load.magnitude, "particle of a load", load.particle,
            "must be one of the particles, with a magnitude");
  require(time.courant > 0 && std::isfinite(time.courant), "courant", time.courant,
          "must be positive and finite");
  require(time.rule != StepRule::fixed || (time.step > 0 && std::isfinite(time.step)), "step",
          time.step, "must be positive and finite");
}

template struct Problem<1>;
template struct Problem<2>;
template struct Problem<3>;

}  // namespace recon::mpm
