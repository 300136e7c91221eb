#include "operators/fit_problem.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/instantiate.hpp"
#include "operators/far_targets.hpp"
#include "operators/list_rows.hpp"
#include "operators/search_options.hpp"
#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/question_checks.hpp"

namespace recon::detail {
namespace {

constexpr std::size_t targets_per_block = 256, many_per_block = 16384;
constexpr std::size_t fewest_sorted = 512;  // below this, everything is in the cache anyway

bool refers_to_supports(const NeighbourRule& rule) {
  return std::holds_alternative<Radii>(rule) || std::holds_alternative<PairRadii>(rule) ||
         std::holds_alternative<Ellipsoids>(rule) || std::holds_alternative<PairEllipsoids>(rule);
}

void require_radial(bool pairs_have_tensors, WeightForm form) {
  require(!pairs_have_tensors || form == WeightForm::radial, "form", "tensor_product",
          "must be radial where pairs have ellipsoids of their own");
}

}  // namespace

template <class Scalar>
FitProblem<Scalar>::FitProblem(std::shared_ptr<const Cloud<Scalar>> cloud, const Options& options)
    : cloud_(std::move(cloud)),
      options_(options.for_points(dimension())),
      rule_(with_kept_supports(*options_.neighbours)) {
  options_.particle_weights = {};  // the cloud has its own
  options_.neighbours.reset();     // rule_ is what holds
  kernel_ = make_shape_kernel<Scalar>(
      dimension(), {options.degree, options.weight, *options_.form, *options_.solver,
                    options.tolerances, resolved(options.instruction_set)});
}

template <class Scalar>
std::shared_ptr<FitProblem<Scalar>> FitProblem<Scalar>::another() const {
  Options same = options_;
  same.neighbours = rule_;
  return std::make_shared<FitProblem>(cloud_, same);
}

template <class Scalar>
void FitProblem<Scalar>::require_dimension(const PointsView<Scalar>& targets) const {
  require(targets.dimension() == dimension(), "dimension of the targets", targets.dimension(),
          "must be that of the points");
}

template <class Scalar>
void FitProblem<Scalar>::take(const PointsView<Scalar>& targets, const NeighbourRule* rule) {
  const NeighbourRule asked = rule ? *rule : rule_;
  require_dimension(targets);
  require_valid_rule<Scalar>(asked, dimension(), targets.size(), cloud_->points().size());
  require_radial(std::holds_alternative<PairEllipsoids>(asked), *options_.form);
  cloud_->take_targets(targets, "targets", options_.threads, incoming_);
  rule_before_ = rule_;
  rule_ = with_kept_supports(asked);
  own_neighbours_ = false;
}

template <class Scalar>
void FitProblem<Scalar>::take(const PointsView<Scalar>& targets, NeighbourList<Scalar> neighbours) {
  require_dimension(targets);
  neighbours.validate(targets.size(), cloud_->points().size());
  const auto numbers = static_cast<std::size_t>(dimension() * (dimension() + 1) / 2);
  require(neighbours.tensor.empty() || neighbours.tensor.size() == numbers * targets.size(),
          "numbers in the tensors", neighbours.tensor.size(),
          "must be D (D + 1) / 2 times the number of targets");
  require(neighbours.pair_tensor.empty() ||
              neighbours.pair_tensor.size() == numbers * neighbours.indices.size(),
          "numbers in the tensors of pairs", neighbours.pair_tensor.size(),
          "must be D (D + 1) / 2 times the number of indices");
  require_radial(!neighbours.pair_tensor.empty(), *options_.form);
  require(!cloud_->domain().any() || neighbours.indices.empty() || !neighbours.shifts.empty(),
          "neighbours", "without shifts", "must have shifts in a periodic domain");
  for (std::size_t e = 0; e < neighbours.shifts.size(); ++e)
    for (int d = 0; d < max_dimension; ++d) {
      const int shift = neighbours.shifts[e][d];
      if (shift == 0 || cloud_->domain().periodic[d]) continue;
      throw_invalid("shift of entry " + std::to_string(e) + " along " + "xyz"[d], shift,
                    "must be 0 where the domain is not periodic");
    }
  cloud_->take_targets(targets, "targets", options_.threads, incoming_);
  given_ = std::move(neighbours);
  own_neighbours_ = true;
}

template <class Scalar>
void FitProblem<Scalar>::fit(Array<Scalar> values) {
  values_ = std::move(values);
  try {
    fit_taken();
  } catch (...) {
    abandon();
    throw;
  }
}

template <class Scalar>
void FitProblem<Scalar>::abandon() {
  if (!refers_to_supports(rule_before_)) rule_ = rule_before_;
  targets_ = PointCloud<Scalar>();
  target_of_.clear();
  neighbours_ = {};
  values_.clear();
  row_reports_.clear();
  reports_ = {};
  nearest_rows_.clear();
  too_far_.clear();
  pattern_ = std::make_shared<SparsityPattern<Scalar>>();
  make_pattern();
}

template <class Scalar>
void FitProblem<Scalar>::fit_taken() {
  if (pattern_ && pattern_.use_count() == 1) {
    neighbours_ = std::move(pattern_->neighbours);
    target_of_ = std::move(pattern_->target_of);
  } else {
    pattern_ = std::make_shared<SparsityPattern<Scalar>>();
  }
  nearest_rows_.clear();
  too_far_.clear();
  indices_are_callers_ = false;
  order_targets();
  // Of a second fit, after supports have grown, it is not known how much there will be.
  const bool may_grow = !own_neighbours_ && options_.grow.steps > 0;
  const double first_fits = may_grow ? 0.8 : 1;
  const double found = own_neighbours_ ? 0 : fits_while_finding() ? first_fits : 0.4;
  NeighbourOptions search = search_options();
  search.progress = part_of(options_.progress, 0, found);
  NeighbourRule rule;
  bool fitted = false;
  if (own_neighbours_) {
    neighbours_ = std::move(given_);
    cloud_->to_places(neighbours_.indices, neighbours_.indices.data(), options_.threads);
  } else {
    rule = ordered_rule(ordered_supports_);
    fitted = find_and_fit(rule, search, !may_grow && options_.unsupported != Unsupported::nearest);
  }

  const auto at = [&](double part) { return part_of(options_.progress, part, part); };
  if (!fitted) {
    search.progress = at(found);  // what comes now is short
    mark_too_far(!own_neighbours_ && search.shape == SupportShape::ball, search);
    fit_list(targets_, neighbours_, part_of(options_.progress, found, first_fits), values_,
             row_reports_);
  }
  search.progress = at(first_fits);
  if (may_grow && grow(rule, search))
    fit_list(targets_, neighbours_, part_of(options_.progress, first_fits, 1), values_,
             row_reports_);
  search.progress = at(1);
  if (options_.unsupported == Unsupported::nearest) use_nearest(search);
  for (std::size_t t = 0; t < too_far_.size(); ++t)
    if (too_far_[t]) row_reports_[t].status = FitStatus::too_far;
  make_pattern();
  std::vector<FitReport> reports = reports_.give_up();
  reports.resize(row_reports_.size());
  recon::parallel_blocks(reports.size(), many_per_block, options_.threads,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t t = begin; t < end; ++t)
                             reports[pattern_->target(t)] = row_reports_[t];
                         });
  reports_ = FitReports(std::move(reports), *options_.solver);
}

