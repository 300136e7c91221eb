// Moments of particles at the nodes of a grid, summed up from several sources before
// they are solved.
//
// ```cpp
//   recon::GridMoments moments(points, {velocity}, grid, options);  // each process: its particles
//   moments += others;                      // or add up values() yourself, for example by MPI
//   recon::GridReconstruction fit = moments.solve();
// ```
//
// Moments about the nodes are additive over particles: M and b of reconstruct_on_grid.hpp from all
// particles are the sums of those from any parts of them. Each node has per_node() numbers, which
// are in this order:
//     the number of particles
//     C(2 R + D, D) moments sum m_p w_ip xi^alpha, as Monomials<D, 2 R>
//     for each component C(R + D, D) right-hand sides sum m_p w_ip xi^alpha u_p, as Monomials<D, R>
//
// solve() does not have the particles any more. Where the moment matrix is not safe it lowers the
// degree until it is (by the bound of FitReport::amplification, where that exceeds the leverage
// limit). The status is then `reduced`, and the value may differ from that of
// reconstruct_on_grid(), which would keep the directions that the particles do resolve. Elsewhere
// both agree to rounding.
//
// m_p are the particle weights as they are given, whatever their unit.
//
// Memory: per_node() numbers a node, for example 23 for a velocity in 3-D at degree 1. Throws
// InvalidArgument as reconstruct_on_grid() does, and also for all that goes by lists there (naming
// the option: a degree above 2, a periodic domain, exact gradients), for a limit (the range of the
// data is not among the moments) and for the addition of moments that differ in their grid, options
// or components.
#pragma once

#include <memory>
#include <span>

#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon {

template <class Scalar>
struct GridPlan;

template <class Scalar>
class BasicGridMoments {
 public:
  BasicGridMoments(const PointsView<Scalar>& points, const std::vector<FieldView<Scalar>>& fields,
                   const StructuredGrid<Scalar>& grid, const Options& options = {});

  BasicGridMoments& operator+=(const BasicGridMoments& other);
  BasicGridReconstruction<Scalar> solve(const GridApply& apply = {}) const;

  int per_node() const;
  // The moments of all nodes, one node after another, per_node() numbers for each.
  std::span<Scalar> values() { return values_; }
  std::span<const Scalar> values() const { return values_; }

 private:
  std::shared_ptr<const GridPlan<Scalar>> plan_;
  std::vector<Scalar> values_;
};

using GridMoments = BasicGridMoments<double>;
using GridMomentsF = BasicGridMoments<float>;

extern template class BasicGridMoments<float>;
extern template class BasicGridMoments<double>;

}  // namespace recon
