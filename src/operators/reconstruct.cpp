#include "recon/operators/reconstruct.hpp"

#include <algorithm>
#include <cmath>

#include "operators/far_targets.hpp"
#include "operators/list_rows.hpp"
#include "recon/basis/monomials.hpp"
#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"
#include "recon/points/spatial_order.hpp"

namespace recon {
namespace {

using detail::require;

constexpr std::size_t targets_per_block = 256;
constexpr std::size_t fewest_sorted = 512;  // below this, everything is in the cache anyway

template <class Scalar>
PeriodicDomain<Scalar> scaled(const PeriodicDomain<double>& domain,
                              const std::array<double, max_dimension>& stretch, int dimension) {
  domain.validate(dimension);
  PeriodicDomain<Scalar> out;
  out.periodic = domain.periodic;
  for (int d = 0; d < max_dimension; ++d) {
    out.lower[d] = static_cast<Scalar>(domain.lower[d] / stretch[d]);
    out.upper[d] = static_cast<Scalar>(domain.upper[d] / stretch[d]);
  }
  return out;
}

// The points in coordinates divided by `stretch`, in which an anisotropic support is a ball or a
// cube.
template <class Scalar>
PointCloud<Scalar> gather(const PointsView<Scalar>& points, const char* name,
                          const PeriodicDomain<Scalar>& domain,
                          const std::array<double, max_dimension>& stretch, int threads) {
  const auto isotropic =
      std::all_of(stretch.begin(), stretch.end(), [](double s) { return s == 1; });
  if (isotropic) return PointCloud<Scalar>(points, name, domain, threads);
  bounding_box(points, name);  // messages about bad coordinates speak of the caller's numbers
  std::array<std::vector<Scalar>, max_dimension> axes;
  for (int d = 0; d < points.dimension(); ++d) {
    axes[d].resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      axes[d][i] = static_cast<Scalar>(static_cast<double>(points(i, d)) / stretch[d]);
  }
  return PointCloud<Scalar>(points_of_axes(axes, points.dimension()), name, domain, threads);
}

// The default rule: twice as many neighbours as terms, plus one.
NeighbourRule resolved(const NeighbourRule& rule, int dimension, int degree) {
  const Nearest* nearest = std::get_if<Nearest>(&rule);
  if (!nearest || nearest->k != 0) return rule;
  return Nearest{static_cast<std::size_t>(2 * monomial_count(dimension, degree) + 1),
                 nearest->factor};
}

// The rule with supports `factor` times as large, for a choice of the targets; `radii` keeps what
// it refers to.
NeighbourRule enlarged(const NeighbourRule& rule, double factor,
                       const std::vector<std::size_t>& targets, std::vector<double>& radii) {
  const auto more = [factor](std::size_t k) {
    return static_cast<std::size_t>(std::ceil(static_cast<double>(k) * factor));
  };
  if (const auto* r = std::get_if<Radius>(&rule)) return Radius{r->radius * factor};
  if (const auto* r = std::get_if<Nearest>(&rule)) return Nearest{more(r->k), r->factor};
  if (const auto* r = std::get_if<NearestWithin>(&rule))
    return NearestWithin{more(r->k), r->radius * factor};
  radii.clear();
  for (const std::size_t t : targets) radii.push_back(std::get<Radii>(rule).radii[t] * factor);
  return Radii{radii};
}

}  // namespace

// What derivatives need later: the coordinates (divided by stretch, wrapped), the neighbours, the
// choice.
//
// Unless the neighbours are given, particles and targets are sorted in space first: all work then
// finds what it needs in the cache. From here to the operator, which puts fields in and results out
// of that order, "target" and "particle" mean numbers in it.
template <class Scalar>
struct BasicReconstruction<Scalar>::Problem {
  PeriodicDomain<Scalar> domain;
  PointCloud<Scalar> particles, targets;
  std::vector<std::uint32_t> target_of, particle_of;  // as in SparsityPattern
  NeighbourList<Scalar> neighbours;                   // until make_pattern() takes them
  std::shared_ptr<const ShapeKernel<Scalar>> kernel;
  Scalar fill = 0;
  std::array<Scalar, max_dimension> axis_scale{1, 1, 1};
  std::vector<Scalar> particle_weights;  // divided by the largest; empty: all ones
  Solver solver = Solver::gram_schmidt;
  int threads = 0;
  std::vector<std::uint32_t> nearest_rows;  // targets that have the value of the nearest particle
  std::vector<bool> too_far;                // per target, where there is a largest distance
  std::shared_ptr<const SparsityPattern<Scalar>> pattern;

