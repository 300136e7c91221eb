// reconstruct_on_grid(particles, fields, grid, options): particle data at the nodes of a regular
// grid.
//
// ```cpp
//   const recon::GridReconstruction v = recon::reconstruct_on_grid(points, {velocity}, grid);
//   const Eigen::MatrixXd& at_nodes = v.values();  // a row per node, 3 columns
//   const recon::GridReconstruction s = recon::reconstruct_on_grid(
//       sources, {stress, density}, recon::cell_centres(grid),
//       {.weight = recon::Weight::quadratic_b_spline}, {.gradients = recon::Derivative::diffuse});
// ```
//
// Moving least squares at every node x_i (Gong 2015, eq. 3.6-3.8), with xi = (x_p - x_i) / rho per
// axis, w_ip = w(xi), m_p > 0 the weight of a particle (its mass or volume; 1 unless given), and m
// the monomials:
//     M_i = sum_p m_p w_ip m(xi) m(xi)^T ,  b_i = sum_p m_p w_ip m(xi) u_p ,  M_i a = b_i ;
// the value is a_0, the gradient a_1 .. a_D divided by rho. Both are sums over particles.
//
// The options are those of reconstruct(), and what they leave empty is what grids need
// (shape/options.hpp): by default tensor products of cubic B-splines of the natural support, two
// spacings to each side. The result is, to rounding, that of reconstruct(particles, grid, options)
// and of its operators; ask that for transposes, or for many fields one after another.
//
// There are two ways to it.
//   By moments: M and b of all nodes are summed cell by cell of particles, without neighbour lists,
//   and solved as soon as a row of nodes is complete; a node whose moment matrix is not safe is
//   fitted anew from its particles by graded Gram-Schmidt. Memory beyond the result: 4 bytes for
//   each particle (16 while they are sorted; 8 per coordinate more from Sources), half a byte for
//   each node, and per thread about a megabyte.
//   By lists, as reconstruct() does, for 4,096 nodes at a time. In 3-D, with 8 particles to a cell,
//   12 times the time of moments at degree 1, three times at degree 2. Memory: that of Sources, and
//   12 bytes (36 with gradients) for each pair of these nodes and their particles: 25 MB for the
//   512 of a cubic spline.
// Moments are used at degree 0 to 2, with the natural support or Radius, at most 8 spacings along
// each axis, with the solver moment_matrix (or none said), and without a periodic domain,
// `visible`, `grow`, `max_distance`, Unsupported::nearest, a search method and exact gradients.
// All else goes by lists. Both ways have the same reports: `neighbours` counts the particles with
// w_ip > eps^2 w(0), and a node without any has the status no_support and the value fill_value.
//
// Particles may lie anywhere: those that no node sees count for nothing. In a periodic domain nodes
// are where their images are: on both borders they see the same particles. Throws InvalidArgument
// for sizes and dimensions that differ, bad options, coordinates and data that are not finite
// (naming the particle and the component), and results that are too large for the precision (naming
// the node). The unit of m_p does not matter. Sums of any number of particles are good to a few
// roundings. The same bits for any number of threads, and from Sources the same as from points.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "recon/neighbourhood/sources.hpp"
#include "recon/operators/fit_summary.hpp"
#include "recon/operators/limit.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/structured_grid.hpp"
#include "recon/shape/options.hpp"

namespace recon {

// What is made of the fields.
struct GridApply {
  // Gradients too. diffuse: of the local polynomial, zero at degree 0. exact: of the reconstructed
  // field. Both are zero in directions that the particles do not resolve
  // (FitReport::gradient_rank).
  std::optional<Derivative> gradients{};
  // Keeps each value in or near the range of the data in its support (operators/limit.hpp).
  // Gradients are never limited.
  Limit limit = Limit::none;

  // Throws InvalidArgument for numbers that are no enumerators.
  void validate() const {
    if (gradients) detail::require_derivative(*gradients);
    detail::require_limit(limit);
  }
};

// Values, gradients and reports at the nodes, in the order of the nodes of StructuredGrid. One that
// is made by its default constructor is of no nodes: empty().
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

  // The number of nodes.
  std::size_t size() const { return reports_.size(); }
  bool empty() const { return size() == 0; }

  // A row per node; the components of all fields, in the order in which they were given.
  const Matrix& values() const& { return values_; }
  Matrix values() && { return std::move(values_); }
  // d u_c / d x_d in column c * dimension + d, unit of u / length; no columns unless asked for.
  const Matrix& gradients() const& { return gradients_; }
  Matrix gradients() && { return std::move(gradients_); }
  const FitReports& report() const { return reports_; }
  // What GridApply::limit changed, per node; empty without it.
  const LimitCount& limited() const { return limited_; }

 private:
  Matrix values_, gradients_;
  FitReports reports_;
  LimitCount limited_;
};

using GridReconstruction = BasicGridReconstruction<double>;
using GridReconstructionF = BasicGridReconstruction<float>;

GridReconstruction reconstruct_on_grid(const PointsView<double>& points,
                                       const std::vector<FieldView<double>>& fields,
                                       const StructuredGrid<double>& grid,
                                       const Options& options = {}, const GridApply& apply = {});
GridReconstructionF reconstruct_on_grid(const PointsView<float>& points,
                                        const std::vector<FieldView<float>>& fields,
                                        const StructuredGrid<float>& grid,
                                        const Options& options = {}, const GridApply& apply = {});

// Domain, stretch and particle weights are those of the Sources.
GridReconstruction reconstruct_on_grid(const Sources& sources,
                                       const std::vector<FieldView<double>>& fields,
                                       const StructuredGrid<double>& grid,
                                       const Options& options = {}, const GridApply& apply = {});
GridReconstructionF reconstruct_on_grid(const SourcesF& sources,
                                        const std::vector<FieldView<float>>& fields,
                                        const StructuredGrid<float>& grid,
                                        const Options& options = {}, const GridApply& apply = {});

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
