// Sums of any number of terms with a rounding error like that of a few hundred terms.
//
// Terms are added one after the other in blocks of sum_block. The sums of the blocks are then
// added with the rounding error of each addition carried along (Knuth 1969, sec. 4.2.2; Sum2 of
// Ogita, Rump and Oishi 2005). For any number of terms the error is that of one block's sum: a
// few roundings, about twenty where all terms are equal. A plain sum of a million floats loses
// three of their seven digits. Up to sum_block terms make one block, and the sum is the plain
// one to the bit.
//
// T is a number, or a pack (core/pack.hpp) with a sum in each lane.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "recon/core/unroll.hpp"

namespace recon::detail {

inline constexpr int sum_block = 256;

// Does total += term, and adds the rounding error of that addition to `lost`.
template <class T>
RECON_INLINE constexpr void add_keeping_rounding(const T& term, T& total, T& lost) {
  const T sum = total + term;
  const T added = sum - total;
  lost += (total - (sum - added)) + (term - added);
  total = sum;
}

// The sum of more than one block. It is a function of its own so that sums of one block
// stay a short loop.
template <int N, class T, class Index, class Add>
[[gnu::noinline]] constexpr void add_many_blocks(Index count, T* sums, const Add& add) {
  T lost[N], part[N];
  for (int i = 0; i < N; ++i) lost[i] = T(0);
  for (int i = 0; i < N; ++i) part[i] = sums[i];
  for (Index begin = 0; begin < count; begin += Index(sum_block)) {
    const Index end = count - begin > Index(sum_block) ? begin + Index(sum_block) : count;
    add(begin, end, part);
    if (begin == 0)
      for (int i = 0; i < N; ++i) sums[i] = part[i];
    else
      for (int i = 0; i < N; ++i) add_keeping_rounding(part[i], sums[i], lost[i]);
    for (int i = 0; i < N; ++i) part[i] = T(0);
  }
  for (int i = 0; i < N; ++i) sums[i] += lost[i];
}

// Adds the terms 0 <= p < count to the N sums. add(begin, end, part) adds the terms begin <= p <
// end to part[0 .. N - 1].
template <int N, class T, class Index, class Add>
RECON_INLINE constexpr void add_in_blocks(Index count, T* sums, const Add& add) {
  if (count <= Index(sum_block)) [[likely]] {
    add(Index(0), count, sums);
    return;
  }
  T total[N];  // a copy: passing `sums` itself on would keep the sums above out of registers
  for (int i = 0; i < N; ++i) total[i] = sums[i];
  add_many_blocks<N>(count, total, add);
  for (int i = 0; i < N; ++i) sums[i] = total[i];
}

// The sum of term(p) over 0 <= p < count.
template <class T, class Index, class Term>
RECON_INLINE constexpr T sum_of(Index count, const Term& term) {
  T sum = T(0);
  add_in_blocks<1>(count, &sum, [&](Index begin, Index end, T* part) RECON_INLINE_LAMBDA {
    for (Index p = begin; p < end; ++p) part[0] += term(p);
  });
  return sum;
}

// The sum of a(p) b(p), for cases in which the plain sum overflows on its way: the factors are
// first scaled to the order of one. It is not finite only if the result itself is too large or a
// factor is not finite.
template <class T, class Index, class A, class B>
T scaled_sum_of_products(Index count, const A& a, const B& b) {
  T largest_a = T(0), largest_b = T(0);
  for (Index p = 0; p < count; ++p) {
    if (!std::isfinite(a(p)) || !std::isfinite(b(p))) return std::numeric_limits<T>::quiet_NaN();
    if (std::abs(a(p)) > largest_a) largest_a = std::abs(a(p));
    if (std::abs(b(p)) > largest_b) largest_b = std::abs(b(p));
  }
  if (largest_a == T(0) || largest_b == T(0)) return T(0);
  const int power_a = 1 + std::ilogb(largest_a), power_b = 1 + std::ilogb(largest_b);
  const T sum = sum_of<T>(
      count, [&](Index p) { return std::ldexp(a(p), -power_a) * std::ldexp(b(p), -power_b); });
  return std::ldexp(sum, power_a + power_b);
}

}  // namespace recon::detail