  Problem(const PointsView<Scalar>& points, const PointsView<Scalar>& at, const Options& options,
          bool sorted)
      : threads(options.threads) {
    options.validate();
    require(points.dimension() == at.dimension(), "dimension of the targets", at.dimension(),
            "must be that of the points");
    domain = scaled<Scalar>(options.domain, options.stretch, points.dimension());
    particles = gather(points, "points", domain, options.stretch, threads);
    targets = gather(at, "targets", domain, options.stretch, threads);
    if (sorted) {
      sort(particles, particle_of);
      sort(targets, target_of);
    }
    take_weights(options.particle_weights);
    kernel = make_shape_kernel<Scalar>(
        points.dimension(), {options.degree, options.weight, options.form, options.solver,
                             options.tolerances, resolved(options.instruction_set)});
    for (int d = 0; d < max_dimension; ++d)
      axis_scale[d] = static_cast<Scalar>(1 / options.stretch[d]);
    fill = static_cast<Scalar>(options.fill_value);
    solver = options.solver;
  }

  void sort(PointCloud<Scalar>& cloud, std::vector<std::uint32_t>& order) {
    if (cloud.size() < fewest_sorted || is_spatially_ordered(cloud)) return;
    order = spatial_order(cloud, threads);
    cloud = cloud.permuted(order, threads);
  }

  void take_weights(std::span<const double> weights) {
    require(weights.empty() || weights.size() == particles.size(), "number of particle_weights",
            weights.size(), "must be the number of particles, or 0");
    if (weights.empty()) return;
    const double largest = *std::max_element(weights.begin(), weights.end());
    for (std::size_t i = 0; i < weights.size(); ++i)
      particle_weights.push_back(
          static_cast<Scalar>(weights[particle_of.empty() ? i : particle_of[i]] / largest));
  }

  // What the kernel reads to fit the targets `at` from the neighbours in `list`.
  ShapeProblem<Scalar> shape_problem(const PointCloud<Scalar>& at,
                                     const NeighbourList<Scalar>& list) const {
    return {particles, at,         list,
            domain,    axis_scale, particle_weights.empty() ? nullptr : particle_weights.data()};
  }

  std::size_t caller_target(std::size_t t) const { return target_of.empty() ? t : target_of[t]; }

  NeighbourOptions search_options(const Options& options) const {
    NeighbourOptions search;
    search.shape = options.form == WeightForm::radial ? SupportShape::ball : SupportShape::cube;
    search.search = options.search;
    search.threads = threads;
    search.instruction_set = options.instruction_set;
    if (options.visible)
      search.visible = [this, &visible = options.visible](std::size_t t, std::size_t p) {
        return visible(caller_target(t), particle_of.empty() ? p : particle_of[p]);
      };
    return search;
  }

  // The rule for the targets in this order; `radii` keeps what it refers to.
  NeighbourRule ordered(const NeighbourRule& rule, std::vector<double>& radii) const {
    const Radii* given = std::get_if<Radii>(&rule);
    if (!given || target_of.empty()) return rule;
    radii.clear();
    for (const std::uint32_t t : target_of) radii.push_back(given->radii[t]);
    return Radii{radii};
  }

  // Fits the targets of a list; `values` per entry and `reports` per target.
  void fit(const PointCloud<Scalar>& at, const NeighbourList<Scalar>& list, Array<Scalar>& values,
           std::vector<FitReport>& reports) const {
    values.resize(list.indices.size());
    reports.resize(list.targets());
    const ShapeProblem<Scalar> problem = shape_problem(at, list);
    parallel_blocks(list.targets(), targets_per_block, threads,
                    [&](std::size_t begin, std::size_t end) {
                      ShapeRows<Scalar> rows;
                      rows.value = values.data();
                      rows.report = reports.data();
                      kernel->evaluate(problem, begin, end, rows);
                    });
  }

  bool is_too_far(std::size_t t) const { return !too_far.empty() && too_far[t]; }

  // Targets farther from every particle than `multiple` local spacings lose their neighbours.
  void mark_too_far(double multiple, bool complete, const NeighbourOptions& search) {
    const std::vector<std::size_t> rows =
        detail::far_targets(particles, targets, domain, neighbours, multiple, complete, search);
    if (rows.empty()) return;
    too_far.assign(targets.size(), false);
    for (const std::size_t t : rows) too_far[t] = true;
    neighbours = detail::without_neighbours(neighbours, rows);
  }

