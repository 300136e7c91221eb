#include "runs/bodies.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/brief.hpp"

namespace recon::mpm {

template <int D>
void require_in_grid(const Grid<D>& grid, const Vector<D>& lower, const Vector<D>& upper) {
  if (grid.contains(lower) && grid.contains(upper)) return;
  Vector<D> end;
  for (int d = 0; d < D; ++d) end[d] = grid.upper(d);
  const auto from_to = [](const Vector<D>& from, const Vector<D>& to) {
    const auto corner = [](const Vector<D>& x) {
      return D == 1 ? recon::detail::brief(x[0], 9) : recon::detail::brief_place(x);
    };
    return corner(from) + " to " + corner(to);
  };
  recon::detail::throw_invalid(
      "body from", from_to(lower, upper),
      "must lie in the grid, which goes from " + from_to(grid.lower(), end) + ": no body is cut");
}

template <int D>
void fill_cells(const Grid<D>& grid, const Region<D>& region, int n, double jitter, double density,
                int body, double most, Particles<D>& out) {
  require_in_grid(grid, region.lower, region.upper);
  const double edge = grid.h() / n;
  // The places of an axis are first, ..., first + along - 1, counted from the border of the grid.
  std::array<std::size_t, D> first, along;
  double places = 1;
  for (int d = 0; d < D; ++d) {
    const double last = static_cast<double>(grid.cells(d)) * n - 1;
    const auto place = [&](double x, double margin) {
      return static_cast<std::size_t>(
          std::clamp(std::floor((x - grid.lower()[d]) / edge) + margin, 0.0, last));
    };
    first[d] = place(region.lower[d], -1);
    along[d] = place(region.upper[d], 1) - first[d] + 1;
    places *= static_cast<double>(along[d]);
  }
  recon::detail::require(places <= most, "particles of a body", places,
                         "are up to so many, which is more than there is memory for");
  const std::size_t room = out.size() + static_cast<std::size_t>(places);
  out.arrays({}, [&](const ParticleArray& array, auto& values) {
    values.reserve(room * array.per_particle);
  });
  std::mt19937 random(1);
  for (std::size_t i = 0, count = static_cast<std::size_t>(places); i < count; ++i) {
    Vector<D> X;
    std::size_t rest = i;
    for (int d = 0; d < D; ++d) {
      // From the cell's own node: particles of cells that meet at a node mirror each other.
      const std::size_t k = first[d] + rest % along[d];
      X[d] = grid.node(static_cast<int>(k / static_cast<std::size_t>(n)), d) +
             (static_cast<double>(k % static_cast<std::size_t>(n)) + 0.5) * edge;
      rest /= along[d];
    }
    if (!region.inside(X)) continue;
    for (int d = 0; d < D && jitter > 0; ++d)
      X[d] += jitter * edge * (static_cast<double>(random()) / random.max() - 0.5);
    out.add(X, Matrix<D>::Identity() * (edge / 2), density, body);
  }
}

void fill_ring(const Vector<2>& centre, double inner, double outer, const Sector& sector,
               int radial, int angular, double density, int body, Particles<2>& out) {
  const double dr = (outer - inner) / radial, turn = (sector.to - sector.from) / angular;
  for (int r = 0; r < radial; ++r)
    for (int a = 0; a < angular; ++a) {
      const double R = inner + (r + 0.5) * dr, angle = sector.from + (a + 0.5) * turn;
      const Vector<2> along(std::cos(angle), std::sin(angle)), across(-along[1], along[0]);
      Matrix<2> half;
      half << along * (dr / 2), across * (R * turn / 2);
      out.add(centre + R * along, half, density, body);
    }
}

std::pair<Vector<2>, Vector<2>> box_of(const Vector<2>& centre, double inner, double outer,
                                       const Sector& sector) {
  constexpr double quarter = std::numbers::pi / 2;
  std::vector<Vector<2>> ends;
  const auto add = [&](double angle) {
    for (const double R : {inner, outer})
      ends.push_back(centre + R * Vector<2>(std::cos(angle), std::sin(angle)));
  };
  add(sector.from);
  add(sector.to);
  for (double k = std::ceil(sector.from / quarter); k * quarter <= sector.to; ++k) add(k * quarter);
  std::pair<Vector<2>, Vector<2>> box{ends[0], ends[0]};
  for (const Vector<2>& end : ends) box = {box.first.cwiseMin(end), box.second.cwiseMax(end)};
  return box;
}

template <int D>
std::size_t nearest_particle(const Particles<D>& particles, const Vector<D>& at) {
  std::size_t nearest = 0;
  for (std::size_t p = 1; p < particles.size(); ++p)
    if ((particles.X[p] - at).norm() < (particles.X[nearest] - at).norm()) nearest = p;
  return nearest;
}

template <int D>
std::vector<SurfacePart<D>> surface(const Particles<D>& particles, int body, const Side<D>& side) {
  const auto half_thickness = [&](std::size_t p) {
    return (particles.half_edges[p].transpose() * side.normal(particles.X[p])).cwiseAbs().sum();
  };
  // From the middle of a domain to that of its part of the surface.
  const auto offset = [&](std::size_t p, const Vector<D>& normal) -> Vector<D> {
    const Matrix<D>& H = particles.half_edges[p];
    const Vector<D> along = H.transpose() * normal;
    int most = 0;
    along.cwiseAbs().maxCoeff(&most);
    bool is_face = true;
    for (int d = 0; d < D; ++d)
      is_face = is_face && (d == most || std::abs(along[d]) <= 1e-6 * H.col(d).norm());
    return is_face ? Vector<D>((along[most] < 0 ? -1 : 1) * H.col(most))
                   : Vector<D>(std::abs(along[most]) * normal);
  };
  double top = -std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < particles.size(); ++p)
    if (particles.body[p] == body)
      top = std::max(top, side.height(particles.X[p]) + half_thickness(p));
  std::vector<SurfacePart<D>> found;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const Vector<D>& X = particles.X[p];
    const double half = half_thickness(p);
    if (particles.body[p] != body || side.height(X) + 1.5 * half <= top) continue;
    const Vector<D> normal = side.normal(X), to = offset(p, normal);
    double area = particles.volume0[p] / (2 * half);
    if (side.round) area *= std::pow(side.height(X + to) / side.height(X), D - 1);
    found.push_back({p, to, area * normal});
  }
  return found;
}

#define RECON_INSTANTIATE(D)                                                                   \
  template void require_in_grid(const Grid<D>&, const Vector<D>&, const Vector<D>&);           \
  template void fill_cells(const Grid<D>&, const Region<D>&, int, double, double, int, double, \
                           Particles<D>&);                                                     \
  template std::size_t nearest_particle(const Particles<D>&, const Vector<D>&);                \
  template std::vector<SurfacePart<D>> surface(const Particles<D>&, int, const Side<D>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
