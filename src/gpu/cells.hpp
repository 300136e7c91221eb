// The quadrature over cells (mpm/quadrature.cpp): functors of a step on a GPU (step_on.hpp).
#pragma once

#include "gpu/to_nodes.hpp"
#include "mpm/cellwise.hpp"

namespace recon::mpm {

// What is fitted at the centres of cells: the density, and the stress row after row of its upper
// triangle.
template <int D>
inline constexpr int cell_components = 1 + D*(D + 1) / 2;

template <int D>
struct MakeCellData {
  ParticleNumbers<D> particles;
  double* data;

  RECON_DEVICE void operator()(std::size_t p) const {
    double* out = data + p * cell_components<D>;
    const double det_F = SmallMatrix<D>::at(particles.F + p * D * D).determinant();
    const auto stress = SmallMatrix<D>::at(particles.stress + p * D * D);
    *out++ = particles.mass[p] / (det_F * particles.volume0[p]);
    for (int r = 0; r < D; ++r)
      for (int c = r; c < D; ++c) *out++ = stress(r, c);
  }
};

// The volume of the particles in each cell.
template <int D>
struct SumVolumes {
  const std::uint32_t *first, *order;
  ParticleNumbers<D> particles;
  double* volumes;

  RECON_DEVICE void operator()(std::size_t c) const {
    double sum = 0;
    for (std::uint32_t place = first[c]; place < first[c + 1]; ++place) {
      const std::size_t p = order[place];
      sum += SmallMatrix<D>::at(particles.F + p * D * D).determinant() * particles.volume0[p];
    }
    volumes[c] = sum;
  }
};

template <int D>
struct FillCells {
  GridNumbers<D> grid;
  const double* volumes;
  double* fill;

  RECON_DEVICE void operator()(std::size_t c) const {
    int at[D];
    grid.cell_index(c, at);
    bool inside = true;
    grid.for_cells_around(
        at, 1, 1, [&](const int*, std::size_t cell) { inside = inside && volumes[cell] > 0; });
    fill[c] = part_that_counts(volumes[c], inside, grid.cell_volume());
  }
};

// Mass and internal force of a node from the middles of its cells.
template <int D>
struct SumCellsToNodes {
  GridNumbers<D> grid;
  const double *fill, *values;
  NodeNumbers nodes;

  RECON_DEVICE void operator()(std::size_t i) const {
    int index[D];
    grid.node_index(i, index);
    const double cell_volume = grid.cell_volume();
    double mass = 0, force[D];
    for (int d = 0; d < D; ++d) force[d] = 0;
    grid.for_cells_around(index, 1, 0, [&](const int* cell, std::size_t number) {
      if (!(fill[number] > 0)) return;
      double middle[D], G[D];
      int k[D];
      for (int d = 0; d < D; ++d) {
        middle[d] = grid.node(cell[d], d) + grid.h() / 2;
        k[d] = index[d] - cell[d];
      }
      const AxesAt<D, LinearFunctions> at(LinearFunctions{}, grid, middle);
      const double S = at.product(k, G), volume = fill[number] * cell_volume;
      const double* row = values + number * cell_components<D>;
      mass += S * volume * *row++;
      for (int r = 0; r < D; ++r)
        for (int c = r; c < D; ++c, ++row) {
          force[r] -= volume * *row * G[c];
          if (c != r) force[c] -= volume * *row * G[r];
        }
    });
    nodes.mass[i] = mass;
    for (int d = 0; d < D; ++d) nodes.force[i * D + d] = force[d];
  }
};

// The first node of negative mass, and the first whose mass has another sign than before.
struct Watched {
  std::uint32_t negative = cuda::none, change = cuda::none;
};
struct NothingWatched {
  Watched* watched;
  RECON_DEVICE void operator()(std::size_t) const { *watched = Watched{}; }
};
struct WatchMass {
  const double *mass, *heaviest;
  signed char* signs;  // of the time before, 0 where there is none
  Watched* watched;

  RECON_DEVICE void operator()(std::size_t i) const {
    const int sign = sign_of_mass(mass[i], *heaviest);
    if (sign * signs[i] < 0) cuda::keep_least(&watched->change, static_cast<std::uint32_t>(i));
    if (sign < 0) cuda::keep_least(&watched->negative, static_cast<std::uint32_t>(i));
    signs[i] = static_cast<signed char>(sign);
  }
};
struct NoSign {
  signed char* signs;
  RECON_DEVICE void operator()(std::size_t i) const { signs[i] = 0; }
};

}  // namespace recon::mpm
