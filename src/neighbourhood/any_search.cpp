#include "neighbourhood/any_search.hpp"

#include "core/instantiate.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"

namespace recon::detail {

template <int D, class Scalar>
void find_one_by_one(const AnySearch<Scalar, D>& search, const PointCloud<Scalar>& particles,
                     const PointCloud<Scalar>& targets, const NeighbourRule& rule,
                     const PeriodicDomain<Scalar>& domain, const NeighbourOptions& options,
                     NeighbourList<Scalar>& list) {
  list = find_neighbours_with(search, particles, targets, rule, domain, options);
}

template <class S, int D>
SingleTargets<S, D>::SingleTargets(const AnySearch<S, D>& search, const PointCloud<S>& particles,
                                   const PointCloud<S>& targets, const PeriodicDomain<S>& domain,
                                   const NeighbourOptions& options, S spacing)
    : search_(search),
      neighbours_(std::make_unique<TargetNeighbours<AnySearch<S, D>>>(search_, particles, targets,
                                                                      domain, options, spacing)) {}
template <class S, int D>
SingleTargets<S, D>::~SingleTargets() = default;

template <class S, int D>
S SingleTargets<S, D>::find(std::size_t target, const NeighbourRule& rule) {
  const S rho = std::visit([&](const auto& r) { return neighbours_->find(target, r); }, rule);
  found_.clear();
  for (const auto& entry : neighbours_->entries()) found_.push_back({entry.index, entry.shift});
  return rho;
}

#define RECON_INSTANTIATE(S, D)                                                                 \
  template void find_one_by_one<D, S>(                                                          \
      const AnySearch<S, D>&, const PointCloud<S>&, const PointCloud<S>&, const NeighbourRule&, \
      const PeriodicDomain<S>&, const NeighbourOptions&, NeighbourList<S>&);                    \
  template class SingleTargets<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon::detail
