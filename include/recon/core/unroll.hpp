// Loops that are written out where the code is compiled.
#pragma once

#include <type_traits>
#include <utility>

// Compilers leave some of the bodies as calls, and pass registers through memory: with clang 14 a
// moment matrix then takes four times as long.
#if defined(__GNUC__)
#define RECON_INLINE [[gnu::always_inline]] inline
#define RECON_INLINE_LAMBDA __attribute__((always_inline))
#else
#define RECON_INLINE inline
#define RECON_INLINE_LAMBDA
#endif

namespace recon::detail {

template <class Body, int... i>
RECON_INLINE constexpr void unroll(Body& body, std::integer_sequence<int, i...>) {
  (body(std::integral_constant<int, i>{}), ...);
}

// Calls body(std::integral_constant<int, i>) for i = 0 .. N - 1, so that the compiler knows what
// tables say about each i. The body is a lambda marked RECON_INLINE_LAMBDA.
template <int N, class Body>
RECON_INLINE constexpr void unroll(Body&& body) {
  unroll(body, std::make_integer_sequence<int, N>{});
}

}  // namespace recon::detail
