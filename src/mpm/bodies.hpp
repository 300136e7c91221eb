// Bodies filled with particles.
#pragma once

#include <functional>
#include <optional>

#include "recon/mpm/grid.hpp"
#include "recon/mpm/particles.hpp"

namespace recon::mpm {

// Is this point in the body?
template <int D>
using Inside = std::function<bool(const Vector<D>&)>;

// Particles at the fractions (j - 1/2) / n of the grid's cells, n an axis, wherever they are
// inside. jitter: moved at random by up to this part of their own box, the same way every time.
template <int D>
void fill_cells(const Grid<D>& grid, const Inside<D>& inside, int n, double jitter, double density,
                int body, Particles<D>& out);

// A ring between two radii about a centre: `radial` times `angular` sectors of equal angle; each
// particle's domain has the area of its sector, one edge along the radius.
void fill_ring(const Vector<2>& centre, double inner, double outer, int radial, int angular,
               double density, int body, Particles<2>& out);

// The particles of a body that lie at its surface where the outward normal is normal(X), with
// the normal times the reference area of each.
template <int D>
struct SurfacePart {
  std::size_t particle;
  Vector<D> area;
};
template <int D>
std::vector<SurfacePart<D>> surface(const Particles<D>& particles, int body,
                                    const std::function<Vector<D>(const Vector<D>&)>& normal,
                                    const std::function<double(const Vector<D>&)>& height);

}  // namespace recon::mpm
