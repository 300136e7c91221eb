#include "core/brief.hpp"
#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
BoundaryPolicy<D>::BoundaryPolicy(const Problem<D>& problem) : Policy<D>(problem) {
  for (int d = 0; d < D; ++d) rooms_[d] = problem.room(d);
  for (const Boundary<D>& boundary : problem.boundaries) {
    if (boundary.images) continue;
    if (const int face = boundary.face(problem.grid);
        face != 0 && boundary.velocity[boundary.axis] == 0.0)
      walls_.push_back({boundary.axis, face > 0, &boundary});
  }
}

template <int D>
std::vector<HeldComponent<D>> BoundaryPolicy<D>::held_in(const Grid<D>& part,
                                                         const std::array<int, D>& first) const {
  const Problem<D>& problem = this->problem_;
  const Grid<D>& grid = problem.grid;
  const Images<D> images = images_of(problem, false);
  // A part of a plane is held in all periods, and in mirrors.
  const auto covered = [&](const Boundary<D>& boundary, const Vector<D>& x) {
    const double margin = 1e-6 * grid.h();
    if (boundary.covers(x, margin)) return true;
    if (images.empty()) return false;
    for (const Image<D>& image : images.of({x}))
      if (boundary.covers(image.x, margin)) return true;
    return false;
  };
  std::vector<HeldComponent<D>> held;
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const Boundary<D>& boundary = problem.boundaries[b];
    if (boundary.images) continue;
    const auto axis = static_cast<std::size_t>(boundary.axis);
    const int plane =
        static_cast<int>(std::lround((boundary.at - grid.lower()[boundary.axis]) / grid.h())) -
        first[axis];
    if (plane < 0 || plane > part.cells(boundary.axis)) continue;
    // The nodes of the plane, by ascending numbers.
    std::array<int, D> index{};
    index[axis] = plane;
    for (std::size_t d = 0; d < D;) {
      const std::uint32_t node = part.number(index);
      // Of the whole grid to the bit, so that all parts cover the same.
      Vector<D> x;
      for (std::size_t e = 0; e < D; ++e)
        x[static_cast<int>(e)] = grid.node(first[e] + index[e], static_cast<int>(e));
      if (covered(boundary, x))
        for (int e = 0; e < D; ++e)
          if (boundary.velocity[e]) held.push_back({node, e, &*boundary.velocity[e], b, x});
      for (d = 0; d < D; ++d) {
        if (d == axis) continue;
        if (++index[d] <= part.cells(static_cast<int>(d))) break;
        index[d] = 0;
      }
    }
  }
  return held;
}

namespace {

template <int D>
double given(const HeldComponent<D>& held, double time) {
  return (*held.velocity)(held.x, time);
}

}  // namespace

template <int D>
void BoundaryPolicy<D>::hold(double time, double lag, Nodes<D>& nodes) const {
  give(time - lag, nodes, nodes.velocity);
  if (lag > 0)
    drive(time - lag, time, nodes);
  else
    rest(nodes, nodes.acceleration);
}

template <int D>
void BoundaryPolicy<D>::drive(double before, double after, Nodes<D>& nodes) const {
  for (const HeldComponent<D>& held : nodes.held)
    nodes.acceleration[held.node][held.axis] =
        held.velocity->varies() ? (given(held, after) - given(held, before)) / (after - before) : 0;
}

template <int D>
void BoundaryPolicy<D>::give(double time, const Nodes<D>& nodes,
                             std::vector<Vector<D>>& velocity) const {
  for (const HeldComponent<D>& held : nodes.held)
    velocity[held.node][held.axis] = given(held, time);
}

template <int D>
void BoundaryPolicy<D>::rest(const Nodes<D>& nodes, std::vector<Vector<D>>& velocity) const {
  for (const HeldComponent<D>& held : nodes.held) velocity[held.node][held.axis] = 0;
}

template <int D>
void BoundaryPolicy<D>::keep_inside(std::size_t begin, std::size_t end, State<D>& s) const {
  const Grid<D>& grid = this->problem_.grid;
  const bool images = this->problem_.has_images();
  for (std::size_t p = begin; p < end; ++p) {
    Vector<D>& x = s.particles.x[p];
    for (const Wall& wall : walls_) {
      double& along = x[wall.axis];
      const double face = wall.upper ? grid.upper(wall.axis) : grid.lower()[wall.axis];
      if (passes_by_a_hair(along, face, wall.upper, grid.h()) && wall.boundary->covers(x, 0))
        along = face;
    }
    if (!x.allFinite()) throw off_grid<D>(s.steps, p, x);
    if (images) keep_in_room(p, s);
    if (grid.contains(x)) continue;
    throw off_grid<D>(s.steps, p, x);
  }
}

template <int D>
Failure off_grid(std::int64_t step, std::size_t p, const Vector<D>& x) {
  if (!x.allFinite()) return {step, "particle", p, "its position is not finite"};
  return {step, "particle", p, "it left the grid at " + recon::detail::brief_place(x)};
}

template <int D>
std::vector<const Boundary<D>*> BoundaryPolicy<D>::walls() const {
  std::vector<const Boundary<D>*> all;
  for (const Wall& wall : walls_) all.push_back(wall.boundary);
  return all;
}

template <int D>
void BoundaryPolicy<D>::keep_in_room(std::size_t p, State<D>& s) const {
  const Problem<D>& problem = this->problem_;
  Particles<D>& particles = s.particles;
  for (int d = 0; d < D; ++d) {
    const auto [from, to] = rooms_[d];
    const double x = particles.x[p][d];
    if (problem.periodic[d]) {
      if (x >= from && x <= to) continue;
      const double shift = std::floor((x - from) / (to - from)) * (to - from);
      particles.x[p][d] -= shift;
      particles.X[p][d] -= shift;
      if (!particles.corners.empty())
        for (Vector<D>& corner : particles.corners[p]) corner[d] -= shift;
    } else if (const double beyond = std::max(from - x, x - to); beyond > problem.grid.h() / 2) {
      throw Failure(s.steps, "particle", p,
                    "it passed the end of its room along " + std::string(1, "xyz"[d]) + " by " +
                        recon::detail::brief(beyond / problem.grid.h()) + " cells");
    }
  }
}

#define RECON_INSTANTIATE(D)        \
  template class BoundaryPolicy<D>; \
  template Failure off_grid(std::int64_t, std::size_t, const Vector<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
