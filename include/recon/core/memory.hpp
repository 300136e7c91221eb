// Where the kernels for one target keep arrays whose length follows the number of its particles.
//
// A kernel is a template over one of these, which is also an argument of its constructor:
//   Growing     std::vector: grows to the largest target, so that nothing is allocated once warm.
//               The default.
//   RoomFor<n>  arrays within the object, for at most n particles: for constant expressions, and
//               for the threads of a GPU.
//   Given       memory handed in by the caller, for at most as many particles as the caller says.
//               Copies of such a kernel share the memory.
// With RoomFor and Given nothing is allocated. A target with more particles than there is room for
// throws InvalidArgument; in device code, which cannot throw, it ends the kernel with a trap.
//
// ```cpp
//   using Solve = recon::GramSchmidt<double, recon::Monomials<3, 2>, 2, recon::Given>;
//   std::array<std::byte, Solve::bytes_for(64)> bytes;  // for 64 particles
//   recon::Workspace workspace(bytes);
//   Solve solve({}, {workspace, 64});
//   const recon::FitReport report = solve.fit(cloud);
// ```
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

#include "recon/core/error.hpp"

namespace recon {

// Memory of the caller, dealt out from its front.
class Workspace {
 public:
  explicit constexpr Workspace(std::span<std::byte> memory)
      : next_(memory.data()), left_(memory.size()) {}

  // The bytes that take<U>(count) uses up at most.
  template <class U>
  static constexpr std::size_t bytes_for(std::size_t count) {
    return count * sizeof(U) + alignof(U) - 1;
  }

  // An array of `count` zeros. Throws InvalidArgument where too little is left.
  template <class U>
  constexpr std::span<U> take(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<U>);
    const auto misplaced = reinterpret_cast<std::uintptr_t>(next_) % alignof(U);
    const std::size_t skipped = misplaced == 0 ? 0 : alignof(U) - misplaced;
    const std::size_t size = skipped + count * sizeof(U);
    detail::require(size <= left_, "bytes left in the workspace", left_,
                    "must suffice: bytes_for() of what is kept there says how many");
    auto* const first = reinterpret_cast<U*>(next_ + skipped);
    for (std::size_t i = 0; i < count; ++i) ::new (static_cast<void*>(first + i)) U();
    next_ += size;
    left_ -= size;
    return {first, count};
  }

 private:
  std::byte* next_;
  std::size_t left_;
};

// Store<U, fixed, each> holds fixed + each * n numbers of U for n particles.
struct Growing {
  template <class U, std::size_t fixed, std::size_t each>
  using Store = std::vector<U>;
  template <class U, std::size_t fixed, std::size_t each>
  constexpr std::vector<U> make() const {
    return {};
  }
};

template <int most>
struct RoomFor {
  static_assert(most > 0);
  template <class U, std::size_t fixed, std::size_t each>
  using Store = std::array<U, fixed + each * most>;
  template <class U, std::size_t fixed, std::size_t each>
  constexpr Store<U, fixed, each> make() const {
    return {};
  }
};

class Given {
 public:
  constexpr Given(Workspace& workspace, int most) : workspace_(&workspace), most_(most) {
    detail::require(most >= 0, "most", most, "must be 0 or more: a number of particles");
  }
  template <class U, std::size_t fixed, std::size_t each>
  using Store = std::span<U>;
  template <class U, std::size_t fixed, std::size_t each>
  constexpr std::span<U> make() const {
    return workspace_->take<U>(fixed + each * static_cast<std::size_t>(most_));
  }

 private:
  Workspace* workspace_;
  int most_;
};

namespace detail {

// to[0 .. count - 1] = from[0 .. count - 1]. A loop of its own: in device code, compiled by nvcc 13,
// std::copy of libstdc++ 12 was seen to copy nothing.
template <class T>
constexpr void copy_numbers(const T* from, int count, T* to) {
  for (int i = 0; i < count; ++i) to[i] = from[i];
}

// Makes sure that a store holds `count` numbers.
template <class Store>
constexpr void provide(Store& store, std::size_t count) {
  if constexpr (requires { store.resize(count); }) {
    if (store.size() < count) store.resize(count);
  } else {
    require(count <= store.size(), "numbers asked of the memory for one target", count,
            "must not exceed what RoomFor or Given provide: the target has too many particles");
  }
}

}  // namespace detail
}  // namespace recon
