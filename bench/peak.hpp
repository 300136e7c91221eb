// What the machine can do at most: fused multiply-adds per second, and bytes per second from
// memory. Compiled for the native machine, like the hand-written loop.
#pragma once

#include <cstddef>

namespace recon_bench {

// Floating-point operations per second (a fused multiply-add counts as two), all threads together,
// on many independent accumulators of the widest vectors that the compiler knows for this machine.
template <class Scalar>
double measured_flops(int threads);

// Bytes per second, all threads together, over arrays of `bytes` each.
double measured_read_bandwidth(std::size_t bytes, int threads);   // sum of one array
double measured_triad_bandwidth(std::size_t bytes, int threads);  // a = b + s c: 3 arrays

// Bytes of a vector register, as the compiler was told.
int native_vector_bytes();

}  // namespace recon_bench
