#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
void LoadPolicy<D>::body_force(const State<D>& s, std::vector<Vector<D>>& out) const {
  const Problem<D>& problem = this->problem_;
  out.assign(problem.body_force ? s.particles.size() : 0, Vector<D>::Zero());
  if (problem.body_force) problem.body_force(s.particles, s.time, problem.threads, out);
}

template <int D>
void LoadPolicy<D>::to_nodes(const State<D>& s, Nodes<D>& nodes) const {
  const Problem<D>& problem = this->problem_;
  if (problem.loads.empty()) return;
  with_shape(problem.method, [&](auto shape_of) {
    typename decltype(shape_of)::template Nodes<D> shape;
    for (const Load<D>& load : problem.loads) {
      shape_of.shape(problem.grid, s.particles, load.particle, shape);
      shape.add(nodes.force, force_of(load, s.particles, s.time), trusted);
    }
  });
}

template class LoadPolicy<1>;
template class LoadPolicy<2>;
template class LoadPolicy<3>;

}  // namespace recon::mpm
