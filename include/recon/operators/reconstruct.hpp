// reconstruct(points, targets, options): scattered particle data become a field at all targets.
//
// ```cpp
//   const recon::Reconstruction fit = recon::reconstruct(
//       points, targets, {.degree = 1, .neighbours = recon::Radius{2 * h}});
//   Eigen::MatrixXd v      = fit.apply(velocity);               // a row per target
//   Eigen::MatrixXd grad_v = fit.gradient().apply(velocity);    // dvx/dx, dvx/dy, ..., dvy/dx, ...
//   Eigen::MatrixXd force  = fit.apply_transpose(nodal_force);  // a row per particle
//   if (fit.report().reduced() > 0) {
//     // fit.report()[t] says what became of target t
//   }
// ```
//
// At each target x the particles in its support are fitted with a polynomial of the asked degree
// (weighted least squares), and the value at x is a linear combination sum_p phi_p(x) u_p of the
// data. The phi_p depend on positions only: one reconstruction serves any number of fields.
// Polynomials up to the reported degree are reproduced to rounding; sum_p phi_p = 1 always.
// (Lancaster and Salkauskas 1981; Gong 2015, ch. 3; Tran et al. 2019, sec. 2.)
//
// A Reconstruction owns what it needs: your arrays may change or go once it is made. To follow
// moving particles, make it from Sources (neighbourhood/sources.hpp) and update both. Memory: about
// 12 bytes (double) per target and neighbour, and in 3-D 80 bytes per target (a report of 36, the
// coordinates, offset, support and number) and 30 per particle. One that has been moved from may
// only be assigned to or destroyed, as operators and Sources may.
//
// Several threads may use one Reconstruction at once through const functions (core/parallel.hpp
// says how threads are shared). Options::progress is told how far a long one has come, and can
// cancel it: the call throws Cancelled, and an update leaves what an update that fails leaves.
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "recon/neighbourhood/sources.hpp"
#include "recon/operators/csr_operator.hpp"
#include "recon/operators/fit_summary.hpp"
#include "recon/operators/functional.hpp"
#include "recon/operators/limit.hpp"
#include "recon/operators/vector_operator.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/structured_grid.hpp"
#include "recon/shape/options.hpp"
#include "recon/shape/shape_kernel.hpp"

namespace recon {

// For a choice that is made while the program runs.
using AnyFunctional = std::variant<Functional, OwnFunctional, VectorFunctional>;
template <class Scalar>
using AnyOperator = std::variant<CsrOperator<Scalar>, VectorOperator<Scalar>>;

namespace detail {
template <class Scalar>
class FitProblem;

template <class T>
concept OneFunctional = std::same_as<T, Functional> || std::same_as<T, OwnFunctional> ||
    std::same_as<T, VectorFunctional>;

// What acts on each component of a field by itself.
using ComponentFunctional = std::variant<Functional, OwnFunctional>;

inline ComponentFunctional base_of(const Functional& functional) {
  return functional;
}
inline ComponentFunctional base_of(const OwnFunctional& functional) {
  return functional;
}
inline ComponentFunctional base_of(const VectorFunctional& functional) {
  return Functional::gradient.with(functional.slopes());
}
}  // namespace detail

template <class Scalar>
class BasicReconstruction {
 public:
  using Matrix = typename CsrOperator<Scalar>::Matrix;

  // Of no particles and no targets, until one is assigned.
  BasicReconstruction();

  // Prefer reconstruct(). Throws InvalidArgument for bad options, coordinates that are not finite,
  // and dimensions that differ.
  BasicReconstruction(const PointsView<Scalar>& points, const PointsView<Scalar>& targets,
                      const Options& options);

  // With neighbours of your own: options.neighbours, search, visible and grow are not used. In a
  // periodic domain the list must have shifts. What its supports do while a target moves, and hence
  // the exact gradient, is said by NeighbourList::support_factor: by default they stand still.
  BasicReconstruction(const PointsView<Scalar>& points, const PointsView<Scalar>& targets,
                      NeighbourList<Scalar> neighbours, const Options& options);

  // From particles that have been ordered before. Their periodic domain, stretch and weights are
  // those of the Sources: InvalidArgument where the options say others.
  BasicReconstruction(const BasicSources<Scalar>& sources, const PointsView<Scalar>& targets,
                      const Options& options);
  BasicReconstruction(const BasicSources<Scalar>& sources, const PointsView<Scalar>& targets,
                      NeighbourList<Scalar> neighbours, const Options& options);

