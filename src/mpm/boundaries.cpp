#include "core/brief.hpp"
#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
BoundaryPolicy<D>::BoundaryPolicy(const Problem<D>& problem) : Policy<D>(problem) {
  const Grid<D>& grid = problem.grid;
  const Images<D> images = images_of(problem, false);
  for (int d = 0; d < D; ++d) rooms_[d] = problem.room(d);
  // A part of a plane is held in all periods, and in mirrors.
  const auto covered = [&](const Boundary<D>& boundary, const Vector<D>& x) {
    const double margin = 1e-6 * grid.h();
    if (boundary.covers(x, margin)) return true;
    if (images.empty()) return false;
    for (const Image<D>& image : images.of({x}))
      if (boundary.covers(image.x, margin)) return true;
    return false;
  };
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const Boundary<D>& boundary = problem.boundaries[b];
    if (boundary.images) continue;
    const auto plane = static_cast<std::size_t>(
        std::lround((boundary.at - grid.lower()[boundary.axis]) / grid.h()));
    if (const int face = boundary.face(grid); face != 0 && boundary.velocity[boundary.axis] == 0.0)
      walls_.push_back({boundary.axis, face > 0, &boundary});
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (grid.nodes().index(i)[boundary.axis] != plane) continue;
      if (!covered(boundary, grid.position(i))) continue;
      for (int d = 0; d < D; ++d)
        if (boundary.velocity[d])
          held_.push_back({static_cast<std::uint32_t>(i), d, &*boundary.velocity[d], b});
    }
  }
}

template <int D>
void BoundaryPolicy<D>::hold(double time, double lag, Nodes<D>& nodes) const {
  give(time - lag, nodes.velocity);
  if (lag > 0)
    drive(time - lag, time, nodes);
  else
    rest(nodes.acceleration);
}

template <int D>
void BoundaryPolicy<D>::drive(double before, double after, Nodes<D>& nodes) const {
  for (const Held& held : held_)
    nodes.acceleration[held.node][held.axis] =
        held.velocity->varies() ? (given(held, after) - given(held, before)) / (after - before) : 0;
}

template <int D>
void BoundaryPolicy<D>::give(double time, std::vector<Vector<D>>& velocity) const {
  for (const Held& held : held_) velocity[held.node][held.axis] = given(held, time);
}

template <int D>
void BoundaryPolicy<D>::rest(std::vector<Vector<D>>& velocity) const {
  for (const Held& held : held_) velocity[held.node][held.axis] = 0;
}

template <int D>
void BoundaryPolicy<D>::keep_inside(std::size_t begin, std::size_t end, State<D>& s) const {
  const Grid<D>& grid = this->problem_.grid;
  const double margin = 1e-3 * grid.h();  // that a particle is put back
  const bool images = this->problem_.has_images();
  for (std::size_t p = begin; p < end; ++p) {
    Vector<D>& x = s.particles.x[p];
    for (const Wall& wall : walls_) {
      double& along = x[wall.axis];
      const double face = wall.upper ? grid.upper(wall.axis) : grid.lower()[wall.axis];
      const double beyond = wall.upper ? along - face : face - along;
      if (beyond > 0 && beyond < margin && wall.boundary->covers(x, 0)) along = face;
    }
    if (!x.allFinite()) throw Failure(s.steps, "particle", p, "its position is not finite");
    if (images) keep_in_room(p, s);
    if (grid.contains(x)) continue;
    throw Failure(s.steps, "particle", p, "it left the grid at " + recon::detail::brief_place(x));
  }
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

template class BoundaryPolicy<1>;
template class BoundaryPolicy<2>;
template class BoundaryPolicy<3>;

}  // namespace recon::mpm
