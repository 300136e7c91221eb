#include "recon/neighbourhood/find_neighbours.hpp"

#include "neighbourhood/cell_search.hpp"
#include "recon/neighbourhood/brute_force.hpp"
#include "recon/neighbourhood/cell_grid.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"
#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/neighbourhood/r_tree.hpp"

namespace recon {

namespace {

constexpr std::size_t few_particles = 32;  // brute force is the fastest up to about here

// For the questions that the batch search by cells does not cover.
SearchMethod chosen(SearchMethod method, const NeighbourRule& rule) {
  if (method != SearchMethod::automatic) return method;
  return std::holds_alternative<Radius>(rule) ? SearchMethod::cell_grid : SearchMethod::kd_tree;
}

template <class Scalar, int D>
CellGrid<Scalar, D> cell_grid(const PointCloud<Scalar>& particles, const NeighbourRule& rule) {
  if (const auto* radius = std::get_if<Radius>(&rule))
    return CellGrid<Scalar, D>(particles, radius->radius / 2);
  return CellGrid<Scalar, D>(particles);
}

template <int D, class Scalar>
NeighbourList<Scalar> find(const PointCloud<Scalar>& particles, const PointCloud<Scalar>& targets,
                           const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                           const NeighbourOptions& options) {
  const auto with = [&](const auto& search) {
    return find_neighbours_with(search, particles, targets, rule, domain, options);
  };
  const bool automatic = options.search == SearchMethod::automatic;
  if (automatic && particles.size() <= few_particles) return with(BruteForce<Scalar, D>(particles));
  if ((automatic || options.search == SearchMethod::cell_grid) && particles.size() > 0 &&
      detail::covered_by_cells(rule, options)) {
    auto list = detail::find_by_cells<D>(particles, targets, rule, domain, options, automatic);
    if (list) {
      list->support_factor = detail::support_factor<Scalar>(rule);
      return *std::move(list);
    }
    return with(KdTree<Scalar, D>(particles));
  }
  switch (chosen(options.search, rule)) {
    case SearchMethod::cell_grid:
      return with(cell_grid<Scalar, D>(particles, rule));
    case SearchMethod::r_tree:
      return with(RTree<Scalar, D>(particles));
    case SearchMethod::brute_force:
      return with(BruteForce<Scalar, D>(particles));
    default:
      return with(KdTree<Scalar, D>(particles));
  }
}

}  // namespace

template <class Scalar>
NeighbourList<Scalar> find_neighbours(const PointCloud<Scalar>& particles,
                                      const PointCloud<Scalar>& targets, const NeighbourRule& rule,
                                      const PeriodicDomain<Scalar>& domain,
                                      const NeighbourOptions& options) {
  detail::require_valid_rule<Scalar>(rule, targets.size());  // before a search is built for it
  static_cast<void>(resolved(options.instruction_set));
  switch (particles.dimension()) {
    case 1:
      return find<1>(particles, targets, rule, domain, options);
    case 2:
      return find<2>(particles, targets, rule, domain, options);
    default:
      return find<3>(particles, targets, rule, domain, options);
  }
}

template NeighbourList<float> find_neighbours(const PointCloud<float>&, const PointCloud<float>&,
                                              const NeighbourRule&, const PeriodicDomain<float>&,
                                              const NeighbourOptions&);
template NeighbourList<double> find_neighbours(const PointCloud<double>&, const PointCloud<double>&,
                                               const NeighbourRule&, const PeriodicDomain<double>&,
                                               const NeighbourOptions&);

}  // namespace recon