  // At the nodes of a grid. On one whose spacings differ, Sources want a rule for the neighbours:
  // InvalidArgument where it is left empty.
  BasicReconstruction(const PointsView<Scalar>& points, const StructuredGrid<Scalar>& grid,
                      const Options& options);
  BasicReconstruction(const BasicSources<Scalar>& sources, const StructuredGrid<Scalar>& grid,
                      const Options& options);

  // The same for other targets, and for the present positions of the Sources, into the memory that
  // there is; with another rule or list for the neighbours if one is given. The result equals that
  // of a new reconstruction in every bit. Copies of this object keep what they have. Throws as the
  // constructor does. Where coordinates, a rule or a list are refused as they stand, nothing has
  // changed; where the search or a fit fails with them, there are no targets until the next update.
  void update(const PointsView<Scalar>& targets);
  void update(const PointsView<Scalar>& targets, const NeighbourRule& neighbours);
  void update(const PointsView<Scalar>& targets, NeighbourList<Scalar> neighbours);
  // For the nodes of another grid, with the supports that there are.
  void update(const StructuredGrid<Scalar>& grid);

  // sum_p phi_p(x_t) u_p for every target t and component; see CsrOperator. With {.limit =
  // Limit::range} each value is kept in the range of the data it is made of, with Limit::relaxed
  // near it, as limit.hpp says; no other function here limits anything.
  Matrix apply(const FieldView<Scalar>& field, const Apply& how = {}) const;
  void apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out,
             const Apply& how = {}) const;
  void apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out, Data data) const {
    values_.apply(field, out, data);
  }
  // sum_t phi_p(x_t) f_t for every particle p.
  Matrix apply_transpose(const FieldView<Scalar>& field) const {
    return values_.apply_transpose(field);
  }
  void apply_transpose(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out) const {
    values_.apply_transpose(field, out);
  }

  const CsrOperator<Scalar>& values() const { return values_; }

  // The gradient of the reconstructed field (1/length), D blocks. exact: of x -> sum_p phi_p(x)
  // u_p, through weights, supports and solve: the support of the k nearest moves with them, others
  // stand still, and of a list of your own its support_factor says which. diffuse: of the local
  // polynomial, cheaper and of the same order for degree >= 1; at degree 0 it is zero. report()[t]
  // says in how many directions it is resolved (gradient_rank) and how much it amplifies errors of
  // the data; in the other directions, across lines and thin sheets, both kinds are zero, for
  // degree >= 1. Computed at each call: keep the result.
  CsrOperator<Scalar> gradient(Derivative kind = Derivative::exact) const;

  // The second derivatives of the local polynomial (1/length^2), D (D + 1) / 2 blocks; zero below
  // degree 2, in directions in which the gradient is not resolved, and where they cannot be told
  // from an unresolved slope. They are exact for quadratic fields in report()[t].hessian_rank
  // directions; where that is 0 they are zero or, with too few particles, not complete.
  CsrOperator<Scalar> hessian() const;

  // Operators of any functionals (functional.hpp), from one fit of each target for all of them: a
  // std::tuple of a CsrOperator for each Functional and OwnFunctional and a VectorOperator for each
  // VectorFunctional. Derivatives beyond the second and own functionals fit each target once more.
  template <detail::OneFunctional... Functionals>
  auto operators(const Functionals&... functionals) const {
    const std::array<detail::ComponentFunctional, sizeof...(Functionals)> bases{
        detail::base_of(functionals)...};
    std::vector<CsrOperator<Scalar>> made = operators_of(bases);
    return [&]<std::size_t... i>(std::index_sequence<i...>) {
      return std::tuple{finished(std::move(made[i]), functionals)...};
    }
    (std::index_sequence_for<Functionals...>{});
  }
  // The same for functionals that are chosen while the program runs.
  std::vector<AnyOperator<Scalar>> operators(std::span<const AnyFunctional> functionals) const;

  // What became of each target. After an update of the Sources, report(), neighbours() and support()
  // throw InvalidArgument until update(), as all use of the fit does.
  const FitReports& report() const;
  // Who was near each target, and its support: a copy. A target whose status is `nearest` has the
  // nearest particle and a support that reaches it, not the one asked for. Among particles at the
  // same distance a nearest rule takes the first ones in a spatial order, not those of the smallest
  // index. Other rules list in that order, the nearest rules in an order that is a function of the
  // positions, but not that of distances.
  NeighbourList<Scalar> neighbours() const;
  // The support radius of target t, a length.
  Scalar support(std::size_t target) const;

  int dimension() const;

 private:
  using Problem = detail::FitProblem<Scalar>;
  template <class... Neighbours>
  void fit(const PointsView<Scalar>& targets, Neighbours&&... neighbours);
  std::vector<CsrOperator<Scalar>> operators_of(
      std::span<const detail::ComponentFunctional> functionals) const;
  CsrOperator<Scalar> operator_of(const Functional& functional) const {
    const detail::ComponentFunctional base = functional;
    return std::move(operators_of({&base, 1}).front());
  }
  static CsrOperator<Scalar> finished(CsrOperator<Scalar>&& made, const Functional&) {
    return std::move(made);
  }
  static CsrOperator<Scalar> finished(CsrOperator<Scalar>&& made, const OwnFunctional&) {
    return std::move(made);
  }
  static VectorOperator<Scalar> finished(CsrOperator<Scalar>&& made, const VectorFunctional& f) {
    return {std::move(made), f};
  }
  Scalar fill() const;

  std::shared_ptr<Problem> problem_;
  CsrOperator<Scalar> values_;
};

