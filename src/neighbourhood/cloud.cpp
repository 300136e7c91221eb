#include "neighbourhood/cloud.hpp"

#include <algorithm>
#include <string>

#include "core/instantiate.hpp"
#include "neighbourhood/all_targets.hpp"
#include "neighbourhood/find_with_index.hpp"
#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/question_checks.hpp"

namespace recon {

using detail::require;

void SourcesOptions::validate() const {
  for (int d = 0; d < max_dimension; ++d)
    if (!(std::isfinite(stretch[d]) && stretch[d] > 0))
      detail::throw_invalid(std::string("stretch along ") + "xyz"[d], stretch[d],
                            "must be positive and finite");
  require(threads >= 0, "threads", threads, "must not be negative (0: all there are)");

  // Within this range floats hold every ratio.
  constexpr double least_ratio = 1e-30;
  double largest = 0;
  for (std::size_t p = 0; p < particle_weights.size(); ++p) {
    const double value = particle_weights[p];
    if (!(std::isfinite(value) && value > 0)) [[unlikely]]
      detail::throw_invalid("particle_weights of particle " + std::to_string(p), value,
                            "must be positive and finite");
    largest = std::max(largest, value);
  }
  for (std::size_t p = 0; p < particle_weights.size(); ++p)
    if (!(particle_weights[p] >= least_ratio * largest)) [[unlikely]]
      detail::throw_invalid(
          "particle_weights of particle " + std::to_string(p), particle_weights[p],
          "must not be smaller than 1e-30 times the largest, " + detail::to_text(largest));
}

namespace detail {
namespace {

constexpr std::size_t indices_per_block = 16384;

template <class Scalar>
PeriodicDomain<Scalar> stretched(const PeriodicDomain<double>& domain,
                                 const std::array<double, max_dimension>& stretch) {
  PeriodicDomain<Scalar> out;
  out.periodic = domain.periodic;
  for (int d = 0; d < max_dimension; ++d) {
    out.lower[d] = static_cast<Scalar>(domain.lower[d] / stretch[d]);
    out.upper[d] = static_cast<Scalar>(domain.upper[d] / stretch[d]);
  }
  return out;
}

}  // namespace

template <class Scalar>
Cloud<Scalar>::Cloud(const PointsView<Scalar>& points, const SourcesOptions& options)
    : options_(options) {
  options.validate();
  options_.domain.validate(points.dimension());
  domain_ = stretched<Scalar>(options.domain, options.stretch);
  update(points, &options.particle_weights);
  incoming_ = {};
  with_kept([](auto& kept) { kept.ordered->sorted_cells().forget_scratch(); });
}

template <class Scalar>
void Cloud<Scalar>::update(const PointsView<Scalar>& points,
                           const std::span<const double>* weights) {
  if (version_ > 0) {
    require(points.dimension() == points_->dimension(), "dimension of the points",
            points.dimension(), "must be what it was");
    if (weights != nullptr) {
      SourcesOptions check;
      check.particle_weights = *weights;
      check.validate();
    }
  }
  const std::size_t given = weights != nullptr ? weights->size() : callers_weights_.size();
  require(given == 0 || given == points.size(), "number of particle_weights", given,
          "must be the number of particles, or 0");
  take_targets(points, "points", options_.threads, incoming_);
  // From here on nothing is refused.
  if (weights != nullptr) callers_weights_.assign(weights->begin(), weights->end());
  options_.particle_weights = callers_weights_;
  ++version_;
  switch (points.dimension()) {
    case 1:
      build<1>(options_.threads);
      break;
    case 2:
      build<2>(options_.threads);
      break;
    default:
      build<3>(options_.threads);
      break;
  }
  weights_.resize(callers_weights_.size());
  const double largest = callers_weights_.empty()
                             ? 1
                             : *std::max_element(callers_weights_.begin(), callers_weights_.end());
  for (std::size_t i = 0; i < weights_.size(); ++i)
    weights_[i] = static_cast<Scalar>(callers_weights_[caller_of_[i]] / largest);
}

template <class Scalar>
template <int D>
void Cloud<Scalar>::build(int threads) {
  using Pointer = std::unique_ptr<Kept<D>>;
  const double size = density_cell_size(incoming_, SearchIndex<Scalar, D>::particles_per_cell);
  if (std::holds_alternative<Pointer>(kept_)) {
    Kept<D>& kept = *std::get<Pointer>(kept_);
    kept.index.start_anew(nullptr);
    kept.ordered->sorted_cells().build(incoming_, size, threads);
  } else {
    kept_ = Pointer(new Kept<D>{std::make_shared<CellGrid<Scalar, D>>(incoming_, size, threads)});
  }
  Kept<D>& kept = *std::get<Pointer>(kept_);
  Cells<Scalar, D>& cells = kept.ordered->sorted_cells();
  cells.number_by_place();
  caller_of_ = cells.order();
  points_ = &cells.points();
  kept.index.start_anew(kept.ordered);
}

template <class Scalar>
std::span<const std::uint32_t> Cloud<Scalar>::place_of() const {
  const std::lock_guard lock(mutex_);
  if (placed_version_ != version_) {
    place_of_.resize(caller_of_.size());
    for (std::size_t i = 0; i < caller_of_.size(); ++i)
      place_of_[caller_of_[i]] = static_cast<std::uint32_t>(i);
    placed_version_ = version_;
  }
  return place_of_;
}

template <class Scalar>
void Cloud<Scalar>::to_callers(std::span<ParticleIndex> indices, int threads) const {
  recon::parallel_blocks(indices.size(), indices_per_block, threads,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t e = begin; e < end; ++e)
                             indices[e] = caller_of_[indices[e]];
                         });
}

