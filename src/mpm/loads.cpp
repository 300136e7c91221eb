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
      functions_of(problem, s.particles, nodes, shape_of, load.particle, shape);
      const LoadedPlace<D> place = place_of(load, s.particles);
      const Vector<D> force = load.force(place, s.time);
      const Vector<D> d = place.x - s.particles.x[load.particle];
      for (std::size_t k = 0; k < shape.size(); ++k) {
        const double by_slope = shape.G[k].dot(d);
        nodes.force[shape.node[k]] += (shape.S[k] + by_slope) * force;
        // As of stresses, the part of a light node does not shrink with its mass.
        if (!nodes.internal.empty()) nodes.internal[shape.node[k]] += by_slope * force;
      }
    }
  });
}

template class LoadPolicy<1>;
template class LoadPolicy<2>;
template class LoadPolicy<3>;

}  // namespace recon::mpm