using Reconstruction = BasicReconstruction<double>;
using ReconstructionF = BasicReconstruction<float>;

extern template class BasicReconstruction<float>;
extern template class BasicReconstruction<double>;

inline Reconstruction reconstruct(const PointsView<double>& points,
                                  const PointsView<double>& targets, const Options& options = {}) {
  return {points, targets, options};
}
inline ReconstructionF reconstruct(const PointsView<float>& points,
                                   const PointsView<float>& targets, const Options& options = {}) {
  return {points, targets, options};
}
template <std::same_as<NeighbourList<double>> List>
Reconstruction reconstruct(const PointsView<double>& points, const PointsView<double>& targets,
                           List neighbours, const Options& options = {}) {
  return {points, targets, std::move(neighbours), options};
}
template <std::same_as<NeighbourList<float>> List>
ReconstructionF reconstruct(const PointsView<float>& points, const PointsView<float>& targets,
                            List neighbours, const Options& options = {}) {
  return {points, targets, std::move(neighbours), options};
}

inline Reconstruction reconstruct(const Sources& sources, const PointsView<double>& targets,
                                  const Options& options = {}) {
  return {sources, targets, options};
}
inline ReconstructionF reconstruct(const SourcesF& sources, const PointsView<float>& targets,
                                   const Options& options = {}) {
  return {sources, targets, options};
}
template <std::same_as<NeighbourList<double>> List>
Reconstruction reconstruct(const Sources& sources, const PointsView<double>& targets,
                           List neighbours, const Options& options = {}) {
  return {sources, targets, std::move(neighbours), options};
}
template <std::same_as<NeighbourList<float>> List>
ReconstructionF reconstruct(const SourcesF& sources, const PointsView<float>& targets,
                            List neighbours, const Options& options = {}) {
  return {sources, targets, std::move(neighbours), options};
}

// At the nodes of a grid, node by node as StructuredGrid numbers them: what options leave empty is
// what grids need (shape/options.hpp). apply() gives the values of reconstruct_on_grid() with the
// same options, to rounding; this has its operators and their transposes as well.
inline Reconstruction reconstruct(const Sources& sources, const StructuredGrid<double>& grid,
                                  const Options& options = {}) {
  return {sources, grid, options};
}
inline ReconstructionF reconstruct(const SourcesF& sources, const StructuredGrid<float>& grid,
                                   const Options& options = {}) {
  return {sources, grid, options};
}
inline Reconstruction reconstruct(const PointsView<double>& points,
                                  const StructuredGrid<double>& grid, const Options& options = {}) {
  return {points, grid, options};
}
inline ReconstructionF reconstruct(const PointsView<float>& points,
                                   const StructuredGrid<float>& grid, const Options& options = {}) {
  return {points, grid, options};
}

}  // namespace recon
