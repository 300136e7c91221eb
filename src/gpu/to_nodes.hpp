// From particles to nodes: functors of a step on a GPU (step_on.hpp).
//
// Particles are sorted by the cells that they lie in, without being moved; what they give is
// written in that order. A node then goes through the cells whose particles may see it and adds up
// what they give, always in the same order, so that no two threads write to one number and sums
// have the same bits in every run.
#pragma once

#include <array>

#include "cuda/device_code.hpp"
#include "gpu/materials.hpp"
#include "gpu/matrix.hpp"
#include "gpu/particle_arrays.hpp"
#include "gpu/plan.hpp"
#include "mpm/pointwise.hpp"
#include "recon/transfer/modes.hpp"

namespace recon::mpm {

using cuda::least_of;
using cuda::most_of;

// The functions of all axes at a place.
template <int D, class Functions>
struct AxesAt {
  recon::detail::AxisFunctions<typename Functions::AxisCount> axis[D];

  RECON_DEVICE AxesAt(const Functions& functions, const GridNumbers<D>& grid, const double* x) {
    for (int d = 0; d < D; ++d) axis[d] = functions.axis(grid, x[d], d);
  }
  // S and G of the node with these places among those of the axes.
  RECON_DEVICE double product(const int* k, double* G) const {
    double S = 1;
    for (int d = 0; d < D; ++d) G[d] = 1;
    for (int d = 0; d < D; ++d) {
      S *= axis[d].S[static_cast<std::size_t>(k[d])];
      for (int e = 0; e < D; ++e)
        G[e] *= e == d ? axis[d].G[static_cast<std::size_t>(k[d])]
                       : axis[d].S[static_cast<std::size_t>(k[d])];
    }
    return S;
  }
};

// How many cells below and above the one that a particle lies in have nodes that it sees.
template <class Functions>
inline constexpr int cells_beyond = Functions::AxisCount::most == 2 ? 0 : 1;

template <int D>
struct KeyOfParticle {
  GridNumbers<D> grid;
  const double* x;
  std::uint32_t *key, *number;

  RECON_DEVICE void operator()(std::size_t p) const {
    int index[D];
    for (int d = 0; d < D; ++d) index[d] = grid.cell(x[p * D + d], d);
    key[p] = static_cast<std::uint32_t>(grid.cell_number(index));
    number[p] = static_cast<std::uint32_t>(p);
  }
};

// What a particle gives to its nodes: S times the mass and, with the slope C of affine velocities,
// S m (v + C (x_i - m_p)) where m_p is the mean of its nodes; pull G; and |G|^2 stiffness.
template <int D>
struct GivenByPoint {
  double x[D], mass, momentum[D], pull[D * D], stiffness;
};
template <int D>
struct GivenSlope {
  double moment[D * D];  // m C
};

// Of the particle that stands at a place of the order.
template <int D>
struct MakeGiven {
  ParticleNumbers<D> particles;
  const MaterialOnGpu* materials;
  const std::uint32_t* order;
  GivenByPoint<D>* given;
  GivenSlope<D>* slopes;  // null: the velocity map has none

  RECON_DEVICE void operator()(std::size_t place) const {
    const std::size_t p = order[place];
    const auto F = SmallMatrix<D>::at(particles.F + p * D * D);
    const double mass = particles.mass[p], volume = F.determinant() * particles.volume0[p];
    GivenByPoint<D> out;
    for (int d = 0; d < D; ++d) {
      out.x[d] = particles.x[p * D + d];
      out.momentum[d] = mass * particles.v[p * D + d];
    }
    for (int k = 0; k < D * D; ++k) out.pull[k] = -volume * particles.stress[p * D * D + k];
    out.mass = mass;
    out.stiffness = 0;
    materials[particles.body[p]].visit(
        [&](const Lame& elastic) { out.stiffness = volume * (elastic.lambda + 2 * elastic.mu); });
    given[place] = out;
    if (slopes == nullptr) return;
    GivenSlope<D> slope;
    for (int k = 0; k < D * D; ++k) slope.moment[k] = mass * particles.modes[p * D * D + k];
    slopes[place] = slope;
  }
};

// The arrays of nodes; vectors are D numbers.
struct NodeNumbers {
  double *mass, *momentum, *force;
  double *internal, *stiffness;  // of light nodes (Nodes), else null
  double *mapped, *velocity, *acceleration, *straining;
};

template <int D, class Functions>
struct SumToNodes {
  GridNumbers<D> grid;
  Functions functions;
  const std::uint32_t* first;  // the place of the first particle of each cell
  const GivenByPoint<D>* given;
  const GivenSlope<D>* slopes;
  NodeNumbers nodes;

