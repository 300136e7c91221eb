// A std::vector whose new elements are not set to zero: for large results that are written in full,
// by the threads that compute them.
#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace recon {

template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitialisedAllocator<U>;
  };
  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
};

template <class T>
using Array = std::vector<T, UninitialisedAllocator<T>>;

}  // namespace recon
