// How particles see the grid: the functions of transfer/ at their points or domains.
//
// Each is a policy, a small struct: shape() writes S and G (NodeFunctions) and returns the volume
// of the particle, nodes_along() returns the first and the last node that the particle touches on
// an axis, Nodes<D> is the type that shape() writes without allocating, and move() updates through
// a step what the policy keeps with the particle.
//
//   PointShape<F>              functions F at x_p: linear, splines, elements (point_functions.hpp)
//   UniformGimp, StretchedGimp boxes, which keep their reference edges (ugimp) or are stretched by
//                              the diagonal of F (cpgimp)
//   Cpdi1                      parallelepipeds deformed by F
//   Cpdi2                      corners that move with the grid
#pragma once

#include "recon/mpm/particles.hpp"
#include "recon/transfer/domain_functions.hpp"

namespace recon::mpm {

// Functions of the grid at DomainOf::of(particles, p), with nothing kept with the particle.
template <class Functions, class DomainOf>
struct ParticleShape {
  template <int D>
  using Nodes = typename Functions::template Nodes<D>;
  Functions functions;

  template <int D, class Count>
  double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
               NodeFunctions<D, Count>& out) const {
    functions.at(grid, DomainOf::of(particles, p), out);
    return particles.volume(p);
  }
  template <int D>
  std::pair<int, int> nodes_along(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
                                  int d) const {
    return functions.nodes_along(grid, DomainOf::of(particles, p), d);
  }
  template <int D, class Velocity>
  static void move(Particles<D>&, std::size_t, const Velocity&, double) {}
};

struct AtPoint {
  template <int D>
  static const Vector<D>& of(const Particles<D>& particles, std::size_t p) {
    return particles.x[p];
  }
};
struct KeptBox {
  template <int D>
  static BoxDomain<D> of(const Particles<D>& particles, std::size_t p) {
    return ugimp_domain<D>(particles.x[p], particles.half_edges[p]);
  }
};
struct StretchedBox {
  template <int D>
  static BoxDomain<D> of(const Particles<D>& particles, std::size_t p) {
    return cpgimp_domain<D>(particles.x[p], particles.half_edges[p], particles.F[p]);
  }
};
struct DeformedParallelepiped {
  template <int D>
  static ParallelepipedDomain<D> of(const Particles<D>& particles, std::size_t p) {
    return particles.parallelepiped(p);
  }
};

template <class Functions>
using PointShape = ParticleShape<Functions, AtPoint>;
using UniformGimp = ParticleShape<GimpFunctions, KeptBox>;
using StretchedGimp = ParticleShape<GimpFunctions, StretchedBox>;
using Cpdi1 = ParticleShape<Cpdi1Functions, DeformedParallelepiped>;

struct Cpdi2 {
  template <int D>
  using Nodes = Cpdi2Functions::Nodes<D>;

  template <int D, class Count>
  static double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
                      NodeFunctions<D, Count>& out) {
    const CornerDomain<D> domain(particles.corners[p]);
    Cpdi2Functions::at(grid, domain, out);
    return domain.volume;
  }
  template <int D>
  static std::pair<int, int> nodes_along(const Grid<D>& grid, const Particles<D>& particles,
                                         std::size_t p, int d) {
    return Cpdi2Functions::nodes_along<D>(grid, particles.corners[p], d);
  }
  // Corners move with the velocity of the grid, velocity(x); the particle is their centroid.
  template <int D, class Velocity>
  static void move(Particles<D>& particles, std::size_t p, const Velocity& velocity, double dt) {
    for (Vector<D>& corner : particles.corners[p]) corner += dt * velocity(corner);
    particles.x[p] = CornerDomain<D>(particles.corners[p]).centroid();
  }
};

// Whether a policy is a product of functions of the axes at the point of the particle.
template <int D, class Shape>
constexpr bool is_product = requires(const Shape& shape, const Grid<D>& grid, const Vector<D>& x) {
  shape.functions.axes(grid, x);
};

}  // namespace recon::mpm
