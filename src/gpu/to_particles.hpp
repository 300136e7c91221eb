// From nodes to particles: functors of a step on a GPU (step_on.hpp).
#pragma once

#include <limits>

#include "gpu/to_nodes.hpp"

namespace recon::mpm {

// What the particles of a step take from the nodes (update.cpp).
struct Taken {
  bool velocity = true, strain = true, position = true;
};

// The first particle that is turned inside out, and the first one that is not in the grid.
struct Lost {
  std::uint32_t turned = cuda::none, off_grid = cuda::none;
};
struct NothingLost {
  Lost* lost;
  RECON_DEVICE void operator()(std::size_t) const { *lost = Lost{}; }
};

template <int D, class Functions>
struct TakeFromNodes {
  GridNumbers<D> grid;
  Functions functions;
  ParticleNumbers<D> particles;
  const MaterialOnGpu* materials;
  std::size_t history;  // variables of a particle
  const WallNumbers<D>* walls;
  int wall_count;
  const double *carried, *straining, *acceleration;  // of nodes
  double kick, pic, dt;
  Taken taken;
  Lost* lost;

  RECON_DEVICE void operator()(std::size_t p) const {
    double* const x = particles.x + p * D;
    double v[D], a[D];
    SmallMatrix<D> L = SmallMatrix<D>::Zero();
    see(p, x, v, a, L);
    if (taken.strain) L.put(particles.L + p * D * D);
    if (taken.velocity) kick_particle<D>(pic, kick, v, a, particles.v + p * D);
    if (taken.position)
      for (int d = 0; d < D; ++d) x[d] += dt * v[d];
    if (taken.strain) strain(p, L);
    if (taken.position) keep_inside(p, x);
  }

  // What a particle sees of the nodes; and the slopes of its velocity where it has such modes.
  RECON_DEVICE void see(std::size_t p, const double* x, double* v, double* a,
                        SmallMatrix<D>& L) const {
    const AxesAt<D, Functions> at(functions, grid, x);
    const bool with_slopes = taken.velocity && particles.modes != nullptr;
    recon::detail::AxisModes modes[D]{};
    double norm[D]{}, moment[D * D]{};
    for (int d = 0; d < D; ++d) v[d] = a[d] = 0;
    if (with_slopes) {
      for (int d = 0; d < D; ++d)
        modes[d] = recon::detail::modes_of_axis(grid, at.axis[d], x[d], d, false);
      for (int d = 0; d < D; ++d) {
        norm[d] = modes[d].norm[1];
        for (int e = 0; e < D; ++e) norm[d] *= e == d ? 1 : modes[e].norm[0];
      }
    }
    int k[3] = {0, 0, 0}, count[3] = {1, 1, 1}, index[D];
    for (int d = 0; d < D; ++d) count[d] = at.axis[d].count;
    for (k[2] = 0; k[2] < count[2]; ++k[2])
      for (k[1] = 0; k[1] < count[1]; ++k[1])
        for (k[0] = 0; k[0] < count[0]; ++k[0]) {
          for (int d = 0; d < D; ++d) index[d] = at.axis[d].first + k[d];
          const std::size_t i = grid.node_number(index) * D;
          double G[D];
          const double S = at.product(k, G);
          for (int d = 0; d < D; ++d) {
            v[d] += S * carried[i + d];
            a[d] += S * acceleration[i + d];
            for (int c = 0; c < D; ++c) L(d, c) += straining[i + d] * G[c];
          }
          for (int e = 0; e < D && with_slopes; ++e)
            for (int d = 0; d < D; ++d)
              moment[e * D + d] += S * modes[e].value[1][k[e]] * carried[i + d];
        }
    for (int e = 0; e < D && with_slopes; ++e)
      for (int d = 0; d < D; ++d)
        particles.modes[(p * D + e) * D + d] = norm[e] > 0 ? moment[e * D + d] / norm[e] : 0;
  }

  RECON_DEVICE void strain(std::size_t p, const SmallMatrix<D>& L) const {
    const auto F = deformed(SmallMatrix<D>::at(particles.F + p * D * D), L, dt);
    F.put(particles.F + p * D * D);
    if (!(F.determinant() > 0))
      return cuda::keep_least(&lost->turned, static_cast<std::uint32_t>(p));
    auto stress = SmallMatrix<D>::at(particles.stress + p * D * D);
    materials[particles.body[p]].visit([&](const auto& material) {
      strain_particle(material, F, L, dt, particles.volume0[p], stress, particles.energy[p],
                      particles.history + p * history);
    });
    stress.put(particles.stress + p * D * D);
  }

  // Puts back what has passed a wall by a hair.
  RECON_DEVICE void keep_inside(std::size_t p, double* x) const {
    for (int w = 0; w < wall_count; ++w) {
      const WallNumbers<D>& wall = walls[w];
      if (passes_by_a_hair(x[wall.axis], wall.face, wall.upper, grid.h()) &&
          is_covered<D>(wall.axis, wall.from, wall.to, x, 0))
        x[wall.axis] = wall.face;
    }
    if (!grid.contains(x)) cuda::keep_least(&lost->off_grid, static_cast<std::uint32_t>(p));
  }
};

// The step that a particle allows, in the order of particles where two allow the same.
struct Allowed {
  double dt;
  std::uint32_t particle;
};
struct Shorter {
  RECON_DEVICE Allowed operator()(const Allowed& a, const Allowed& b) const {
    if (a.dt == b.dt) return a.particle < b.particle ? a : b;
    return b.dt < a.dt ? b : a;
  }
};
template <int D>
struct AllowedStep {
  ParticleNumbers<D> particles;
  const MaterialOnGpu* materials;
  StepRule rule;
  double courant, h;

  RECON_DEVICE Allowed operator()(std::size_t p) const {
    double speed2 = 0, speed = 0;
    for (int d = 0; d < D; ++d) speed2 += particles.v[p * D + d] * particles.v[p * D + d];
    const double det_F = SmallMatrix<D>::at(particles.F + p * D * D).determinant();
    materials[particles.body[p]].visit([&](const Lame& elastic) {
      speed = fastest(rule, elastic, particles.mass[p], particles.volume0[p], det_F,
                      recon::detail::square_root(speed2));
    });
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const double dt = courant * h / speed;
    return dt < infinite ? Allowed{dt, static_cast<std::uint32_t>(p)} : Allowed{infinite, 0};
  }
};

}  // namespace recon::mpm