template <class Scalar>
bool FitProblem<Scalar>::fits_while_finding() const {
  return !own_neighbours_ && std::holds_alternative<Nearest>(rule_) && !options_.visible &&
         (options_.search == SearchMethod::automatic ||
          options_.search == SearchMethod::cell_grid) &&
         std::isinf(options_.max_distance);
}

template <class Scalar>
bool FitProblem<Scalar>::find_and_fit(const NeighbourRule& rule, const NeighbourOptions& search,
                                      bool last) {
  bool fitted = false;
  const auto start = [&] {
    fitted = true;
    indices_are_callers_ = last;
    values_.resize(neighbours_.indices.size());
    row_reports_.resize(neighbours_.targets());
  };
  const auto finished = [&](std::size_t begin, std::size_t end) {
    fit_rows(shape_problem(targets_, neighbours_), begin, end, values_, row_reports_);
    if (!last) return;
    const std::int64_t first = neighbours_.offsets[begin], behind = neighbours_.offsets[end];
    cloud_->to_callers(
        std::span(neighbours_.indices)
            .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(behind - first)),
        1);
  };
  RowsAsked rows{.in_order = true, .by_index = true};
  if (fits_while_finding()) {  // by reference, so that nothing is allocated
    rows.start = std::ref(start);
    rows.finished = std::ref(finished);
  }
  cloud_->find(targets_, rule, search, rows, neighbours_);
  return fitted;
}

template <class Scalar>
void FitProblem<Scalar>::forget_buffers() {
  cloud_->forget_buffers();
  kernel_->forget_buffers();
  incoming_ = {};
  sort_ = {};
  row_reports_ = Array<FitReport>();  // = {} would keep the memory
}

template <class Scalar>
void FitProblem<Scalar>::order_targets() {
  target_of_.clear();
  if (own_neighbours_ || incoming_.size() < fewest_sorted) return std::swap(targets_, incoming_);
  cloud_->order(incoming_, options_.threads, sort_);
  target_of_.assign(sort_.order().begin(), sort_.order().end());
  targets_.assign_permuted(incoming_, target_of_, options_.threads);
}