  // Enlarges the supports of targets that miss the asked degree. True where any has been replaced.
  bool grow(const Options& options, const NeighbourRule& rule, const NeighbourOptions& search,
            const std::vector<FitReport>& reports) {
    bool changed = false;
    std::vector<std::size_t> missing;
    for (std::size_t t = 0; t < reports.size(); ++t)
      if (reports[t].status != FitStatus::full && !is_too_far(t)) missing.push_back(t);
    double factor = 1;
    for (int step = 0; step < options.grow.steps && !missing.empty(); ++step) {
      factor *= options.grow.factor;
      std::vector<double> radii;
      NeighbourOptions larger = search;
      if (search.visible)
        larger.visible = [&](std::size_t t, std::size_t p) {
          return search.visible(missing[t], p);
        };
      const PointCloud<Scalar> at = detail::subset(targets, missing);
      const auto list =
          find_neighbours(particles, at, enlarged(rule, factor, missing, radii), domain, larger);
      Array<Scalar> values;
      std::vector<FitReport> grown;
      fit(at, list, values, grown);
      std::vector<bool> take;
      std::vector<std::size_t> still;
      for (std::size_t i = 0; i < missing.size(); ++i) {
        take.push_back(grown[i].status == FitStatus::full);
        if (!take.back()) still.push_back(missing[i]);
      }
      if (still.size() == missing.size()) continue;
      neighbours = detail::with_rows(neighbours, missing, list, take);
      changed = true;
      missing = std::move(still);
    }
    return changed;
  }

  // Gives targets without support the nearest visible particle, with weight one.
  void use_nearest(const NeighbourOptions& search, Array<Scalar>& values,
                   std::vector<FitReport>& reports) {
    std::vector<std::size_t> lost;
    for (std::size_t t = 0; t < reports.size(); ++t)
      if (reports[t].status == FitStatus::no_support && !is_too_far(t)) lost.push_back(t);
    if (lost.empty() || particles.size() == 0) return;
    NeighbourOptions one = search;
    one.shape = SupportShape::ball;
    if (search.visible)
      one.visible = [&](std::size_t t, std::size_t p) { return search.visible(lost[t], p); };
    const auto list =
        find_neighbours(particles, detail::subset(targets, lost), Nearest{1}, domain, one);
    std::vector<bool> take;
    for (std::size_t i = 0; i < lost.size(); ++i) take.push_back(list.count(i) > 0);
    const NeighbourList<Scalar> before = std::move(neighbours);
    neighbours = detail::with_rows(before, lost, list, take);
    const Array<Scalar> fitted = std::move(values);
    values.assign(neighbours.indices.size(), Scalar(0));
    std::size_t next = 0;
    for (std::size_t t = 0; t < reports.size(); ++t) {
      if (next < lost.size() && lost[next] == t && take[next++]) {
        values[neighbours.offsets[t]] = 1;
        reports[t].status = FitStatus::nearest;
        nearest_rows.push_back(static_cast<std::uint32_t>(t));
      } else {
        std::copy(fitted.begin() + before.offsets[t], fitted.begin() + before.offsets[t + 1],
                  values.begin() + neighbours.offsets[t]);
      }
    }
  }

  void make_pattern(const std::vector<FitReport>& reports) {
    auto made = std::make_shared<SparsityPattern<Scalar>>();
    made->columns = particles.size();
    made->target_of = std::move(target_of);
    made->particle_of = std::move(particle_of);
    made->neighbours = std::move(neighbours);
    for (std::size_t t = 0; t < reports.size(); ++t)
      if (reports[t].status == FitStatus::no_support || reports[t].status == FitStatus::too_far)
        made->empty_rows.push_back(static_cast<std::uint32_t>(t));
    pattern = std::move(made);
  }
};

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const PointsView<Scalar>& points,
                                                 const PointsView<Scalar>& at,
                                                 const Options& options) {
  const NeighbourRule asked = resolved(options.neighbours, points.dimension(), options.degree);
  detail::require_valid_rule<Scalar>(asked, at.size());
  auto problem = std::make_shared<Problem>(points, at, options, true);
  std::vector<double> radii;
  const NeighbourRule rule = problem->ordered(asked, radii);
  problem->neighbours = find_neighbours(problem->particles, problem->targets, rule, problem->domain,
                                        problem->search_options(options));
  fit(std::move(problem), options, &rule);
}

template <class Scalar>
BasicReconstruction<Scalar>::BasicReconstruction(const PointsView<Scalar>& points,
                                                 const PointsView<Scalar>& at,
                                                 NeighbourList<Scalar> neighbours,
                                                 const Options& options) {
  auto problem = std::make_shared<Problem>(points, at, options, false);
  neighbours.validate(at.size(), points.size());
  require(!problem->domain.any() || neighbours.indices.empty() || !neighbours.shifts.empty(),
          "neighbours", "without shifts", "must have shifts in a periodic domain");
  problem->neighbours = std::move(neighbours);
  fit(std::move(problem), options, nullptr);
}

