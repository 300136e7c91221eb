// Parallel loops over blocks, with the same results for any number of threads.
//
// Work is cut into blocks whose borders depend on the count alone, never on the number of
// threads; a block writes only what is its own. OpenMP stays inside the compiled part, so that a
// consumer needs no compiler flag for it. An exception thrown in a block is rethrown after the
// loop. Of several, it is the one from the lowest block, so that messages do not depend on the
// number of threads.
//
// In programs with threads of their own. All functions of recon may be called from any number of
// threads at once, and const functions for one and the same object; an object that changes belongs
// to one thread. Calls that name no number of threads share those there are: where n threads of the
// program are in such calls at one time, recon works with at most n - 1 more than
// default_threads(). Within a parallel region of OpenMP such a call stays on its thread. A number
// that is named is kept. After fork(), loops of the child run on one thread, for OpenMP's do not
// live on.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace recon {

// The number of threads of parallel loops where a call does not say: OpenMP's default
// (OMP_NUM_THREADS or the number of processors); 1 within a parallel region of OpenMP, in a child
// of fork(), and where recon was built without OpenMP.
int default_threads();

namespace detail {

// Calls body(context, begin, end) for each block; `threads` <= 0 means default_threads().
void parallel_blocks(std::size_t count, std::size_t block, int threads, void* context,
                     void (*body)(void* context, std::size_t begin, std::size_t end));

}  // namespace detail

// Calls body(begin, end) for the half-open ranges [0, block), [block, 2 block), ... that cover
// [0, count). Blocks run concurrently and in no fixed order. threads <= 0: default_threads().
template <class Body>
void parallel_blocks(std::size_t count, std::size_t block, int threads, Body&& body) {
  using Plain = std::remove_reference_t<Body>;
  detail::parallel_blocks(count, block, threads,
                          const_cast<void*>(static_cast<const void*>(std::addressof(body))),
                          [](void* context, std::size_t begin, std::size_t end) {
                            (*static_cast<Plain*>(context))(begin, end);
                          });
}

}  // namespace recon
