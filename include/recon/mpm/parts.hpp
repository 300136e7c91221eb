// A state that is spread over several parts, each with a step of its own, all of them at once.
//
// A part has particles of its own, which its step moves, and after them copies of those of other
// parts that are within reach (State::others): they give mass, momentum, force and the data of fits
// as all particles do, and have images as all do, so that whatever the part's own particles see of
// the grid is what they would see of it in one whole. Sums over the nodes that parts have in common
// count once by Nodes::share.
//
// What a step has to ask of the other parts is asked here. All parts ask in the same order: a
// function may wait until all of them have.
//
// The mass has to be lumped. All other choices of a method are those of one whole, to rounding: the
// order of sums is another.
#pragma once

#include <optional>
#include <span>

#include "recon/mpm/nodes.hpp"
#include "recon/mpm/state.hpp"

namespace recon::mpm {

template <int D>
class OtherParts {
 public:
  virtual ~OtherParts() = default;

  // Makes the last of the particles copies of those of other parts within reach, as they are now,
  // and s.others their number. Where there are copies already, the same ones are made anew: within
  // a step those that were there at its beginning. Of the history of materials copies need the size
  // alone.
  virtual void copy_to(State<D>& s) = 0;
  // The vectors of the copies become those of the particles that they are copies of.
  virtual void copy_to(const State<D>& s, std::vector<Vector<D>>& of_particles) = 0;
  // Each number becomes the sum of those of all parts, in the same order for all parts.
  virtual void sum(std::span<double> numbers) = 0;
  // The largest of a number of each part.
  virtual double largest(double number) = 0;
  // Where a particle is among own ones and copies, by the number that the loads of the problem have
  // for it; none: it is far away.
  virtual std::optional<std::size_t> place_of(std::size_t number) const = 0;
};

// How far from its own particles a part needs copies of others, a length: as far as particles give
// to nodes that its own see, directly, by fits and by cells, and a cell more, for what moves within
// a step. `widest` is the largest half width of the particles' domains along an axis
// (half_width()).
template <int D>
double reach_of_copies(const Problem<D>& problem, double widest);
// What a part of a state has of the grid of the problem: the cells that its particles, copies and
// images give to, and four more to each side, as far as the grid goes, so that the borders change
// nothing that the part's own particles see. It depends on the state alone. On a periodic axis a
// part with particles at one end has images at the other one, and so the whole axis.
template <int D>
Window<D> seen_by(const Problem<D>& problem, const State<D>& s, const ImageParticles<D>& images);

// The largest half width of the domains along an axis; 0 for points.
template <int D>
double half_width(const Problem<D>& problem, const Particles<D>& particles);

// Throws InvalidArgument for a problem that cannot be solved in parts.
template <int D>
void require_parts(const Problem<D>& problem);

// The particles with these numbers, in this order, and nothing else.
template <int D>
Particles<D> chosen(const Particles<D>& particles, const Kept& kept,
                    std::span<const std::size_t> numbers);
// Other particles after those of `to`.
template <int D>
void append(const Particles<D>& others, const Kept& kept, Particles<D>& to);
// So many particles, without values yet; and particles in the places of a whole with these numbers.
template <int D>
Particles<D> sized(const Kept& kept, std::size_t count);
template <int D>
void put(const Particles<D>& some, const Kept& kept, std::span<const std::uint32_t> numbers,
         Particles<D>& whole);
// The first `count` particles are left.
template <int D>
void keep_first(std::size_t count, const Kept& kept, Particles<D>& particles);

}  // namespace recon::mpm
