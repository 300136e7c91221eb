// reconstruct_on_grid(points, fields, grid, options): particle data at the nodes of a regular grid.
//
// ```cpp
//   const recon::GridReconstruction v = recon::reconstruct_on_grid(
//       points, {velocity}, grid, {.degree = 1, .weight = recon::Weight::cubic_b_spline});
//   const Eigen::MatrixXd& at_nodes = v.values();  // a row per node, 3 columns
//   const recon::GridReconstruction s = recon::reconstruct_on_grid(
//       points, {stress, density}, recon::cell_centres(grid),
//       {.weight = recon::Weight::quadratic_b_spline});  // 6 + 1 columns
// ```
//
// Moving least squares at every node x_i (Gong 2015, eq. 3.6-3.8), with xi = (x_p - x_i) / rho per
// axis, w_ip = w(xi), m_p >= 0 the weight of a particle (its mass or volume; 1 unless given), and
// m the monomials:
//     M_i = sum_p m_p w_ip m(xi) m(xi)^T ,  b_i = sum_p m_p w_ip m(xi) u_p ,  M_i a = b_i ;
// the value is a_0, the gradient a_1 .. a_D divided by rho. Both are sums over particles: they
// are formed cell by cell of particles, without neighbour lists, and solved as soon as a row of
// nodes is complete.
//
// The values are, up to rounding, those of reconstruct() with Radius, the same weight and the
// solver moment_matrix; and as there, a node whose moment matrix is not safe is fitted anew from
// its particles by graded Gram-Schmidt. The FitReport is that of reconstruct() as well; its
// `neighbours` counts the particles with m_p > 0 and w_ip > eps^2 w(0). A node without any has the
// status no_support and the value fill_value.
//
// Particles may lie anywhere: those that no node sees count for nothing. Throws InvalidArgument
// for sizes and dimensions that differ, bad options, coordinates and data that are not finite
// (naming the particle and the component), negative m_p, and results that are too large for the
// precision (naming the node). The unit of m_p does not matter. Sums of any number of particles
// are good to a few roundings.
//
// Cost: linear in the number of particles. Memory beyond the result: 4 bytes for each particle (16
// while they are sorted), half a byte for each node, and per thread about a megabyte of moments.
// The same bits for any number of threads.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "recon/grid/grid_options.hpp"
#include "recon/operators/fit_summary.hpp"
#include "recon/operators/limit.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon {

// Values, gradients and reports at the nodes, in the order of the nodes of StructuredGrid.
template <class Scalar>
class BasicGridReconstruction {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  BasicGridReconstruction() = default;
  BasicGridReconstruction(Matrix values, Matrix gradients, FitReports reports,
                          LimitCount limited = {})
      : values_(std::move(values)),
        gradients_(std::move(gradients)),
        reports_(std::move(reports)),
        limited_(std::move(limited)) {}

  // A row per node; the components of all fields, in the order in which they were given.
  const Matrix& values() const& { return values_; }
  Matrix values() && { return std::move(values_); }
  // d u_c / d x_d in column c * dimension + d, unit of u / length; no columns unless asked for.
  const Matrix& gradients() const& { return gradients_; }
  Matrix gradients() && { return std::move(gradients_); }
  const FitReports& report() const { return reports_; }
  // What GridOptions::limit changed, per node; empty without it.
  const LimitCount& limited() const { return limited_; }

 private:
  Matrix values_, gradients_;
  FitReports reports_;
  LimitCount limited_;
};

using GridReconstruction = BasicGridReconstruction<double>;
using GridReconstructionF = BasicGridReconstruction<float>;

// particle_weights: m_p, one number for each particle; an empty view stands for all ones.
GridReconstruction reconstruct_on_grid(const PointsView<double>& points,
                                       const std::vector<FieldView<double>>& fields,
                                       const StructuredGrid<double>& grid,
                                       const GridOptions& options = {},
                                       const FieldView<double>& particle_weights = {});
GridReconstructionF reconstruct_on_grid(const PointsView<float>& points,
                                        const std::vector<FieldView<float>>& fields,
                                        const StructuredGrid<float>& grid,
                                        const GridOptions& options = {},
                                        const FieldView<float>& particle_weights = {});

// The grid of the centres of a grid's cells: one fewer along each axis, half a spacing further in.
// Throws InvalidArgument where an axis has fewer than two nodes.
template <class Scalar>
StructuredGrid<Scalar> cell_centres(StructuredGrid<Scalar> grid) {
  grid.validate();
  for (int d = 0; d < grid.dimension; ++d) {
    detail::require(grid.counts[d] >= 2, "grid nodes along an axis", grid.counts[d],
                    "must be at least 2 to have cells between them");
    --grid.counts[d];
    grid.origin[d] += grid.spacing[d] / 2;
  }
  return grid;
}

}  // namespace recon
