#include "recon/operators/reconstruct.hpp"

#include <string>
#include <vector>

#include "core/instantiate.hpp"
#include "operators/fit_problem.hpp"
#include "operators/list_rows.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

using detail::require;

template <class Scalar>
std::shared_ptr<const detail::Cloud<Scalar>> cloud_of(const BasicSources<Scalar>& sources,
                                                      const Options& options) {
  options.validate_with_sources();
  return sources.cloud();
}

template <class Scalar>
std::shared_ptr<const detail::Cloud<Scalar>> cloud_of(const PointsView<Scalar>& points,
                                                      const PointsView<Scalar>& targets,
                                                      const Options& options) {
  options.validate();
  require(points.dimension() == targets.dimension(), "dimension of the targets",
          targets.dimension(), "must be that of the points");
  return std::make_shared<detail::Cloud<Scalar>>(points, options.sources());
}

// As for_grid(), where the stretch is that of the Sources.
template <class Scalar>
Options options_of_sources(const StructuredGrid<Scalar>& grid, const Options& options) {
  Options all = options.for_grid(grid);
  require(all.stretch == options.stretch, "neighbours", "empty",
          "must be said for Sources on a grid whose spacings differ: its natural supports differ "
          "between the axes, and the stretch that would say so belongs to the Sources");
  return all;
}

}  // namespace

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const PointsView<Scalar>& points,
                                                 const PointsView<Scalar>& targets,
                                                 const Options& options)
    : problem_(std::make_shared<Problem>(cloud_of(points, targets, options), options)) {
  update(targets);
  problem_->forget_buffers();  // most of these are never updated
}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const PointsView<Scalar>& points,
                                                 const PointsView<Scalar>& targets,
                                                 NeighbourList<Scalar> neighbours,
                                                 const Options& options)
    : problem_(std::make_shared<Problem>(cloud_of(points, targets, options), options)) {
  update(targets, std::move(neighbours));
  problem_->forget_buffers();  // most of these are never updated
}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const BasicSources<Scalar>& sources,
                                                 const PointsView<Scalar>& targets,
                                                 const Options& options)
    : problem_(std::make_shared<Problem>(cloud_of(sources, options), options)) {
  update(targets);
}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const BasicSources<Scalar>& sources,
                                                 const PointsView<Scalar>& targets,
                                                 NeighbourList<Scalar> neighbours,
                                                 const Options& options)
    : problem_(std::make_shared<Problem>(cloud_of(sources, options), options)) {
  update(targets, std::move(neighbours));
}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const PointsView<Scalar>& points,
                                                 const StructuredGrid<Scalar>& grid,
                                                 const Options& options)
    : BasicReconstruction(points, grid.nodes().view(), options.for_grid(grid)) {}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const BasicSources<Scalar>& sources,
                                                 const StructuredGrid<Scalar>& grid,
                                                 const Options& options)
    : BasicReconstruction(sources, grid.nodes().view(), options_of_sources(grid, options)) {}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction()
    : BasicReconstruction(PointsView<Scalar>(), PointsView<Scalar>(), Options()) {}

template <class Scalar>
template <class... Neighbours>
void BasicReconstruction<Scalar>::fit(const PointsView<Scalar>& targets,
                                      Neighbours&&... neighbours) {
  // A copy of this reconstruction keeps what it has.
  const bool alone = problem_.use_count() == 1;
  const auto problem = alone ? problem_ : problem_->another();
  problem->take(targets, std::forward<Neighbours>(neighbours)...);
  problem_ = problem;
  const auto take_values = [this] {
    values_ = CsrOperator<Scalar>(problem_->pattern(), problem_->give_up_values(), 1, fill(),
                                  problem_->options().threads);
  };
  try {
    problem_->fit(values_.give_up());
  } catch (...) {
    take_values();  // of no targets
    throw;
  }
  take_values();
}

template <class Scalar>
void BasicReconstruction<Scalar>::update(const PointsView<Scalar>& targets) {
  require(!problem_->has_own_neighbours(), "neighbours", "a list of the caller's",
          "must be given anew with an update");
  fit(targets, nullptr);
}

