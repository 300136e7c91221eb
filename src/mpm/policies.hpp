// The policies that a step is made of: one for each choice of the method.
//
// They are asked once a step, or once a block of particles; what they keep is their choice, so that
// one set of them serves any number of steps. The loops over particles are templates over the
// shape functions (mpm/shapes.hpp), chosen outside of the loop.
#pragma once

#include <memory>

#include "core/flatten.hpp"
#include "mpm/pointwise.hpp"
#include "recon/core/parallel.hpp"
#include "recon/mpm/step.hpp"
#include "recon/transfer/images.hpp"

namespace recon::mpm {

constexpr std::size_t particles_per_block = 1024, nodes_per_block = 4096;

// What particles give to the nodes themselves; the rest is the quadrature's.
struct FromParticles {
  bool mass_and_force = true;  // else momentum alone
  // Where not null: cells with more than 0 here stand for their particles.
  const std::vector<double>* full = nullptr;

  template <int D>
  bool leaves_out(const Grid<D>& grid, const Vector<D>& x) const {
    return full && (*full)[grid.cell_number(x)] > 0;
  }
};

// What all policies know.
template <int D>
class Policy {
 public:
  explicit Policy(const Problem<D>& problem) : problem_(problem) {}
  virtual ~Policy() = default;

 protected:
  const Problem<D>& problem_;
};

// Mass and forces of the nodes (and momentum, where the quadrature reconstructs it). This one
// leaves everything to the particles.
template <int D>
class QuadraturePolicy : public Policy<D> {
 public:
  using Policy<D>::Policy;
  // Adds what is integrated over cells, with the body force per mass of the particles, and says
  // what is left to the particles.
  virtual FromParticles over_cells(const State<D>&, const std::vector<Vector<D>>&, Cells<D>&,
                                   Nodes<D>&) const {
    return {};
  }
};

// Momentum of the nodes from that of the particles, and fits of it.
template <int D>
class MapPolicy : public Policy<D> {
 public:
  using Policy<D>::Policy;
  // Adds the particles' momentum and, as far as the quadrature leaves it to them, mass and force.
  void to_nodes(const State<D>& s, const std::vector<Vector<D>>& b, const FromParticles& from,
                Nodes<D>& nodes) const;
  // v_i of the map, where they are p_i / m_i before; with the method's correction of momentum.
  void velocities(const State<D>& s, OtherParts<D>* parts, Nodes<D>& nodes) const;

 protected:
  // Replaces v_i of the nodes with mass.
  virtual void fit(const State<D>&, Nodes<D>&) const {}
};

// The nodes' held velocities, and the walls that particles do not pass.
template <int D>
class BoundaryPolicy : public Policy<D> {
 public:
  explicit BoundaryPolicy(const Problem<D>& problem);
  // What is held of the nodes of a part of the problem's grid that begins at this index.
  std::vector<HeldComponent<D>> held_in(const Grid<D>& part, const std::array<int, D>& first) const;
  // v_i as it is given at the time of the velocities, `lag` before `time`; and a_i that makes it
  // what it is at `time`, or zero without a lag. The change over a kick is not known yet.
  void hold(double time, double lag, Nodes<D>& nodes) const;
  // a_i of the held nodes that changes their velocities from one time to another.
  void drive(double before, double after, Nodes<D>& nodes) const;
  // Components of held velocities of these nodes become those of this time, or 0.
  void give(double time, const Nodes<D>& nodes, std::vector<Vector<D>>& velocity) const;
  void rest(const Nodes<D>& nodes, std::vector<Vector<D>>& velocity) const;
  // Puts back what has passed a wall by a hair, and what has left a period to its other end. Throws
  // Failure for a particle that is not in the grid then, and for one that is more than half a cell
  // beyond a boundary with images.
  void keep_inside(std::size_t begin, std::size_t end, State<D>& s) const;
  // The boundaries that are walls: faces of the grid whose nodes have no normal velocity.
  std::vector<const Boundary<D>*> walls() const;

