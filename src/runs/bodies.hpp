// Bodies filled with particles.
#pragma once

#include <functional>
#include <optional>

#include "recon/mpm/particles.hpp"
#include "recon/mpm/types.hpp"

namespace recon::mpm {

// The shape of a body: its bounding box, and whether a point of the box is inside.
template <int D>
struct Region {
  Vector<D> lower, upper;  // the smallest box that holds it
  std::function<bool(const Vector<D>&)> inside;
};

// Throws InvalidArgument for a box that reaches out of the grid by more than a millionth of a cell:
// a body is never cut.
template <int D>
void require_in_grid(const Grid<D>& grid, const Vector<D>& lower, const Vector<D>& upper);

// Adds particles at the fractions (j - 1/2) / n of the edges of the grid's cells, n along each
// axis, wherever these places are inside. jitter: each is moved at random by up to this part of its
// own box, in the same way every time. Throws InvalidArgument for a region that reaches out of the
// grid and, before anything is allocated, where its box holds more than `most` such places.
template <int D>
void fill_cells(const Grid<D>& grid, const Region<D>& region, int n, double jitter, double density,
                int body, double most, Particles<D>& out);

// Adds a ring between two radii about a centre: `radial` times `angular` sectors of equal angle.
// The domain of each particle has the area of its sector, one edge along the radius.
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
