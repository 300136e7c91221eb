// Particles whose corners move with the grid (CPDI2), with affine velocities or without: the
// functors of to_nodes.hpp and to_particles.hpp for them.
//
// The functions of such a particle are sums over its corners, S_i = sum_a w_a N_i(x_a) and
// G_i = sum_a g_a N_i(x_a). So the corners are what is sorted by cells and gives to the nodes, each
// with the linear functions of its cell.
#pragma once

#include "gpu/symmetric.hpp"
#include "gpu/to_particles.hpp"
#include "recon/transfer/domain_functions.hpp"

namespace recon::mpm {

template <int D>
using CornerGauss = recon::detail::CornerGauss<D>;

// The functions of a corner: those of its cell, which go on beyond the grid.
template <int D>
using AtCorner = AxesAt<D, ContinuedLinearFunctions>;

// Calls use(a, b, node, N) for each corner a of a particle and each node b of its cell.
template <int D, class Use>
RECON_DEVICE void for_nodes_of_corners(const GridNumbers<D>& grid, const double* corners,
                                       const Use& use) {
  constexpr int count = 1 << D;
  for (int a = 0; a < count; ++a) {
    const AtCorner<D> at(ContinuedLinearFunctions{}, grid, corners + a * D);
    for (int b = 0; b < count; ++b) {
      int index[D];
      double N = 1;
      for (int d = 0; d < D; ++d) {
        const int up = b >> d & 1;
        index[d] = at.axis[d].first + up;
        N *= at.axis[d].S[static_cast<std::size_t>(up)];
      }
      use(a, index, N);
    }
  }
}

// What a particle with corners sees the nodes by.
template <int D>
struct SeenByCorners {
  static constexpr int count = 1 << D;
  double weight[count], slope[count * D], mean[D], volume;

  RECON_DEVICE SeenByCorners(const CornerGauss<D>& gauss, const double* corners) {
    volume = recon::detail::average_over_corners<SmallMatrix<D>>(gauss, corners, weight, slope);
    for (int d = 0; d < D; ++d) {
      mean[d] = 0;
      for (int a = 0; a < count; ++a) mean[d] += weight[a] * corners[a * D + d];
    }
  }
};

// Corner number a of particle p has the number p 2^D + a.
template <int D>
struct GivenByCorner {
  double x[D], mass, momentum[D], force[D];
};
template <int D>
struct GivenSlopeByCorner {
  double moment[D * D], mean[D];  // m w C, and the mean of the particle's nodes
};

template <int D>
struct MakeGivenByCorners {
  const CornerGauss<D>* gauss;
  ParticleNumbers<D> particles;
  GivenByCorner<D>* given;        // by corner
  GivenSlopeByCorner<D>* slopes;  // null: the velocity map has none

  RECON_DEVICE void operator()(std::size_t p) const {
    constexpr int count = 1 << D;
    const double* const corners = particles.corners + p * count * D;
    const SeenByCorners<D> seen(*gauss, corners);
    const double mass = particles.mass[p];
    for (int a = 0; a < count; ++a) {
      GivenByCorner<D> out;
      out.mass = mass * seen.weight[a];
      for (int d = 0; d < D; ++d) {
        out.x[d] = corners[a * D + d];
        out.momentum[d] = out.mass * particles.v[p * D + d];
        out.force[d] = 0;
        for (int c = 0; c < D; ++c)
          out.force[d] -=
              seen.volume * particles.stress[(p * D + c) * D + d] * seen.slope[a * D + c];
      }
      given[p * count + a] = out;
      if (slopes == nullptr) continue;
      GivenSlopeByCorner<D> slope;
      for (int k = 0; k < D * D; ++k) slope.moment[k] = out.mass * particles.modes[p * D * D + k];
      for (int d = 0; d < D; ++d) slope.mean[d] = seen.mean[d];
      slopes[p * count + a] = slope;
    }
  }
};

template <int D>
struct SumCornersToNodes {
  GridNumbers<D> grid;
  const std::uint32_t *first, *order;
  const GivenByCorner<D>* given;
  const GivenSlopeByCorner<D>* slopes;
  NodeNumbers nodes;

