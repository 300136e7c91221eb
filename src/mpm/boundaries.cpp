#include "core/brief.hpp"
#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
BoundaryPolicy<D>::BoundaryPolicy(const Problem<D>& problem) : Policy<D>(problem) {
  const Grid<D>& grid = problem.grid;
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const Boundary<D>& boundary = problem.boundaries[b];
    const auto plane = static_cast<std::size_t>(
        std::lround((boundary.at - grid.lower()[boundary.axis]) / grid.h()));
    if (boundary.velocity[boundary.axis] == 0.0) {
      if (plane == 0) walls_[boundary.axis][0] = true;
      if (plane == static_cast<std::size_t>(grid.cells(boundary.axis)))
        walls_[boundary.axis][1] = true;
    }
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (grid.nodes().index(i)[boundary.axis] != plane) continue;
      for (int d = 0; d < D; ++d)
        if (boundary.velocity[d])
          held_.push_back({static_cast<std::uint32_t>(i), d, *boundary.velocity[d], b});
    }
  }
}

template <int D>
void BoundaryPolicy<D>::hold(Nodes<D>& nodes) const {
  give(nodes.velocity);
  rest(nodes.acceleration);
}

template <int D>
void BoundaryPolicy<D>::give(std::vector<Vector<D>>& velocity) const {
  for (const Held& held : held_) velocity[held.node][held.axis] = held.velocity;
}

template <int D>
void BoundaryPolicy<D>::rest(std::vector<Vector<D>>& velocity) const {
  for (const Held& held : held_) velocity[held.node][held.axis] = 0;
}

template <int D>
void BoundaryPolicy<D>::keep_inside(std::size_t begin, std::size_t end, State<D>& s) const {
  const Grid<D>& grid = this->problem_.grid;
  const double margin = 1e-3 * grid.h();  // that a particle is put back
  for (std::size_t p = begin; p < end; ++p) {
    Vector<D>& x = s.particles.x[p];
    for (int d = 0; d < D; ++d) {
      const double lower = grid.lower()[d], upper = grid.upper(d);
      if (walls_[d][0] && x[d] < lower && x[d] > lower - margin) x[d] = lower;
      if (walls_[d][1] && x[d] > upper && x[d] < upper + margin) x[d] = upper;
    }
    if (!x.allFinite()) throw Failure(s.steps, "particle", p, "its position is not finite");
    if (grid.contains(x)) continue;
    std::string at;
    for (int d = 0; d < D; ++d) at += (d ? ", " : "") + recon::detail::brief(x[d], 9);
    throw Failure(s.steps, "particle", p, "it left the grid at (" + at + ")");
  }
}

template class BoundaryPolicy<1>;
template class BoundaryPolicy<2>;
template class BoundaryPolicy<3>;

}  // namespace recon::mpm