template <class Scalar>
void BasicReconstruction<Scalar>::update(const PointsView<Scalar>& targets,
                                         const NeighbourRule& neighbours) {
  fit(targets, &neighbours);
}

template <class Scalar>
void BasicReconstruction<Scalar>::update(const PointsView<Scalar>& targets,
                                         NeighbourList<Scalar> neighbours) {
  fit(targets, std::move(neighbours));
}

template <class Scalar>
void BasicReconstruction<Scalar>::update(const StructuredGrid<Scalar>& grid) {
  grid.validate();
  update(grid.nodes().view());
}

template <class Scalar>
Scalar BasicReconstruction<Scalar>::fill() const {
  return static_cast<Scalar>(problem_->options().fill_value);
}

template <class Scalar>
void BasicReconstruction<Scalar>::apply(const FieldView<Scalar>& field,
                                        const FieldSpan<Scalar>& out, const Apply& how) const {
  LimitCount local;
  LimitCount& count = how.count ? *how.count : local;
  count.components.assign(how.count || how.limit != Limit::none ? values_.rows() : 0, 0);
  values_.apply(field, out, how, count.components.data());
  count.total();
}

template <class Scalar>
typename BasicReconstruction<Scalar>::Matrix BasicReconstruction<Scalar>::apply(
    const FieldView<Scalar>& field, const Apply& how) const {
  Matrix out(static_cast<Eigen::Index>(values_.rows()), field.components());
  apply(field, field_of(out), how);
  return out;
}

template <class Scalar>
CsrOperator<Scalar> BasicReconstruction<Scalar>::gradient(Derivative kind) const {
  return operator_of(Functional::gradient.with(kind));
}

template <class Scalar>
CsrOperator<Scalar> BasicReconstruction<Scalar>::hessian() const {
  return operator_of(Functional::hessian);
}

template <class Scalar>
std::vector<AnyOperator<Scalar>> BasicReconstruction<Scalar>::operators(
    std::span<const AnyFunctional> functionals) const {
  std::vector<detail::ComponentFunctional> bases;
  for (const AnyFunctional& any : functionals)
    bases.push_back(
        std::visit([](const auto& functional) { return detail::base_of(functional); }, any));
  std::vector<CsrOperator<Scalar>> made = operators_of(bases);
  std::vector<AnyOperator<Scalar>> all;
  for (std::size_t i = 0; i < functionals.size(); ++i)
    std::visit(
        [&](const auto& functional) { all.emplace_back(finished(std::move(made[i]), functional)); },
        functionals[i]);
  return all;
}

template <class Scalar>
const FitReports& BasicReconstruction<Scalar>::report() const {
  problem_->pattern()->require_current();
  return problem_->reports();
}

template <class Scalar>
NeighbourList<Scalar> BasicReconstruction<Scalar>::neighbours() const {
  const SparsityPattern<Scalar>& pattern = *problem_->pattern();
  pattern.require_current();
  const NeighbourList<Scalar>& list = pattern.neighbours;
  if (pattern.target_of.empty()) return list;
  NeighbourList<Scalar> out;
  out.support_factor = list.support_factor;
  out.indices.reserve(list.indices.size());
  out.shifts.reserve(list.shifts.size());
  const detail::NumbersOf numbers(list);
  for (std::size_t t = 0; t < list.targets(); ++t)
    detail::append_row(list, pattern.row(t), numbers, out);
  return out;
}

template <class Scalar>
Scalar BasicReconstruction<Scalar>::support(std::size_t target) const {
  const SparsityPattern<Scalar>& pattern = *problem_->pattern();
  pattern.require_current();
  return pattern.neighbours.support[pattern.row(target)];
}

template <class Scalar>
int BasicReconstruction<Scalar>::dimension() const {
  return problem_->dimension();
}

RECON_FLOAT(template class BasicReconstruction<float>;)
template class BasicReconstruction<double>;

}  // namespace recon
