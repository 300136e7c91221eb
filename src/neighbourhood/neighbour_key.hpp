// A neighbour in one number: its index, and behind it the shift in periodic domains, so that the
// order of the keys is the one that the rules ask for.
#pragma once

#include <cstdint>
#include <type_traits>

#include "recon/neighbourhood/neighbour_list.hpp"

namespace recon::detail {

template <bool periodic>
struct NeighbourKey {
  using Key = std::conditional_t<periodic, std::uint64_t, std::uint32_t>;

  static constexpr Key of(ParticleIndex index, const ImageShift& shift) {
    if constexpr (!periodic) return index;
    Key key = index;
    for (const std::int8_t s : shift) key = key << 8 | static_cast<std::uint32_t>(s + 128);
    return key;
  }
  static constexpr ParticleIndex index(Key key) {
    if constexpr (periodic) return static_cast<ParticleIndex>(key >> 24);
    return static_cast<ParticleIndex>(key);
  }
  static constexpr ImageShift shift(Key key) {
    ImageShift shift{};
    for (int d = 0; d < max_dimension; ++d)
      shift[d] = static_cast<std::int8_t>(static_cast<int>(key >> (16 - 8 * d) & 0xFF) - 128);
    return shift;
  }
};

}  // namespace recon::detail