template <class Scalar>
void BasicReconstruction<Scalar>::fit(std::shared_ptr<Problem> problem, const Options& options,
                                      const NeighbourRule* rule) {
  Array<Scalar> values;
  std::vector<FitReport> reports;
  const NeighbourOptions search = problem->search_options(options);
  problem->mark_too_far(options.max_distance, rule && search.shape == SupportShape::ball, search);
  problem->fit(problem->targets, problem->neighbours, values, reports);
  if (rule && options.grow.steps > 0 && problem->grow(options, *rule, search, reports))
    problem->fit(problem->targets, problem->neighbours, values, reports);
  if (options.unsupported == Unsupported::nearest) problem->use_nearest(search, values, reports);
  for (std::size_t t = 0; t < reports.size(); ++t)
    if (problem->is_too_far(t)) reports[t].status = FitStatus::too_far;
  problem->make_pattern(reports);
  const auto& target_of = problem->pattern->target_of;
  if (!target_of.empty()) {
    std::vector<FitReport> of_targets(reports.size());
    parallel_blocks(reports.size(), 16 * targets_per_block, options.threads,
                    [&](std::size_t begin, std::size_t end) {
                      for (std::size_t i = begin; i < end; ++i)
                        of_targets[target_of[i]] = reports[i];
                    });
    reports = std::move(of_targets);
  }
  reports_ = FitReports(std::move(reports), options.solver);
  values_ =
      CsrOperator<Scalar>(problem->pattern, std::move(values), 1, problem->fill, options.threads);
  problem_ = std::move(problem);
}

template <class Scalar>
CsrOperator<Scalar> BasicReconstruction<Scalar>::derivative(bool second, Derivative kind) const {
  const Problem& p = *problem_;
  const int blocks = second ? dimension() * (dimension() + 1) / 2 : dimension();
  Array<Scalar> values(p.pattern->neighbours.indices.size() * static_cast<std::size_t>(blocks));
  const ShapeProblem<Scalar> problem = p.shape_problem(p.targets, p.pattern->neighbours);
  parallel_blocks(p.targets.size(), targets_per_block, p.threads,
                  [&](std::size_t begin, std::size_t end) {
                    ShapeRows<Scalar> rows;
                    (second ? rows.hessian : rows.gradient) = values.data();
                    rows.kind = kind;
                    p.kernel->evaluate(problem, begin, end, rows);
                  });
  // The value of the nearest particle is constant about the target.
  for (const std::uint32_t t : p.nearest_rows)
    std::fill(values.begin() + p.pattern->neighbours.offsets[t] * blocks,
              values.begin() + p.pattern->neighbours.offsets[t + 1] * blocks, Scalar(0));
  return CsrOperator<Scalar>(p.pattern, std::move(values), blocks, p.fill, p.threads);
}

template <class Scalar>
void BasicReconstruction<Scalar>::apply(const FieldView<Scalar>& field,
                                        const FieldSpan<Scalar>& out, const Apply& how) const {
  LimitCount local;
  LimitCount& count = how.count ? *how.count : local;
  count.components.assign(how.count || how.limit != Limit::none ? values_.rows() : 0, 0);
  values_.apply(field, out, how.limit, count.components.data());
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
  return derivative(false, kind);
}

template <class Scalar>
CsrOperator<Scalar> BasicReconstruction<Scalar>::hessian() const {
  return derivative(true, Derivative::diffuse);
}

template <class Scalar>
NeighbourList<Scalar> BasicReconstruction<Scalar>::neighbours() const {
  const SparsityPattern<Scalar>& pattern = *problem_->pattern;
  const NeighbourList<Scalar>& list = pattern.neighbours;
  if (pattern.target_of.empty() && pattern.particle_of.empty()) return list;
  NeighbourList<Scalar> out;
  out.support_factor = list.support_factor;
  out.indices.reserve(list.indices.size());
  out.shifts.reserve(list.shifts.size());
  for (std::size_t t = 0; t < list.targets(); ++t) {
    const std::size_t row = pattern.row(t);
    for (std::int64_t e = list.offsets[row]; e < list.offsets[row + 1]; ++e) {
      out.indices.push_back(pattern.particle(list.indices[e]));
      if (!list.shifts.empty()) out.shifts.push_back(list.shifts[e]);
    }
    out.offsets.push_back(static_cast<std::int64_t>(out.indices.size()));
    out.support.push_back(list.support[row]);
  }
  return out;
}

template <class Scalar>
Scalar BasicReconstruction<Scalar>::support(std::size_t target) const {
  return problem_->pattern->neighbours.support[problem_->pattern->row(target)];
}

template <class Scalar>
int BasicReconstruction<Scalar>::dimension() const {
  return problem_->particles.dimension();
}

template class BasicReconstruction<float>;
template class BasicReconstruction<double>;

}  // namespace recon
