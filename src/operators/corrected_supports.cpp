// Supports that a fit corrects: those of targets too far from all particles, too small for the
// degree, or empty.
#include <algorithm>
#include <cmath>

#include "core/instantiate.hpp"
#include "operators/far_targets.hpp"
#include "operators/fit_problem.hpp"
#include "operators/list_rows.hpp"

namespace recon::detail {
namespace {

// The rule with supports `factor` times as large, for a choice of the targets; `kept` holds what
// it refers to.
NeighbourRule enlarged(const NeighbourRule& rule, int dimension, double factor,
                       const std::vector<std::size_t>& targets, OwnSupports& kept) {
  const auto more = [factor](std::size_t k) {
    return static_cast<std::size_t>(std::ceil(static_cast<double>(k) * factor));
  };
  if (const auto* r = std::get_if<Radius>(&rule)) return Radius{r->radius * factor};
  if (const auto* r = std::get_if<Nearest>(&rule)) return Nearest{more(r->k), r->factor};
  if (const auto* r = std::get_if<NearestWithin>(&rule))
    return NearestWithin{more(r->k), r->radius * factor};
  kept.clear();
  if (const auto* ellipsoids = std::get_if<Ellipsoids>(&rule)) {
    for (const std::size_t t : targets) append_packed(ellipsoids->tensors, t, factor, kept.targets);
    return Ellipsoids{view_of_packed(kept.targets, dimension)};
  }
  if (const auto* ellipsoids = std::get_if<PairEllipsoids>(&rule)) {
    for (const std::size_t t : targets)
      if (ellipsoids->targets.size() > 0)
        append_packed(ellipsoids->targets, t, factor, kept.targets);
    for (std::size_t p = 0; p < ellipsoids->particles.size(); ++p)
      append_packed(ellipsoids->particles, p, factor, kept.particles);
    return PairEllipsoids{view_of_packed(kept.particles, dimension),
                          view_of_packed(kept.targets, dimension), ellipsoids->support};
  }
  const auto* pairs = std::get_if<PairRadii>(&rule);
  const std::span<const double> of_targets = pairs ? pairs->targets : std::get<Radii>(rule).radii;
  for (const std::size_t t : targets)
    if (!of_targets.empty()) kept.targets.push_back(of_targets[t] * factor);
  if (!pairs) return Radii{kept.targets};
  for (const double radius : pairs->particles) kept.particles.push_back(radius * factor);
  return PairRadii{kept.particles, kept.targets, pairs->support};
}

// The search among the particles that targets chosen[0], chosen[1], ... see.
NeighbourOptions search_of(const NeighbourOptions& search, const std::vector<std::size_t>& chosen) {
  NeighbourOptions some = search;
  if (search.visible)
    some.visible = [&](std::size_t t, std::size_t p) { return search.visible(chosen[t], p); };
  return some;
}

}  // namespace

template <class Scalar>
void FitProblem<Scalar>::mark_too_far(bool complete, const NeighbourOptions& search) {
  const std::vector<std::size_t> rows =
      far_targets(*cloud_, targets_, neighbours_, options_.max_distance, complete, search);
  if (rows.empty()) return;
  too_far_.assign(targets_.size(), false);
  for (const std::size_t t : rows) too_far_[t] = true;
  neighbours_ = without_neighbours(neighbours_, rows);
}

template <class Scalar>
bool FitProblem<Scalar>::grow(const NeighbourRule& rule, const NeighbourOptions& search) {
  bool changed = false;
  std::vector<std::size_t> missing;
  for (std::size_t t = 0; t < row_reports_.size(); ++t)
    if (row_reports_[t].status != FitStatus::full && !is_too_far(t)) missing.push_back(t);
  double factor = 1;
  for (int step = 0; step < options_.grow.steps && !missing.empty(); ++step) {
    factor *= options_.grow.factor;
    OwnSupports supports;
    const NeighbourOptions larger = search_of(search, missing);
    const PointCloud<Scalar> at = subset(targets_, missing);
    NeighbourList<Scalar> list;
    cloud_->find(at, enlarged(rule, dimension(), factor, missing, supports), larger,
                 {.in_order = true, .by_index = true}, list);
    Array<Scalar> values;
    Array<FitReport> grown;
    fit_list(at, list, search.progress, values, grown);
    std::vector<bool> take;
    std::vector<std::size_t> still;
    for (std::size_t i = 0; i < missing.size(); ++i) {
      take.push_back(grown[i].status == FitStatus::full);
      if (!take.back()) still.push_back(missing[i]);
    }
    if (still.size() == missing.size()) continue;
    neighbours_ = with_rows(neighbours_, missing, list, take);
    changed = true;
    missing = std::move(still);
  }
  return changed;
}

template <class Scalar>
void FitProblem<Scalar>::use_nearest(const NeighbourOptions& search) {
  std::vector<std::size_t> lost;
  for (std::size_t t = 0; t < row_reports_.size(); ++t)
    if (row_reports_[t].status == FitStatus::no_support && !is_too_far(t)) lost.push_back(t);
  if (lost.empty() || cloud_->points().size() == 0) return;
  NeighbourOptions one = search_of(search, lost);
  one.shape = SupportShape::ball;
  NeighbourList<Scalar> list;
  cloud_->find(subset(targets_, lost), Nearest{1}, one, {.in_order = true}, list);
  std::vector<bool> take;
  for (std::size_t i = 0; i < lost.size(); ++i) take.push_back(list.count(i) > 0);
  const NeighbourList<Scalar> before = std::move(neighbours_);
  neighbours_ = with_rows(before, lost, list, take);
  const Array<Scalar> fitted = std::move(values_);
  values_.assign(neighbours_.indices.size(), Scalar(0));
  std::size_t next = 0;
  for (std::size_t t = 0; t < row_reports_.size(); ++t) {
    if (next < lost.size() && lost[next] == t && take[next++]) {
      values_[neighbours_.offsets[t]] = 1;
      row_reports_[t].status = FitStatus::nearest;
      nearest_rows_.push_back(static_cast<std::uint32_t>(t));
    } else {
      std::copy(fitted.begin() + before.offsets[t], fitted.begin() + before.offsets[t + 1],
                values_.begin() + neighbours_.offsets[t]);
    }
  }
}

#define RECON_INSTANTIATE(S)                                                        \
  template void FitProblem<S>::mark_too_far(bool, const NeighbourOptions&);         \
  template bool FitProblem<S>::grow(const NeighbourRule&, const NeighbourOptions&); \
  template void FitProblem<S>::use_nearest(const NeighbourOptions&)
RECON_FLOAT(RECON_INSTANTIATE(float);)
RECON_INSTANTIATE(double);
#undef RECON_INSTANTIATE

}  // namespace recon::detail
