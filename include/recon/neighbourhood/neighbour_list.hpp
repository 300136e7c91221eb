// Who is near whom: for every target the particles in its support, as a compressed sparse row list.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "recon/core/array.hpp"
#include "recon/core/error.hpp"
#include "recon/points/view.hpp"

namespace recon {

using ParticleIndex = std::uint32_t;  // particles are numbered in 32 bits, positions in lists in 64

// One result of a search: which particle, and the square of its distance (length^2).
template <class Scalar>
struct Neighbour {
  ParticleIndex index;
  Scalar distance2;
  friend bool operator==(const Neighbour&, const Neighbour&) = default;
};

// Which periodic image of a particle is meant: its position plus shift[d] periods along axis d.
using ImageShift = std::array<std::int8_t, max_dimension>;

// The neighbours of target t are indices[offsets[t]] .. indices[offsets[t + 1] - 1]. `shifts` is
// empty in domains that are not periodic; else it has an entry per index. `support` holds the
// support radius rho (a length) of every target. An Array is a std::vector whose resize() does not
// set new elements to zero; a list of your own is copied with assign(begin, end).
//
// `support_factor` says what supports do while a target moves, which exact gradients must know. 0:
// they stand still. Else rho is support_factor times the distance to the farthest neighbour (in a
// cube: along one axis), and follows it; a target whose rho is not that one has a support that
// stands still. Nearest{k, factor} makes lists with its factor, all other rules make lists with 0;
// a list of your own has 0 unless you set it.
//
// `pair_support` is empty, or holds for each index the support radius of that pair alone (a
// length): the weight is then w(|x_p - x| / pair_support), and `support` only the unit of length of
// the fit, which must be of the same order. Such supports stand still: support_factor is 0.
//
// `tensor` is empty, or holds for each target a packed support tensor A (support_tensor.hpp): q is
// |A^-1 (x_p - x)|, `support` the largest half axis, and pair_support empty. `pair_tensor` likewise
// holds for each index the tensor of that pair alone, for weights that are radial; `tensor` then is
// only the unit of length of the fit along each direction, which must be of the same order (empty:
// a ball of the radius `support`). Tensors stand still too. A tensor has D (D + 1) / 2 numbers.
template <class Scalar>
struct NeighbourList {
  Array<std::int64_t> offsets{0};
  Array<ParticleIndex> indices;
  Array<ImageShift> shifts;
  Array<Scalar> support;
  Array<Scalar> pair_support;
  Array<Scalar> tensor, pair_tensor;
  Scalar support_factor = 0;

  std::size_t targets() const { return offsets.size() - 1; }
  std::int64_t count(std::size_t target) const { return offsets[target + 1] - offsets[target]; }
  std::span<const ParticleIndex> of(std::size_t target) const {
    return {indices.data() + offsets[target], static_cast<std::size_t>(count(target))};
  }

  // Throws InvalidArgument unless the list is one for `target_count` targets among `particle_count`
  // particles: offsets start at 0, never fall and end at the number of indices; every index is
  // smaller than particle_count; shifts, pair supports and pair tensors are absent or one per
  // index, tensors absent or one per target; supports are positive and finite, tensors positive
  // definite; support_factor is 0, or without pair supports and tensors finite and at least 1.
  void validate(std::size_t target_count, std::size_t particle_count) const;
};

// Reads a list that lives elsewhere; `shifts` is null in domains that are not periodic.
template <class Scalar>
struct NeighbourListView {
  const std::int64_t* offsets = nullptr;
  const ParticleIndex* indices = nullptr;
  const ImageShift* shifts = nullptr;
  const Scalar* support = nullptr;
  const Scalar* pair_support = nullptr;  // null: that of the target
  const Scalar* tensor = nullptr;        // null: balls
  const Scalar* pair_tensor = nullptr;   // null: that of the target
  Scalar support_factor = 0;

  NeighbourListView() = default;
  NeighbourListView(const NeighbourList<Scalar>& list)
      : offsets(list.offsets.data()),
        indices(list.indices.data()),
        shifts(list.shifts.empty() ? nullptr : list.shifts.data()),
        support(list.support.data()),
        pair_support(list.pair_support.empty() ? nullptr : list.pair_support.data()),
        tensor(list.tensor.empty() ? nullptr : list.tensor.data()),
        pair_tensor(list.pair_tensor.empty() ? nullptr : list.pair_tensor.data()),
        support_factor(list.support_factor) {}

  std::int64_t count(std::size_t target) const { return offsets[target + 1] - offsets[target]; }
};

extern template struct NeighbourList<float>;
extern template struct NeighbourList<double>;

}  // namespace recon
