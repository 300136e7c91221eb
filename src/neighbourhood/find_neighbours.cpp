#include "recon/neighbourhood/find_neighbours.hpp"

#include <type_traits>

#include "core/instantiate.hpp"
#include "neighbourhood/any_search.hpp"
#include "neighbourhood/cell_search.hpp"
#include "neighbourhood/find_with_index.hpp"
#include "neighbourhood/pair_search.hpp"
#include "recon/neighbourhood/question_checks.hpp"

namespace recon {

namespace {

constexpr std::size_t few_particles = 32;  // brute force is the fastest up to about here

// For the questions that the batch search by cells does not cover.
SearchMethod chosen(SearchMethod method, const NeighbourRule& rule) {
  if (method != SearchMethod::automatic) return method;
  const bool cells = std::holds_alternative<Radius>(rule) ||
                     std::holds_alternative<Ellipsoids>(rule) ||
                     std::holds_alternative<PairEllipsoids>(rule);
  return cells ? SearchMethod::cell_grid : SearchMethod::kd_tree;
}

}  // namespace

namespace detail {

template <int D, class Scalar>
void find_with_index(SearchIndex<Scalar, D>& index, const PointCloud<Scalar>& targets,
                     const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                     const NeighbourOptions& options, const RowsAsked& rows,
                     NeighbourList<Scalar>& list) {
  // Before a search is built for it.
  require_valid_rule<Scalar>(rule, D, targets.size(), index.cloud().size());
  list.pair_support.clear();
  list.tensor.clear();
  list.pair_tensor.clear();
  static_cast<void>(resolved(options.instruction_set));
  const PointCloud<Scalar>& particles = index.cloud();
  require(targets.dimension() == particles.dimension(), "dimension of the targets",
          targets.dimension(), "must be the dimension of the particles");
  const auto with = [&](const auto& search) {
    find_one_by_one(AnySearch<Scalar, D>(*search), particles, targets, rule, domain, options, list);
  };
  const bool automatic = options.search == SearchMethod::automatic;
  if (automatic && particles.size() <= few_particles) return with(index.brute_force());
  if (automatic && finds_pairs(rule)) {
    require_valid_question(particles, targets, rule, domain, options.shape);
    return find_pairs<D>(index, targets, rule, domain, options, list);
  }
  if ((automatic || options.search == SearchMethod::cell_grid) && particles.size() > 0 &&
      covered_by_cells(rule, options)) {
    if (!find_by_cells<D>(index, targets, rule, domain, options, automatic, rows, list))
      with(index.kd_tree());
    return;
  }
  switch (chosen(options.search, rule)) {
    case SearchMethod::cell_grid:
      return with(index.cells(options.threads));
    case SearchMethod::r_tree:
      return with(index.r_tree());
    case SearchMethod::brute_force:
      return with(index.brute_force());
    default:
      return with(index.kd_tree());
  }
}

#define RECON_INSTANTIATE(S, D)                                                                 \
  template void find_with_index<D, S>(                                                          \
      SearchIndex<S, D>&, const PointCloud<S>&, const NeighbourRule&, const PeriodicDomain<S>&, \
      const NeighbourOptions&, const RowsAsked&, NeighbourList<S>&)
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace detail

template <class Scalar>
NeighbourList<Scalar> find_neighbours(const PointCloud<Scalar>& particles,
                                      const PointCloud<Scalar>& targets, const NeighbourRule& rule,
                                      const PeriodicDomain<Scalar>& domain,
                                      const NeighbourOptions& options) {
  NeighbourList<Scalar> list;
  const auto find = [&]<int D>(std::integral_constant<int, D>) {
    detail::SearchIndex<Scalar, D> index(particles);
    detail::find_with_index<D>(index, targets, rule, domain, options, {}, list);
  };
  switch (particles.dimension()) {
    case 1:
      find(std::integral_constant<int, 1>{});
      break;
    case 2:
      find(std::integral_constant<int, 2>{});
      break;
    default:
      find(std::integral_constant<int, 3>{});
      break;
  }
  return list;
}

RECON_FLOAT(template NeighbourList<float> find_neighbours(
                const PointCloud<float>&, const PointCloud<float>&, const NeighbourRule&,
                const PeriodicDomain<float>&, const NeighbourOptions&);)
template NeighbourList<double> find_neighbours(const PointCloud<double>&, const PointCloud<double>&,
                                               const NeighbourRule&, const PeriodicDomain<double>&,
                                               const NeighbourOptions&);

}  // namespace recon