 private:
  // A face of the grid whose nodes have no normal velocity.
  struct Wall {
    int axis = 0;
    bool upper = false;
    const Boundary<D>* boundary = nullptr;
  };
  // The same for one particle where there are images.
  void keep_in_room(std::size_t p, State<D>& s) const;
  std::array<std::pair<double, double>, D> rooms_;
  std::vector<Wall> walls_;
};

// The images that give to the nodes of a problem, and with those beyond planes of symmetry, whose
// nodes are held, what fits see, as far as their supports reach.
template <int D>
Images<D> images_of(const Problem<D>& problem, bool of_fits) {
  const Grid<D>& grid = problem.grid;
  Images<D> images(grid, (problem.has_images() ? image_cells : 2) * grid.h());
  for (int d = 0; d < D; ++d)
    if (problem.periodic[d]) images.repeat(d, problem.room(d).first, problem.room(d).second);
  for (const Boundary<D>& boundary : problem.boundaries) {
    if (boundary.symmetry && of_fits) images.mirror(boundary.axis, boundary.face(grid) > 0);
    if (boundary.images)
      images.mirror(boundary.axis, boundary.is_upper(grid), boundary.at,
                    boundary.holds_all() && D > 1 ? Mirror::odd : Mirror::even);
  }
  return images;
}

// The images that give to the nodes.
template <int D>
class ImagePolicy : public Policy<D> {
 public:
  explicit ImagePolicy(const Problem<D>& problem)
      : Policy<D>(problem), images_(images_of(problem, false)) {}
  // Makes nodes.images of the particles and their body force per mass.
  void make(const State<D>& s, const std::vector<Vector<D>>& b, Nodes<D>& nodes) const;
  // Makes nodes.share.
  void share(const State<D>& s, Nodes<D>& nodes) const;

 private:
  Images<D> images_;
};

// v_i = p_i / m_i and a_i = f_i / m_i + g.
template <int D>
class MassPolicy : public Policy<D> {
 public:
  using Policy<D>::Policy;
  virtual void accelerate(const State<D>&, const FromParticles&, const BoundaryPolicy<D>&,
                          Nodes<D>& nodes) const;
  // Reports the first negative mass and the first change of sign, and stops where that is asked
  // for.
  void watch(std::int64_t step, Nodes<D>& nodes, MassSigns& signs) const;
};

// What takes motion from the nodes.
template <int D>
class DampingPolicy : public Policy<D> {
 public:
  using Policy<D>::Policy;
  // Changes accelerations, and says in nodes.damping by how much: against the mapped velocities,
  // where no velocity is held.
  void slow(const BoundaryPolicy<D>& boundaries, Nodes<D>& nodes) const;
};

// Forces on the particles from outside.
template <int D>
class LoadPolicy : public Policy<D> {
 public:
  using Policy<D>::Policy;
  // The body force per mass of each particle; empty: none.
  void body_force(const State<D>& s, std::vector<Vector<D>>& out) const;
  // Adds the loads on single particles, of the first `count` ones, to the forces of the nodes.
  void to_nodes(const State<D>& s, const OtherParts<D>* parts, std::size_t count,
                Nodes<D>& nodes) const;
};

// F <- (I + dt L) F, stress, energy and history of a block of particles with the velocity gradients
// L. Throws Failure for a particle that is turned inside out.
template <int D>
void strain(const Problem<D>& problem, std::size_t begin, std::size_t end, double dt, State<D>& s);
// The same with a deformation that is given.
template <int D>
void strain_to(const Problem<D>& problem, std::size_t begin, std::size_t end, double dt,
               State<D>& s);

// What is wrong with a particle of this det F, and with one at a place that is not in the grid.
Failure turned_inside_out(std::int64_t step, std::size_t p, double det_F);
template <int D>
Failure off_grid(std::int64_t step, std::size_t p, const Vector<D>& x);

// The way back: v_p, x_p, L_p and what follows from L.
template <int D>
class UpdatePolicy : public Policy<D> {
 public:
  using Policy<D>::Policy;
  virtual void move(Step<D>& step, State<D>& s, double dt) const = 0;
};

// Of the problem's method; the first one is asked by make_update().
template <int D>
std::unique_ptr<const UpdatePolicy<D>> make_runge_kutta(const Problem<D>& problem);
template <int D>
std::unique_ptr<const QuadraturePolicy<D>> make_quadrature(const Problem<D>& problem);
template <int D>
std::unique_ptr<const MapPolicy<D>> make_map(const Problem<D>& problem);
template <int D>
std::unique_ptr<const MassPolicy<D>> make_mass(const Problem<D>& problem);
template <int D>
std::unique_ptr<const UpdatePolicy<D>> make_update(const Problem<D>& problem);

template <int D>
struct Policies {
  explicit Policies(const Problem<D>& problem)
      : quadrature(make_quadrature(problem)),
        map(make_map(problem)),
        mass(make_mass(problem)),
        boundaries(problem),
        loads(problem),
        damping(problem),
        images(problem),
        update(make_update(problem)) {}

