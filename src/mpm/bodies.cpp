#include "mpm/bodies.hpp"

#include <limits>
#include <numbers>
#include <random>

namespace recon::mpm {

template <int D>
void fill_cells(const Grid<D>& grid, const Inside<D>& inside, int n, double jitter, double density,
                int body, Particles<D>& out) {
  const double edge = grid.h() / n;
  std::size_t count = 1;
  for (int d = 0; d < D; ++d)
    count *= static_cast<std::size_t>(grid.cells(d)) * static_cast<std::size_t>(n);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < count; ++i) {
    Vector<D> X;
    std::size_t rest = i;
    for (int d = 0; d < D; ++d) {
      const auto along = static_cast<std::size_t>(grid.cells(d)) * static_cast<std::size_t>(n);
      // From the cell's own node: particles of cells that meet at a node mirror each other.
      const std::size_t k = rest % along;
      X[d] = grid.node(static_cast<int>(k / static_cast<std::size_t>(n)), d) +
             (static_cast<double>(k % static_cast<std::size_t>(n)) + 0.5) * edge;
      rest /= along;
    }
    if (!inside(X)) continue;
    for (int d = 0; d < D && jitter > 0; ++d)
      X[d] += jitter * edge * (static_cast<double>(random()) / random.max() - 0.5);
    out.add(X, Matrix<D>::Identity() * (edge / 2), density, body);
  }
}

void fill_ring(const Vector<2>& centre, double inner, double outer, int radial, int angular,
               double density, int body, Particles<2>& out) {
  const double dr = (outer - inner) / radial, turn = 2 * std::numbers::pi / angular;
  for (int r = 0; r < radial; ++r)
    for (int a = 0; a < angular; ++a) {
      const double R = inner + (r + 0.5) * dr, angle = (a + 0.5) * turn;
      const Vector<2> along(std::cos(angle), std::sin(angle)), across(-along[1], along[0]);
      Matrix<2> half;
      half << along * (dr / 2), across * (R * turn / 2);
      out.add(centre + R * along, half, density, body);
    }
}

template <int D>
std::vector<SurfacePart<D>> surface(const Particles<D>& particles, int body,
                                    const std::function<Vector<D>(const Vector<D>&)>& normal,
                                    const std::function<double(const Vector<D>&)>& height) {
  const auto half_thickness = [&](std::size_t p) {
    return (particles.half_edges[p].transpose() * normal(particles.X[p])).cwiseAbs().sum();
  };
  double top = -std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < particles.size(); ++p)
    if (particles.body[p] == body) top = std::max(top, height(particles.X[p]) + half_thickness(p));
  std::vector<SurfacePart<D>> found;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const double half = half_thickness(p);
    if (particles.body[p] == body && height(particles.X[p]) + 1.5 * half > top)
      found.push_back({p, normal(particles.X[p]) * (particles.volume0[p] / (2 * half))});
  }
  return found;
}

#define RECON_INSTANTIATE(D)                                                                      \
  template void fill_cells(const Grid<D>&, const Inside<D>&, int, double, double, int,            \
                           Particles<D>&);                                                        \
  template std::vector<SurfacePart<D>> surface(const Particles<D>&, int,                          \
                                               const std::function<Vector<D>(const Vector<D>&)>&, \
                                               const std::function<double(const Vector<D>&)>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
