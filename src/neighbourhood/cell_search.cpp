#include "neighbourhood/cell_search.hpp"

#include "core/instantiate.hpp"
#include "neighbourhood/all_targets.hpp"
#include "recon/neighbourhood/question_checks.hpp"

namespace recon::detail {

bool covered_by_cells(const NeighbourRule& rule, const NeighbourOptions& options) {
  return !options.visible && !std::holds_alternative<PairRadii>(rule) &&
         !std::holds_alternative<Ellipsoids>(rule) &&
         !std::holds_alternative<PairEllipsoids>(rule) &&
         !(std::holds_alternative<NearestWithin>(rule) && options.shape == SupportShape::cube);
}

template <int D, class Scalar>
bool find_by_cells(SearchIndex<Scalar, D>& particles, const PointCloud<Scalar>& targets,
                   const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                   const NeighbourOptions& options, bool may_build_tree, const RowsAsked& rows,
                   NeighbourList<Scalar>& list) {
  require_valid_question(particles.cloud(), targets, rule, domain, options.shape);
  SharedByTargets<Scalar, D> shared(particles, targets, rule, domain, options, rows.by_index,
                                    may_build_tree);
  const double too_many = 1000 + 10 * static_cast<double>(shared.question.k);
  if (may_build_tree && shared.question.nearest &&
      shared.grid->sorted_cells().mean_company() > too_many)
    return false;
  if (domain.any())
    AllTargets<Scalar, D, true>(shared, rows, list).find();
  else
    AllTargets<Scalar, D, false>(shared, rows, list).find();
  list.support_factor = static_cast<Scalar>(shared.question.factor);
  return true;
}

#define RECON_INSTANTIATE(S, D)                                                                 \
  template bool find_by_cells<D, S>(                                                            \
      SearchIndex<S, D>&, const PointCloud<S>&, const NeighbourRule&, const PeriodicDomain<S>&, \
      const NeighbourOptions&, bool, const RowsAsked&, NeighbourList<S>&)
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon::detail
