// How far a long call has come, and a way to end it.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stdexcept>
#include <type_traits>

namespace recon {

// Called with the fraction of the work that is done, from 0 to 1 and never less than before. false
// ends the call, which then throws Cancelled. The threads of the call call it, one at a time, at
// most ten times per second, and never after the call has returned; a call that takes less than a
// tenth of a second does not call it at all. What it throws passes through the call. Results do not
// depend on it.
using Progress = std::function<bool(double fraction)>;

// Thrown by a call whose Progress has returned false.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled by the caller's progress function") {}
};

namespace detail {

// The Progress of a part of the work, from one fraction of the whole to another; empty for an
// empty one.
Progress part_of(const Progress& whole, double from, double to);

void parallel_blocks(std::size_t count, std::size_t block, int threads, const Progress& progress,
                     void* context,
                     void (*body)(void* context, std::size_t begin, std::size_t end));

}  // namespace detail

// parallel_blocks (parallel.hpp) with a Progress, which may be empty. When it has said no, blocks
// that have not begun are left out.
template <class Body>
void parallel_blocks(std::size_t count, std::size_t block, int threads, const Progress& progress,
                     Body&& body) {
  using Plain = std::remove_reference_t<Body>;
  detail::parallel_blocks(count, block, threads, progress,
                          const_cast<void*>(static_cast<const void*>(std::addressof(body))),
                          [](void* context, std::size_t begin, std::size_t end) {
                            (*static_cast<Plain*>(context))(begin, end);
                          });
}

}  // namespace recon