  RECON_DEVICE void operator()(std::size_t i) const {
    int index[D];
    grid.node_index(i, index);
    double place[D];
    for (int d = 0; d < D; ++d) place[d] = grid.node(index[d], d);
    double mass = 0, momentum[D], force[D];
    for (int d = 0; d < D; ++d) momentum[d] = force[d] = 0;
    grid.for_cells_around(index, 1, 0, [&](const int*, std::size_t c) {
      for (std::uint32_t at = first[c]; at < first[c + 1]; ++at) {
        const GivenByCorner<D>& one = given[order[at]];
        const AtCorner<D> functions(ContinuedLinearFunctions{}, grid, one.x);
        double N = 1;
        for (int d = 0; d < D; ++d)
          N *= functions.axis[d].S[static_cast<std::size_t>(index[d] - functions.axis[d].first)];
        mass += N * one.mass;
        for (int d = 0; d < D; ++d) {
          momentum[d] += N * one.momentum[d];
          force[d] += N * one.force[d];
        }
        if (slopes == nullptr) continue;
        const GivenSlopeByCorner<D>& slope = slopes[order[at]];
        for (int e = 0; e < D; ++e)
          for (int d = 0; d < D; ++d)
            momentum[d] += N * slope.moment[e * D + d] * (place[e] - slope.mean[e]);
      }
    });
    nodes.mass[i] = mass;
    for (int d = 0; d < D; ++d) {
      nodes.momentum[i * D + d] = momentum[d];
      nodes.force[i * D + d] = force[d];
    }
  }
};

// Of TakeFromNodes, what a particle sees and how it moves.
template <int D>
struct TakeByCorners {
  static constexpr int count = 1 << D;
  const CornerGauss<D>* gauss;
  TakeFromNodes<D, LinearFunctions> as_point;

  RECON_DEVICE void operator()(std::size_t p) const {
    const auto& at = as_point;
    const Taken& taken = at.taken;
    double* const corners = at.particles.corners + p * count * D;
    const SeenByCorners<D> seen(*gauss, corners);
    double v[D], a[D], of_corner[count * D], moment[D * D];
    SmallMatrix<D> L = SmallMatrix<D>::Zero(), second = SmallMatrix<D>::Zero();
    const bool with_slopes = taken.velocity && at.particles.modes != nullptr;
    for (int d = 0; d < D; ++d) v[d] = a[d] = 0;
    for (int k = 0; k < count * D; ++k) of_corner[k] = 0;
    for (int k = 0; k < D * D; ++k) moment[k] = 0;
    for_nodes_of_corners(at.grid, corners, [&](int corner, const int* index, double N) {
      const std::size_t i = at.grid.node_number(index) * D;
      const double S = seen.weight[corner] * N;
      for (int d = 0; d < D; ++d) {
        of_corner[corner * D + d] += N * at.carried[i + d];
        v[d] += S * at.carried[i + d];
        a[d] += S * at.acceleration[i + d];
        for (int c = 0; c < D; ++c) L(d, c) += at.straining[i + d] * N * seen.slope[corner * D + c];
      }
      if (!with_slopes) return;
      double offset[D];
      for (int d = 0; d < D; ++d) offset[d] = at.grid.node(index[d], d) - seen.mean[d];
      for (int e = 0; e < D; ++e)
        for (int d = 0; d < D; ++d) {
          moment[e * D + d] += S * at.carried[i + d] * offset[e];
          second(d, e) += S * offset[d] * offset[e];
        }
    });
    if (with_slopes) {
      const double h = at.grid.h();
      const auto slope = SmallMatrix<D>::at(moment) * invert_where_seen(second, 1e-3 * h * h);
      slope.put(at.particles.modes + p * D * D);
    }
    double* const x = at.particles.x + p * D;
    if (taken.strain) L.put(at.particles.L + p * D * D);
    if (taken.velocity) kick_particle<D>(at.pic, at.kick, v, a, at.particles.v + p * D);
    if (taken.position) {
      for (int k = 0; k < count * D; ++k) corners[k] += at.dt * of_corner[k];
      const SeenByCorners<D> moved(*gauss, corners);
      for (int d = 0; d < D; ++d) x[d] = moved.mean[d];
    }
    if (taken.strain) at.strain(p, L);
    if (taken.position) at.keep_inside(p, x);
  }
};

}  // namespace recon::mpm
