// The materials of a problem for code that runs on a GPU: one of the alternatives of `Material`, as
// its bytes. std::variant itself is for the processor.
#pragma once

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <variant>

#include "cuda/device_code.hpp"
#include "recon/mpm/material.hpp"

namespace recon::mpm {

template <class Variant>
struct OneOf;
template <class... Ms>
struct OneOf<std::variant<Ms...>> {
  static_assert((std::is_trivially_copyable_v<Ms> && ...));
  std::size_t kind = 0;
  alignas(double) unsigned char bytes[std::max({sizeof(Ms)...})]{};

  OneOf() = default;
  explicit OneOf(const std::variant<Ms...>& from) : kind(from.index()) {
    std::visit([&](const auto& m) { std::memcpy(bytes, &m, sizeof m); }, from);
  }
  // Calls work(material).
  template <class Work>
  RECON_DEVICE void visit(const Work& work) const {
    std::size_t each = 0;
    (visit_as<Ms>(each++, work), ...);
  }

  template <class M, class Work>
  RECON_DEVICE void visit_as(std::size_t number, const Work& work) const {
    if (number == kind) work(*reinterpret_cast<const M*>(bytes));
  }
};

using MaterialOnGpu = OneOf<Material>;

}  // namespace recon::mpm
