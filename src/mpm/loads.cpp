#include "mpm/policies.hpp"

namespace recon::mpm {

namespace {

// The functions of the nodes that a point x sees, as they are at another place. Along each axis
// they are those at the place or, where other nodes are seen there, at the farthest point on the way
// at which they are the same, from where they go on linearly. So they sum to one, have the place as
// their mean, and no node counts that the point has no mass at. In the order of the nodes of x.
template <int D, class Functions>
std::vector<double> parts_at(const Grid<D>& grid, const Functions& functions, const Vector<D>& x,
                             const Vector<D>& place) {
  std::vector<double> parts(1, 1.0);
  for (int d = 0; d < D; ++d) {
    const auto own = functions.axis(grid, x[d], d);
    const auto sees_same = [&](double at) {
      const auto there = functions.axis(grid, at, d);
      return there.first == own.first && there.count == own.count;
    };
    double same = place[d];
    if (!sees_same(same)) {
      double other = same;
      same = x[d];
      for (int halving = 0; halving < 30; ++halving) {
        const double middle = (same + other) / 2;
        (sees_same(middle) ? same : other) = middle;
      }
    }
    const auto axis = functions.axis(grid, same, d);
    std::vector<double> product;
    for (int n = 0; n < axis.count; ++n)
      for (const double part : parts)
        product.push_back(part * (axis.S[n] + axis.G[n] * (place[d] - same)));
    parts = std::move(product);
  }
  return parts;
}

}  // namespace

template <int D>
void LoadPolicy<D>::body_force(const State<D>& s, std::vector<Vector<D>>& out) const {
  const Problem<D>& problem = this->problem_;
  out.assign(problem.body_force ? s.particles.size() : 0, Vector<D>::Zero());
  if (problem.body_force) problem.body_force(s.particles, s.time, problem.threads, out);
}

template <int D>
void LoadPolicy<D>::to_nodes(const State<D>& s, const OtherParts<D>* others, std::size_t count,
                             Nodes<D>& nodes) const {
  const Problem<D>& problem = this->problem_;
  if (problem.loads.empty()) return;
  with_shape(problem.method, [&](auto shape_of) {
    typename decltype(shape_of)::template Nodes<D> shape;
    // The functions at a place beside a point; empty: they go on linearly from the point.
    const auto parts_of = [&](const Vector<D>& x, const Vector<D>& place) -> std::vector<double> {
      if constexpr (requires { shape_of.functions.cell_degree; }) {
        // Their G are the slopes of splines, along an axis: forces of stresses meet these.
        constexpr int degree = decltype(shape_of.functions)::cell_degree + 1;
        const SplineFunctions<degree> of_slope{{shape_of.functions.border}};
        if (problem.method.border != SplineBorder::linear_cells)
          return parts_at(nodes.grid, of_slope, x, place);
      } else if constexpr (is_product<D, decltype(shape_of)>) {
        if (problem.method.basis != Basis::mls_bspline2)
          return parts_at(nodes.grid, shape_of.functions, x, place);
      }
      return {};
    };
    // A force on one of the particles, or on one of the images.
    const auto act = [&](const Load<D>& load, const Particles<D>& particles, std::size_t p,
                         const Vector<D>& place, const Vector<D>& force) {
      functions_of(particles, nodes, shape_of, p, shape);
      const Vector<D>& x = particles.x[p];
      // What the node number k of the particle gets.
      const auto add = [&](std::size_t k, double part) {
        nodes.force[shape.node[k]] += part * force;
        // As of stresses, what a light node gets beyond S does not shrink with its mass.
        if (!nodes.internal.empty()) nodes.internal[shape.node[k]] += (part - shape.S[k]) * force;
      };
      const std::vector<double> parts =
          load.offset.isZero() ? std::vector<double>() : parts_of(x, place);
      const Vector<D> d = place - x;
      for (std::size_t k = 0; k < shape.size(); ++k)
        add(k, parts.empty() ? shape.S[k] + shape.G[k].dot(d) : parts[k]);
    };
    const ImageParticles<D>& images = nodes.images;
    const auto add_all = [&](const Load<D>& load) {
      const LoadedPlace<D> place = place_of(load, s.particles);
      const Vector<D> force = load.force(place, s.time);
      act(load, s.particles, load.particle, place.x, force);
      const auto [first, last] = images.of_particle(load.particle);
      for (std::size_t i = first; i < last; ++i) {
        const Image<D>& image = images.of[i];
        act(load, images.particles, i,
            image.x + image.offset(place.x - s.particles.x[load.particle]), image.vector(force));
      }
    };
    for (const Load<D>& load : problem.loads) {
      if (!others) {
        add_all(load);
        continue;
      }
      const std::optional<std::size_t> here = others->place_of(load.particle);
      if (!here || *here >= count) continue;
      Load<D> of_here = load;
      of_here.particle = *here;
      add_all(of_here);
    }
  });
}

template class LoadPolicy<1>;
template class LoadPolicy<2>;
template class LoadPolicy<3>;

}  // namespace recon::mpm
