// From the moments of nodes to values, gradients and reports.
#pragma once

#include <string>

#include "grid/aligned_array.hpp"
#include "grid/sweep.hpp"
#include "recon/core/error.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon {

template <class Scalar>
struct NodeFits {
  using Matrix = typename BasicGridReconstruction<Scalar>::Matrix;
  Matrix values, gradients;
  std::vector<FitReport> reports;

  NodeFits(const GridPlan<Scalar>& plan, bool with_gradients);
  bool has_gradients() const { return gradients.rows() > 0; }
  // The nodes that have particles and that RowSolver could not solve.
  std::vector<std::size_t> unsafe() const;
};

// Solves a row of nodes by the moment matrix; one object per thread. Nodes where it is not safe, or
// sums have left the range of numbers, are marked.
template <class Scalar>
class RowSolver {
 public:
  RowSolver(const GridPlan<Scalar>& plan, const LaneLayout& lanes, NodeFits<Scalar>& fits);
  void operator()(const FinishedRow<Scalar>& row);

 private:
  void set_noise(const FinishedRow<Scalar>& row);
  void take(std::size_t node, const Scalar* out, std::size_t count, Scalar weight_sum);
  bool in_range(const Scalar* out, Scalar weight_sum) const;

  const GridPlan<Scalar>& plan_;
  LaneLayout lanes_;
  NodeFits<Scalar>& fits_;
  FitReport full_;
  std::size_t out_size_;
  AlignedArray<Scalar> noise_, out_;
};

// Fits a node from its particles by graded Gram-Schmidt.
template <class Scalar>
void fit_from_particles(const ParticleData<Scalar>& particles, const ParticleBins& bins,
                        const GridPlan<Scalar>& plan, const std::vector<std::size_t>& nodes,
                        NodeFits<Scalar>& fits);

// Brings values of nodes back into the range of the data in their supports (operators/limit.hpp).
template <class Scalar>
LimitCount limit_nodes(const ParticleData<Scalar>& particles, const ParticleBins& bins,
                       const GridPlan<Scalar>& plan, Limit kind, NodeFits<Scalar>& fits);

// Fits nodes from moments ([node][quantity]), with the highest degree at which that is safe.
template <class Scalar>
void fit_reduced(const Scalar* moments, const GridPlan<Scalar>& plan,
                 const std::vector<std::size_t>& nodes, NodeFits<Scalar>& fits);

// Throws InvalidArgument for finite data whose result is too large for the precision.
template <class Scalar>
[[noreturn]] void throw_overflow(Scalar result, const char* what, int component, std::size_t node) {
  detail::throw_invalid(std::string(what) + " of component " + std::to_string(component) +
                            " at node " + std::to_string(node),
                        result, "overflows: the data, or the inverse of a support, are too large");
}

// The rounding error of (x_p - x_i) / rho at a node.
template <class Scalar>
Scalar node_noise(const GridPlan<Scalar>& plan,
                  const std::array<std::size_t, max_dimension>& index) {
  Scalar size = 1;
  for (int d = 0; d < plan.dimension(); ++d)
    size = std::max(size, 1 + std::abs(plan.grid.coordinate(index[d], d)) /
                                  static_cast<Scalar>(plan.axes[d].rho));
  return std::numeric_limits<Scalar>::epsilon() * size;
}

// Calls body(std::integral_constant<int, D>) for a plan.
template <class Scalar, class Body>
void with_dimension(const GridPlan<Scalar>& plan, Body&& body) {
  switch (plan.dimension()) {
    case 1:
      return body(std::integral_constant<int, 1>{});
    case 2:
      return body(std::integral_constant<int, 2>{});
    default:
      return body(std::integral_constant<int, 3>{});
  }
}

// Calls body(std::integral_constant<int, D>, std::integral_constant<int, R>) for a plan.
template <class Scalar, class Body>
void with_shape(const GridPlan<Scalar>& plan, Body&& body) {
  with_dimension(plan, [&](auto dimension) {
    switch (plan.options.degree) {
      case 0:
        return body(dimension, std::integral_constant<int, 0>{});
      case 1:
        return body(dimension, std::integral_constant<int, 1>{});
      default:
        return body(dimension, std::integral_constant<int, 2>{});
    }
  });
}

}  // namespace recon
