// Bodies filled with particles.
#pragma once

#include <functional>
#include <numbers>
#include <optional>
#include <utility>

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

// Adds a ring between two radii about a centre, or the part of it between two angles (radian,
// counter-clockwise from x): `radial` times `angular` sectors of equal angle. The domain of each
// particle has the area of its sector, one edge along the radius.
struct Sector {
  double from = 0, to = 2 * std::numbers::pi;
};
void fill_ring(const Vector<2>& centre, double inner, double outer, const Sector& sector,
               int radial, int angular, double density, int body, Particles<2>& out);
// The smallest box that holds it.
std::pair<Vector<2>, Vector<2>> box_of(const Vector<2>& centre, double inner, double outer,
                                       const Sector& sector);

// The particle whose reference position is nearest to a place; the first of equally near ones.
template <int D>
std::size_t nearest_particle(const Particles<D>& particles, const Vector<D>& at);

// A side of a body: the outward normal at a reference place, and how far out a place lies. A round
// side is about a centre, from which the height is measured, inwards with a minus.
template <int D>
struct Side {
  std::function<Vector<D>(const Vector<D>&)> normal;
  std::function<double(const Vector<D>&)> height;
  bool round = false;
};

// The particles of a body that lie at a side, each with its part of the surface: the vector from
// the middle of its reference domain to that of the part, and the normal times the reference area.
// The middle is that of a face of the domain where the side is one, else where the half edge that
// is most along the normal ends, seen along the normal. On a round side the area is that at its own
// distance from the centre.
template <int D>
struct SurfacePart {
  std::size_t particle;
  Vector<D> offset, area;
};
template <int D>
std::vector<SurfacePart<D>> surface(const Particles<D>& particles, int body, const Side<D>& side);

}  // namespace recon::mpm
