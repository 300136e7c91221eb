// One value of many, in three steps whose shape depends on their number alone: sums have the same
// bits in every run.
#pragma once

#include <cstddef>

#include "cuda/device_code.hpp"

namespace recon::cuda {

// out[c] = join of of(c), of(c + chunks), ...
template <class Value, class Of, class Join>
struct FoldStep {
  Of of;
  Join join;
  std::size_t count, chunks;
  Value* out;

  RECON_DEVICE void operator()(std::size_t c) const {
    Value value = of(c);
    for (std::size_t i = c + chunks; i < count; i += chunks) value = join(value, of(i));
    out[c] = value;
  }
};

template <class Value>
struct ReadBack {
  const Value* values;
  RECON_DEVICE const Value& operator()(std::size_t i) const { return values[i]; }
};

// The join of of(i) for 0 <= i < count, count >= 1. Its address is in `scratch`.
template <class Value, class Executor, class Of, class Join>
const Value* fold(Executor& executor, typename Executor::template Array<Value>& scratch,
                  std::size_t count, const Of& of, const Join& join) {
  constexpr std::size_t many = 16384, few = 128;
  executor.provide(scratch, many + few + 1);
  Value *const first = scratch.data(), *const second = first + many, *const last = second + few;
  const std::size_t a = count < many ? count : many, b = a < few ? a : few;
  executor.for_each(a, FoldStep<Value, Of, Join>{of, join, count, a, first});
  using Again = FoldStep<Value, ReadBack<Value>, Join>;
  executor.for_each(b, Again{{first}, join, a, b, second});
  executor.for_each(1, Again{{second}, join, b, 1, last});
  return last;
}

}  // namespace recon::cuda
