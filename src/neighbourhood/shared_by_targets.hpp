// What all targets of a batch search by cells share: the question, the sorted particles, the
// kernels, and what is known beforehand about the distance of the k-th neighbour.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "neighbourhood/search_index.hpp"
#include "recon/neighbourhood/mean_spacing.hpp"

namespace recon::detail {

// A rule in the form that the search works with.
template <class S>
struct Question {
  bool nearest = false;
  std::size_t k = 0;
  double factor = 0;              // of Nearest; 0 for NearestWithin
  S radius = 0;                   // of all targets; infinite for Nearest
  std::span<const double> radii;  // one per target, of Radii

  explicit Question(const NeighbourRule& rule) {
    if (const auto* within = std::get_if<Radius>(&rule)) {
      radius = static_cast<S>(within->radius);
    } else if (const auto* own = std::get_if<Radii>(&rule)) {
      radii = own->radii;
    } else if (const auto* near = std::get_if<Nearest>(&rule)) {
      nearest = true;
      k = near->k;
      factor = near->factor;
      radius = std::numeric_limits<S>::infinity();
    } else if (const auto* near_within = std::get_if<NearestWithin>(&rule)) {
      nearest = true;
      k = near_within->k;
      radius = static_cast<S>(near_within->radius);
    }
  }

  S radius_of(std::size_t target) const {
    return radii.empty() ? radius : static_cast<S>(radii[target]);
  }
};

// The kernels of one instruction set.
template <class S, int D>
struct SearchKernels {
  decltype(&generic::collect<S, D>) collect;
  decltype(&generic::near_ball<D>) near;
  decltype(&generic::select_smallest) select_smallest, rank_smallest;
  decltype(&generic::count_at_most) count_at_most;
  decltype(&generic::ranks<S>) rank_distances;
  decltype(&generic::ranks<std::uint32_t>) rank_indices;
  std::int64_t most_ranked;  // beyond this number sorting is faster than ranks()

  SearchKernels(InstructionSet set, bool cube)
      : collect(RECON_DISPATCH(set, collect<S, D>)),
        near(cube ? RECON_DISPATCH(set, near_cube<D>) : RECON_DISPATCH(set, near_ball<D>)),
        select_smallest(RECON_DISPATCH(set, select_smallest)),
        rank_smallest(RECON_DISPATCH(set, rank_smallest)),
        count_at_most(RECON_DISPATCH(set, count_at_most)),
        rank_distances(RECON_DISPATCH(set, ranks<S>)),
        rank_indices(RECON_DISPATCH(set, ranks<std::uint32_t>)),
        most_ranked(set == InstructionSet::avx512 ? 256
                    : set == InstructionSet::avx2 ? 160
                                                  : 96) {}
};

template <class S, int D>
struct SharedByTargets {
  SearchIndex<S, D>& index;
  const PointCloud<S>& particles;
  const PointCloud<S>& targets;
  const NeighbourRule& rule;
  const PeriodicDomain<S>& domain;
  const NeighbourOptions& options;
  const Question<S> question;
  const bool by_index;  // rows by ascending (index, shift), whatever the rule says
  const bool cube;      // is everything in a cube asked for?
  const std::shared_ptr<const CellGrid<S, D>> grid;
  const SearchKernels<S, D> kernels;
  const S spacing;
  int axes = 0;         // along which the particles extend
  double start = 0;     // a first guess of the k-th distance
  double widening = 1;  // by which guesses exceed the k-th distance
  double least_period = 0;
  const bool may_build_tree;
  const std::int64_t hard_work;  // for one target that a query of a tree would not exceed by much

  SharedByTargets(SearchIndex<S, D>& searches, const PointCloud<S>& all_targets,
                  const NeighbourRule& neighbour_rule, const PeriodicDomain<S>& where,
                  const NeighbourOptions& how, bool all_by_index, bool tree_allowed)
      : index(searches),
        particles(searches.cloud()),
        targets(all_targets),
        rule(neighbour_rule),
        domain(where),
        options(how),
        question(rule),
        by_index(all_by_index || !question.nearest),
        cube(options.shape == SupportShape::cube && !question.nearest),
        grid(index.cells(options.threads)),
        kernels(resolved(options.instruction_set), cube),
        spacing(mean_spacing(particles, domain)),
        may_build_tree(tree_allowed),
        hard_work(8000 + 100 * static_cast<std::int64_t>(question.k)) {
    for (int d = 0; d < D; ++d) axes += particles.box().extent(d) > 0;
    axes = std::max(axes, 1);
    const auto k = static_cast<double>(question.k);
    const double unit_ball = axes == 1 ? 2.0 : axes == 2 ? 3.14 : 4.19;
    start = static_cast<double>(spacing) * std::pow(std::max(k, 1.0) / unit_ball, 1.0 / axes);
    // Evenly spread particles in a ball that holds m on average number m +- sqrt(m).
    widening = std::pow((k + 1.6 * std::sqrt(k) + 1) / std::max(k, 1.0), 1.0 / axes);
    least_period = std::numeric_limits<double>::infinity();
    for (int d = 0; d < D; ++d)
      if (domain.periodic[d])
        least_period = std::min(least_period, static_cast<double>(domain.period(d)));
  }
};

}  // namespace recon::detail