  std::unique_ptr<const QuadraturePolicy<D>> quadrature;
  std::unique_ptr<const MapPolicy<D>> map;
  std::unique_ptr<const MassPolicy<D>> mass;
  BoundaryPolicy<D> boundaries;
  LoadPolicy<D> loads;
  DampingPolicy<D> damping;
  ImagePolicy<D> images;
  std::unique_ptr<const UpdatePolicy<D>> update;
};

// Writes S and G of a particle, and returns its volume: its own, or those with which it stands for
// cells where the quadrature says so.
template <int D, class Shape, class At>
double functions_of(const Particles<D>& particles, const Nodes<D>& nodes, const Shape& shape_of,
                    std::size_t p, At& shape) {
  const double volume = shape_of.shape(nodes.grid, particles, p, shape);
  if constexpr (requires { shape_of.functions.cell_degree; })
    if (!nodes.weights.empty())
      return nodes.weights.gradients(nodes.grid, particles.x[p], volume, shape);
  return volume;
}

// Calls each(p, shape, scratch) for all own particles, with the functions that they see the grid by
// and one Scratch for each block of them, and done(begin, end) after each block.
template <class Scratch, int D, class Shape, class Each, class Done>
void for_each_shape(const Problem<D>& problem, const State<D>& s, const Nodes<D>& nodes,
                    const Shape& shape_of, const Each& each, const Done& done) {
  const Particles<D>& particles = s.particles;
  // Flattened: with so many shapes the compiler runs out of what it inlines.
  parallel_blocks(s.own(), particles_per_block, problem.threads,
                  [&](std::size_t begin, std::size_t end) RECON_FLATTEN {
                    typename Shape::template Nodes<D> shape;
                    Scratch scratch;
                    for (std::size_t p = begin; p < end; ++p) {
                      functions_of(particles, nodes, shape_of, p, shape);
                      each(p, shape, scratch);
                    }
                    done(begin, end);
                  });
}

// How far a box or parallelepiped with these half edges reaches from its centre along the axes.
template <class HalfEdges>
auto half_widths(const HalfEdges& half_edges) {
  return half_edges.cwiseAbs().rowwise().sum().eval();
}
// The same of the domain of a particle; 0 for points.
template <int D>
Vector<D> half_widths_of_domain(const Method& method, const Particles<D>& particles,
                                std::size_t p) {
  if (method.domain == Domain::point) return Vector<D>::Zero();
  if (method.domain == Domain::ugimp) return half_widths(particles.half_edges[p]);
  return half_widths(particles.parallelepiped(p).half_edges);
}

// Calls each(image, its number) for the images of particle p, which is at x, in mirrors, as far as
// these and their domains lie within two cells of the mirrors; returns how many there are. A
// particle takes the mean of what it and these see, as an image has it: nodes on both sides of a
// plane between them are no images of each other, and what a particle takes is then the transpose
// of what it and its image give. Without that disturbances beside a wall grow. Farther beyond the
// mirror nodes lack images of their own; so they do for splines at any image.
template <int D, class Each>
int for_mirrors(const Problem<D>& problem, const Nodes<D>& nodes, const Vector<D>& x, std::size_t p,
                const Each& each) {
  int count = 0;
  if (nodes.images.of.empty() || problem.method.basis != Basis::linear) return count;
  const auto [first, last] = nodes.images.of_particle(p);
  for (std::size_t i = first; i < last; ++i) {
    const Image<D>& image = nodes.images.of[i];
    if (image.mirrored == 0) continue;
    const Vector<D> farthest = (image.x - x).cwiseAbs() / 2 +
                               half_widths_of_domain(problem.method, nodes.images.particles, i);
    if (!(farthest.maxCoeff() <= 2 * problem.grid.h())) continue;
    each(image, i);
    ++count;
  }
  return count;
}

// A definition for every dimension.
#define RECON_DIMENSIONS(INSTANTIATE) INSTANTIATE(1) INSTANTIATE(2) INSTANTIATE(3)

}  // namespace recon::mpm
