#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
void DampingPolicy<D>::slow(const BoundaryPolicy<D>& boundaries, Nodes<D>& nodes) const {
  const Damping& damping = this->problem_.damping;
  nodes.damping.clear();
  if (!damping.any()) return;
  nodes.damping.resize(nodes.mass.size());
  for (std::size_t i = 0; i < nodes.mass.size(); ++i)
    for (int d = 0; d < D; ++d)
      nodes.damping[i][d] = damping_of(damping, nodes.mapped[i][d], nodes.acceleration[i][d]);
  boundaries.rest(nodes, nodes.damping);
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) nodes.acceleration[i] += nodes.damping[i];
}

template class DampingPolicy<1>;
template class DampingPolicy<2>;
template class DampingPolicy<3>;

}  // namespace recon::mpm