template <class Scalar>
void FitProblem<Scalar>::make_pattern() {
  SparsityPattern<Scalar>& made = *pattern_;
  made.start_anew();
  made.columns = cloud_->points().size();
  made.cloud = cloud_;
  made.version = cloud_->version();
  made.empty_rows.clear();
  for (std::size_t t = 0; t < row_reports_.size(); ++t)
    if (row_reports_[t].status == FitStatus::no_support ||
        row_reports_[t].status == FitStatus::too_far)
      made.empty_rows.push_back(static_cast<std::uint32_t>(t));
  if (!indices_are_callers_) cloud_->to_callers(neighbours_.indices, options_.threads);
  made.target_of = std::move(target_of_);
  made.neighbours = std::move(neighbours_);
}

template <class Scalar>
NeighbourOptions FitProblem<Scalar>::search_options() const {
  NeighbourOptions search = detail::search_options(options_, *options_.form);
  if (options_.visible)
    search.visible = [this](std::size_t t, std::size_t p) {
      return options_.visible(caller_target(t), cloud_->caller_of()[p]);
    };
  return search;
}

template <class Scalar>
NeighbourRule FitProblem<Scalar>::with_kept_supports(const NeighbourRule& rule) {
  const auto keep = [](std::span<const double> given, std::vector<double>& kept) {
    if (given.data() != kept.data()) kept.assign(given.begin(), given.end());
  };
  const auto keep_tensors = [this](const FieldView<double>& given, const char* whose,
                                   std::vector<double>& kept) {
    if (given.size() == 0 || given.first(0) != kept.data()) {
      // Packed they are symmetric, and have the right number of components.
      require_tensors<Scalar>(given, dimension(), given.size(), whose, "");
      kept.clear();
      for (std::size_t i = 0; i < given.size(); ++i) append_packed(given, i, 1, kept);
    }
    return view_of_packed(kept, dimension());
  };
  if (const auto* own = std::get_if<Radii>(&rule)) {
    keep(own->radii, supports_.targets);
    return Radii{supports_.targets};
  }
  if (const auto* pairs = std::get_if<PairRadii>(&rule)) {
    keep(pairs->targets, supports_.targets);
    keep(pairs->particles, supports_.particles);
    return PairRadii{supports_.particles, supports_.targets, pairs->support};
  }
  if (const auto* own = std::get_if<Ellipsoids>(&rule))
    return Ellipsoids{keep_tensors(own->tensors, "target ", supports_.targets)};
  if (const auto* pairs = std::get_if<PairEllipsoids>(&rule))
    return PairEllipsoids{keep_tensors(pairs->particles, "particle ", supports_.particles),
                          keep_tensors(pairs->targets, "target ", supports_.targets),
                          pairs->support};
  return rule;
}

template <class Scalar>
NeighbourRule FitProblem<Scalar>::ordered_rule(std::vector<double>& supports) const {
  if (!refers_to_supports(rule_)) return rule_;
  supports.clear();
  const std::size_t count = supports_.targets.empty() ? 0 : targets_.size();
  const std::size_t each = count > 0 ? supports_.targets.size() / count : 0;
  for (std::size_t t = 0; t < count; ++t) {
    const auto first =
        supports_.targets.begin() + static_cast<std::ptrdiff_t>(caller_target(t) * each);
    supports.insert(supports.end(), first, first + static_cast<std::ptrdiff_t>(each));
  }
  if (const auto* pairs = std::get_if<PairRadii>(&rule_))
    return PairRadii{supports_.particles, supports, pairs->support};
  if (std::holds_alternative<Ellipsoids>(rule_))
    return Ellipsoids{view_of_packed(supports, dimension())};
  if (const auto* pairs = std::get_if<PairEllipsoids>(&rule_))
    return PairEllipsoids{pairs->particles, view_of_packed(supports, dimension()), pairs->support};
  return Radii{supports};
}

template <class Scalar>
ShapeProblem<Scalar> FitProblem<Scalar>::shape_problem(
    const PointCloud<Scalar>& at, const NeighbourListView<Scalar>& list) const {
  ShapeProblem<Scalar> problem{cloud_->points(), at, list, cloud_->domain()};
  for (int d = 0; d < max_dimension; ++d)
    problem.axis_scale[d] = static_cast<Scalar>(1 / cloud_->stretch()[d]);
  problem.particle_weights = cloud_->weights();
  return problem;
}