template <class Scalar>
void Cloud<Scalar>::to_places(std::span<const ParticleIndex> indices, ParticleIndex* places,
                              int threads) const {
  const std::span<const std::uint32_t> place = place_of();
  recon::parallel_blocks(indices.size(), indices_per_block, threads,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t e = begin; e < end; ++e) places[e] = place[indices[e]];
                         });
}

template <class Scalar>
void Cloud<Scalar>::take_targets(const PointsView<Scalar>& targets, const char* name, int threads,
                                 PointCloud<Scalar>& into) const {
  const auto& stretch = options_.stretch;
  if (std::all_of(stretch.begin(), stretch.end(), [](double s) { return s == 1; }))
    return into.assign(targets, name, domain_, threads);
  bounding_box(targets, name);  // messages about bad coordinates speak of the caller's numbers
  std::array<std::vector<Scalar>, max_dimension> axes;
  for (int d = 0; d < targets.dimension(); ++d) {
    axes[d].resize(targets.size());
    for (std::size_t i = 0; i < targets.size(); ++i)
      axes[d][i] = static_cast<Scalar>(static_cast<double>(targets(i, d)) / stretch[d]);
  }
  into.assign(points_of_axes(axes, targets.dimension()), name, domain_, threads);
}

template <class Scalar>
template <class Use>
void Cloud<Scalar>::with_kept(const Use& use) const {
  std::visit(
      [&](const auto& kept) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(kept)>, std::monostate>) use(*kept);
      },
      kept_);
}

template <class Scalar>
void Cloud<Scalar>::order(const PointCloud<Scalar>& targets, int threads,
                          CountingSort& sort) const {
  with_kept([&](const auto& kept) {
    sort_by_bricks(kept.ordered->sorted_cells(), targets, threads, sort);
  });
}

template <class Scalar>
void Cloud<Scalar>::find(const PointCloud<Scalar>& targets, const NeighbourRule& rule,
                         const NeighbourOptions& options, const RowsAsked& rows,
                         NeighbourList<Scalar>& list) const {
  NeighbourRule of_places = rule;
  std::vector<double> radii;
  if (auto* pairs = std::get_if<PairRadii>(&of_places)) {
    require_valid_rule<Scalar>(rule, points().dimension(), targets.size(), points().size());
    for (const std::uint32_t p : caller_of_) radii.push_back(pairs->particles[p]);
    pairs->particles = radii;
  } else if (auto* ellipsoids = std::get_if<PairEllipsoids>(&of_places)) {
    require_valid_rule<Scalar>(rule, points().dimension(), targets.size(), points().size());
    for (const std::uint32_t p : caller_of_) append_packed(ellipsoids->particles, p, 1, radii);
    ellipsoids->particles = view_of_packed(radii, points().dimension());
  }
  with_kept([&](auto& kept) {
    find_with_index(kept.index, targets, of_places, domain_, options, rows, list);
  });
}

template <class Scalar>
void Cloud<Scalar>::forget_buffers() const {
  with_kept([](auto& kept) {
    kept.index.forget_buffers();
    kept.ordered->sorted_cells().forget_coarse();
  });
}

RECON_FLOAT(template class Cloud<float>;)
template class Cloud<double>;

}  // namespace detail

template <class Scalar>
BasicSources<Scalar>::BasicSources(const PointsView<Scalar>& points, const SourcesOptions& options)
    : cloud_(std::make_shared<detail::Cloud<Scalar>>(points, options)) {}

template <class Scalar>
void BasicSources<Scalar>::update(const PointsView<Scalar>& points) {
  cloud_->update(points, nullptr);
}
template <class Scalar>
void BasicSources<Scalar>::update(const PointsView<Scalar>& points,
                                  std::span<const double> particle_weights) {
  cloud_->update(points, &particle_weights);
}
template <class Scalar>
std::size_t BasicSources<Scalar>::size() const {
  return cloud_->points().size();
}
template <class Scalar>
int BasicSources<Scalar>::dimension() const {
  return cloud_->points().dimension();
}
template <class Scalar>
const PeriodicDomain<double>& BasicSources<Scalar>::domain() const {
  return cloud_->callers_domain();
}
template <class Scalar>
std::span<const std::uint32_t> BasicSources<Scalar>::order() const {
  return cloud_->caller_of();
}

RECON_FLOAT(template class BasicSources<float>;)
template class BasicSources<double>;

namespace {

template <class Scalar>
NeighbourList<Scalar> neighbours_of(const BasicSources<Scalar>& sources,
                                    const PointsView<Scalar>& at, const NeighbourRule& rule,
                                    NeighbourOptions options) {
  const detail::Cloud<Scalar>& cloud = *sources.cloud();
  const std::span<const std::uint32_t> caller_of = cloud.caller_of();
  PointCloud<Scalar> targets;
  cloud.take_targets(at, "targets", options.threads, targets);
  if (options.visible)
    options.visible = [visible = options.visible, caller_of](std::size_t t, std::size_t p) {
      return visible(t, caller_of[p]);
    };
  NeighbourList<Scalar> list;
  cloud.find(targets, rule, options, {}, list);
  cloud.to_callers(list.indices, options.threads);
  return list;
}

}  // namespace

NeighbourList<double> find_neighbours(const Sources& sources, const PointsView<double>& targets,
                                      const NeighbourRule& rule, const NeighbourOptions& options) {
  return neighbours_of(sources, targets, rule, options);
}
#ifndef RECON_DOUBLE_ONLY
NeighbourList<float> find_neighbours(const SourcesF& sources, const PointsView<float>& targets,
                                     const NeighbourRule& rule, const NeighbourOptions& options) {
  return neighbours_of(sources, targets, rule, options);
}
#endif

}  // namespace recon
