#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
void LoadPolicy<D>::body_force(const State<D>& s, std::vector<Vector<D>>& out) const {
  out.assign(problem_.body_force ? s.particles.size() : 0, Vector<D>::Zero());
  if (problem_.body_force) problem_.body_force(s.particles, s.time, problem_.threads, out);
}

template <int D>
void LoadPolicy<D>::to_nodes(const State<D>& s, Nodes<D>& nodes) const {
  if (problem_.loads.empty()) return;
  with_shape(problem_.method, [&](auto shape_of) {
    typename decltype(shape_of)::template Nodes<D> shape;
    for (const Load<D>& load : problem_.loads) {
      const Vector<D> force = force_of(load, s.particles, s.time);
      shape_of.shape(problem_.grid, s.particles, load.particle, shape);
      for (std::size_t k = 0; k < shape.size(); ++k)
        nodes.force[shape.node[k]] += shape.S[k] * force;
    }
  });
}

template class LoadPolicy<1>;
template class LoadPolicy<2>;
template class LoadPolicy<3>;

}  // namespace recon::mpm