template <class Scalar>
void FitProblem<Scalar>::fit_rows(const ShapeProblem<Scalar>& problem, std::size_t begin,
                                  std::size_t end, Array<Scalar>& values,
                                  Array<FitReport>& reports) const {
  ShapeRows<Scalar> rows;
  rows.value = values.data();
  rows.report = reports.data();
  kernel_->evaluate(problem, begin, end, rows);
}

template <class Scalar>
void FitProblem<Scalar>::fit_list(const PointCloud<Scalar>& at, const NeighbourList<Scalar>& list,
                                  const Progress& progress, Array<Scalar>& values,
                                  Array<FitReport>& reports) const {
  values.resize(list.indices.size());
  reports.resize(list.targets());
  const ShapeProblem<Scalar> problem = shape_problem(at, list);
  recon::parallel_blocks(
      list.targets(), targets_per_block, options_.threads, progress,
      [&](std::size_t begin, std::size_t end) { fit_rows(problem, begin, end, values, reports); });
}

template <class Scalar>
template <class Rows>
void FitProblem<Scalar>::evaluate(const Rows& rows) const {
  const NeighbourList<Scalar>& list = pattern_->neighbours;
  Array<ParticleIndex> places(list.indices.size());
  cloud_->to_places(list.indices, places.data(), options_.threads);
  NeighbourListView<Scalar> in_places = list;
  in_places.indices = places.data();
  const ShapeProblem<Scalar> problem = shape_problem(targets_, in_places);
  recon::parallel_blocks(
      targets_.size(), targets_per_block, options_.threads,
      [&](std::size_t begin, std::size_t end) { kernel_->evaluate(problem, begin, end, rows); });
}

template <class Scalar>
void FitProblem<Scalar>::derivatives(Derivative kind, Array<Scalar>* first,
                                     Array<Scalar>* second) const {
  const NeighbourList<Scalar>& list = pattern_->neighbours;
  const int firsts = dimension(), seconds = dimension() * (dimension() + 1) / 2;
  ShapeRows<Scalar> rows;
  rows.kind = kind;
  if (first) {
    first->resize(list.indices.size() * static_cast<std::size_t>(firsts));
    rows.gradient = first->data();
  }
  if (second) {
    second->resize(list.indices.size() * static_cast<std::size_t>(seconds));
    rows.hessian = second->data();
  }
  evaluate(rows);
  // The value of the nearest particle is constant about the target.
  const auto flatten = [&](Array<Scalar>* values, int blocks) {
    for (const std::uint32_t t : nearest_rows_)
      if (values)
        std::fill(values->begin() + list.offsets[t] * blocks,
                  values->begin() + list.offsets[t + 1] * blocks, Scalar(0));
  };
  flatten(first, firsts);
  flatten(second, seconds);
}

template <class Scalar>
Array<Scalar> FitProblem<Scalar>::functionals(std::span<const OwnFunctional::Action> asked) const {
  using Powers = OwnFunctional::Powers;
  const NeighbourList<Scalar>& list = pattern_->neighbours;
  const auto act = [&](std::size_t row, const Powers& powers, std::span<double> out) {
    const std::size_t target = pattern_->target(row);
    std::fill(out.begin(), out.end(), std::numeric_limits<double>::quiet_NaN());
    auto rest = out;
    for (const OwnFunctional::Action& functional : asked) {
      const auto numbers = static_cast<std::size_t>(functional.numbers);
      functional.act(target, powers, rest.first(numbers));
      rest = rest.subspan(numbers);
    }
    for (const double number : out)
      if (!std::isfinite(number))
        throw_invalid("functional of the monomial with powers (" + std::to_string(powers[0]) +
                          ", " + std::to_string(powers[1]) + ", " + std::to_string(powers[2]) +
                          ") at target " + std::to_string(target),
                      number, "must be finite");
  };
  FunctionalRows<Scalar> rows;
  for (const OwnFunctional::Action& functional : asked) rows.numbers += functional.numbers;
  Array<Scalar> values(list.indices.size() * static_cast<std::size_t>(rows.numbers));
  rows.value = values.data();
  rows.action = act;
  evaluate(rows);
  // The value of the nearest particle is constant about the target.
  std::vector<double> on_constant(rows.numbers);
  for (const std::uint32_t t : nearest_rows_) {
    act(t, Powers{}, on_constant);
    auto to = values.begin() + list.offsets[t] * rows.numbers;
    std::fill(to, values.begin() + list.offsets[t + 1] * rows.numbers, Scalar(0));
    for (const double number : on_constant) *to++ = static_cast<Scalar>(number);
  }
  return values;
}

RECON_FLOAT(template class FitProblem<float>;)
template class FitProblem<double>;

}  // namespace recon::detail