  RECON_DEVICE void operator()(std::size_t i) const {
    constexpr int beyond = cells_beyond<Functions>;
    int index[D];
    grid.node_index(i, index);
    double mass = 0, stiffness = 0, momentum[D], force[D];
    for (int d = 0; d < D; ++d) momentum[d] = force[d] = 0;
    grid.for_cells_around(index, 1 + beyond, beyond, [&](const int*, std::size_t c) {
      for (std::uint32_t place = first[c]; place < first[c + 1]; ++place) {
        const GivenByPoint<D>& one = given[place];
        const AxesAt<D, Functions> at(functions, grid, one.x);
        int k[D];
        bool sees = true;
        for (int d = 0; d < D; ++d) {
          k[d] = index[d] - at.axis[d].first;
          sees = sees && k[d] >= 0 && k[d] < at.axis[d].count;
        }
        if (!sees) continue;
        double G[D], length2 = 0;
        const double S = at.product(k, G);
        mass += S * one.mass;
        for (int d = 0; d < D; ++d) {
          momentum[d] += S * one.momentum[d];
          for (int e = 0; e < D; ++e) force[d] += one.pull[e * D + d] * G[e];
          length2 += G[d] * G[d];
        }
        stiffness += one.stiffness * length2;
        if (slopes != nullptr) add_slope(slopes[place], at, k, S, one.x, momentum);
      }
    });
    nodes.mass[i] = mass;
    for (int d = 0; d < D; ++d) {
      nodes.momentum[i * D + d] = momentum[d];
      nodes.force[i * D + d] = force[d];
      if (nodes.internal != nullptr) nodes.internal[i * D + d] = force[d];
    }
    if (nodes.stiffness != nullptr) nodes.stiffness[i] = stiffness;
  }

  // S m C (x_i - m_p), without the directions in which the functions cannot tell a slope.
  RECON_DEVICE void add_slope(const GivenSlope<D>& slope, const AxesAt<D, Functions>& at,
                              const int* k, double S, const double* x, double* momentum) const {
    for (int e = 0; e < D; ++e) {
      const auto modes = recon::detail::modes_of_axis(grid, at.axis[e], x[e], e, false);
      if (!(modes.norm[1] > 0)) continue;
      const double along = S * modes.value[1][k[e]];
      for (int d = 0; d < D; ++d) momentum[d] += along * slope.moment[e * D + d];
    }
  }
};

struct SizeOfMass {
  const double* mass;
  RECON_DEVICE double operator()(std::size_t i) const { return magnitude(mass[i]); }
};
// v_i and a_i, before boundaries.
template <int D>
struct MoveNode {
  NodeNumbers nodes;
  const double* heaviest;
  double gravity[D];
  Damping damping;
  bool damped;
  // Velocities of a fit, and where there are any; null: there is no fit.
  const double* fitted;
  const std::uint32_t* supported;

  RECON_DEVICE void operator()(std::size_t i) const {
    double* const mapped = nodes.mapped + i * D;
    double* const acceleration = nodes.acceleration + i * D;
    move_node<D>(nodes.mass[i], nodes.momentum + i * D, nodes.force + i * D, gravity, *heaviest,
                 mapped, acceleration);
    const bool fits = fitted != nullptr && nodes.mass[i] > 0 && supported[i] > 0;
    for (int d = 0; d < D; ++d) {
      if (fits) mapped[d] = fitted[i * D + d];
      if (damped) acceleration[d] += damping_of(damping, mapped[d], acceleration[d]);
      nodes.velocity[i * D + d] = mapped[d];
    }
  }
};

// 1 for a node with mass whose velocity had to be mass-weighted.
struct IsUnfitted {
  const double* mass;
  const std::uint32_t* supported;
  RECON_DEVICE std::uint32_t operator()(std::size_t i) const {
    return mass[i] > 0 && supported[i] == 0 ? 1 : 0;
  }
};
struct Sum {
  RECON_DEVICE std::uint32_t operator()(std::uint32_t a, std::uint32_t b) const { return a + b; }
};

// Components of vectors of nodes become those that are held.
template <int D>
struct Hold {
  const HeldNode* held;
  const double* values;
  double* of_nodes;
  RECON_DEVICE void operator()(std::size_t h) const {
    of_nodes[held[h].node * std::size_t{D} + static_cast<std::size_t>(held[h].axis)] = values[h];
  }
};

// v_i+ = v_i + k a_i
struct KickNumber {
  double kick;
  const double* acceleration;
  double* velocity;
  RECON_DEVICE void operator()(std::size_t k) const { velocity[k] += kick * acceleration[k]; }
};

struct CopyNumber {
  const double* from;
  double* to;
  RECON_DEVICE void operator()(std::size_t k) const { to[k] = from[k]; }
};

// The velocities of which L is made, where light nodes would strain too much.
template <int D>
struct LimitStrain {
  NodeNumbers nodes;
  const double* heaviest;
  double kick, dt;

  RECON_DEVICE void operator()(std::size_t i) const {
    const double left_out =
        left_out_of_strain(nodes.mass[i], nodes.stiffness[i], kick, dt, *heaviest);
    for (int d = 0; d < D; ++d)
      nodes.straining[i * D + d] = nodes.velocity[i * D + d] - left_out * nodes.internal[i * D + d];
  }
};

}  // namespace recon::mpm
