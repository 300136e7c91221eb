// Moments of particles at the nodes of a grid, summed and solved in the memory of a GPU.
//
// ```cpp
//   recon::cuda::Sources<3> sources({x_p, particle_count}, {}, stream);
//   recon::cuda::GridMoments<3> moments(sources, all_nodes, 1, {.degree = 1});
//   moments.sum({u_p, particle_count});
//   moments.solve({u_t, moments.nodes()});
// ```
//
// They are those of recon::GridMoments (grid/grid_moments.hpp), number by number in the same order
// and to rounding; m_p is 1. They are additive: values() of several processes or GPUs may be added
// up before solve(), which has the highest degree up to that asked for at which the moment matrix is
// safe. The options, and what is refused of them, are those of GridMoments: degree 0 to 2, the
// natural support of a B-spline or a Radius, tensor products or radial weights by name. Sources
// must have no periodic domain and no stretch.
//
// A thread gathers the particles of a node cell by cell, in their order: no sum depends on which
// thread comes first. Sums are plain ones: nodes that see thousands of particles lose digits in
// float. Overflow is not refused: values are then infinite or NaN.
//
// All work goes to the stream of the Sources and nobody waits for it; memory is taken by the
// constructor alone.
#pragma once

#include <cstdint>
#include <memory>

#include "recon/cuda/sources.hpp"
#include "recon/local_solve/report.hpp"
#include "recon/points/structured_grid.hpp"
#include "recon/shape/options.hpp"

namespace recon::cuda {

template <int D, class T = double>
class GridMoments {
 public:
  // For fields of so many components. Throws InvalidArgument for a bad grid, and for options that
  // are bad or beyond moments, naming them; Error where there is no memory.
  GridMoments(const Sources<D, T>& sources, const StructuredGrid<T>& grid, int components,
              const Options& options = {});
  GridMoments(GridMoments&&) noexcept;
  GridMoments& operator=(GridMoments&&) noexcept;
  ~GridMoments();

  // Sums the moments anew, of the particles where the Sources have them now. Throws InvalidArgument
  // for a field of another number of points or components.
  void sum(const Field<const T>& field);

  // Values at the nodes, in the order of StructuredGrid, and diffuse gradients: component c along
  // axis d is number c * D + d. fill_value where there is no particle. Throws InvalidArgument for
  // sizes that do not fit.
  void solve(const Field<T>& values);
  void solve(const Field<T>& values, const Field<T>& gradients);

  std::size_t nodes() const;
  int per_node() const;  // numbers
  // On the GPU: per_node() numbers for each node, which may be changed between sum() and solve();
  // and what became of each node in the last solve().
  T* values();
  const FitReport* reports() const;

 private:
  struct OnDevice;
  std::unique_ptr<OnDevice> on_device_;
};

}  // namespace recon::cuda
