#include "recon/operators/reconstruct.hpp"

#include <string>
#include <vector>

#include "operators/fit_problem.hpp"
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

// The place of d2/dx_a dx_b, a <= b, in xx, xy, xz, yy, yz, zz.
int second_derivative(int a, int b, int dimension) {
  return a * dimension - a * (a - 1) / 2 + b - a;
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
  const auto problem =
      alone ? problem_ : std::make_shared<Problem>(problem_->shared_cloud(), problem_->options());
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
Scalar BasicReconstruction<Scalar>::fill() const {
  return static_cast<Scalar>(problem_->options().fill_value);
}

template <class Scalar>
std::vector<CsrOperator<Scalar>> BasicReconstruction<Scalar>::operators_of(
    std::span<const Functional> functionals) const {
  using Kind = Functional::Kind;
  const auto& pattern = problem_->pattern();
  pattern->require_current();
  const int D = dimension();
  // The axes of a partial derivative, ascending.
  const auto axes_of = [&](const Functional& f) {
    std::vector<int> axes;
    for (int d = 0; d < max_dimension; ++d)
      for (int n = 0; n < f.orders()[d]; ++n) axes.push_back(d);
    require(axes.empty() || axes.back() < D, "axis of the partial derivative",
            axes.empty() ? 0 : axes.back(), "must be an axis of the points");
    return axes;
  };
  const auto order_of = [&](const Functional& f) {
    return f.kind() == Kind::value      ? 0
           : f.kind() == Kind::gradient ? 1
           : f.kind() == Kind::partial  ? static_cast<int>(axes_of(f).size())
                                        : 2;
  };

  bool first[2] = {false, false}, second = false;
  for (const Functional& f : functionals) {
    const int order = order_of(f);
    if (order == 1) first[f.slopes() == Derivative::exact] = true;
    second = second || order == 2;
  }
  Array<Scalar> slopes[2], curvature;
  if (first[0] || first[1]) {
    const bool exact = first[1];
    problem_->derivatives(exact ? Derivative::exact : Derivative::diffuse, &slopes[exact],
                          second ? &curvature : nullptr);
    if (first[0] && first[1]) problem_->derivatives(Derivative::diffuse, &slopes[0], nullptr);
  } else if (second) {
    problem_->derivatives(Derivative::diffuse, nullptr, &curvature);
  }

  const std::size_t entries = pattern->neighbours.indices.size();
  const int seconds = D * (D + 1) / 2;
  const auto make = [&](Array<Scalar> values, int blocks) {
    return CsrOperator<Scalar>(pattern, std::move(values), blocks, fill(),
                               problem_->options().threads);
  };
  // The sum of some of the numbers of each entry.
  const auto sum_of = [&](const Array<Scalar>& from, int blocks, const std::vector<int>& places) {
    Array<Scalar> values(entries);
    for (std::size_t e = 0; e < entries; ++e) {
      values[e] = 0;
      for (const int place : places)
        values[e] += from[e * static_cast<std::size_t>(blocks) + place];
    }
    return make(std::move(values), 1);
  };
  // Moves the numbers out where no later functional needs them.
  const auto take = [&](Array<Scalar>& values, std::size_t i) {
    const Functional& f = functionals[i];
    for (const Functional& later : functionals.subspan(i + 1))
      if (order_of(later) == order_of(f) && (order_of(f) == 2 || later.slopes() == f.slopes()))
        return values;
    return std::move(values);
  };
  std::vector<CsrOperator<Scalar>> made;
  for (std::size_t i = 0; i < functionals.size(); ++i) {
    const Functional& f = functionals[i];
    Array<Scalar>& slope = slopes[f.slopes() == Derivative::exact];
    if (order_of(f) == 0) {
      made.push_back(values_);
    } else if (f.kind() == Kind::gradient) {
      made.push_back(make(take(slope, i), D));
    } else if (f.kind() == Kind::hessian) {
      made.push_back(make(take(curvature, i), seconds));
    } else if (f.kind() == Kind::laplacian) {
      std::vector<int> places;
      for (int d = 0; d < D; ++d) places.push_back(second_derivative(d, d, D));
      made.push_back(sum_of(curvature, seconds, places));
    } else if (const std::vector<int> axes = axes_of(f); axes.size() == 1) {
      made.push_back(sum_of(slope, D, {axes[0]}));
    } else {
      made.push_back(sum_of(curvature, seconds, {second_derivative(axes[0], axes[1], D)}));
    }
  }
  return made;
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
  for (std::size_t t = 0; t < list.targets(); ++t) {
    const std::size_t row = pattern.row(t);
    const std::int64_t begin = list.offsets[row], end = list.offsets[row + 1];
    out.indices.insert(out.indices.end(), list.indices.begin() + begin, list.indices.begin() + end);
    if (!list.shifts.empty())
      out.shifts.insert(out.shifts.end(), list.shifts.begin() + begin, list.shifts.begin() + end);
    out.offsets.push_back(static_cast<std::int64_t>(out.indices.size()));
    out.support.push_back(list.support[row]);
  }
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

template class BasicReconstruction<float>;
template class BasicReconstruction<double>;

}  // namespace recon
