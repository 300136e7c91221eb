// A std::vector for large results. New elements are not set to zero: they are written in full by
// the threads that compute them. Where the system has large pages the memory consists of them,
// because the first write to each small page can cost more than the computation.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace recon {

namespace detail {

constexpr std::size_t large_allocation = std::size_t{2} << 20;  // bytes; large pages from here on

// Throws std::bad_alloc.
void* allocate_large(std::size_t bytes);
void deallocate_large(void* memory) noexcept;

}  // namespace detail

template <class T>
struct ArrayAllocator {
  using value_type = T;

  ArrayAllocator() = default;
  template <class U>
  ArrayAllocator(const ArrayAllocator<U>&) {}

  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    const std::size_t bytes = n * sizeof(T);
    return static_cast<T*>(bytes < detail::large_allocation ? ::operator new(bytes)
                                                            : detail::allocate_large(bytes));
  }
  void deallocate(T* memory, std::size_t n) noexcept {
    if (n * sizeof(T) < detail::large_allocation)
      ::operator delete(memory);
    else
      detail::deallocate_large(memory);
  }

  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }

  friend bool operator==(const ArrayAllocator&, const ArrayAllocator&) { return true; }
};

template <class T>
using Array = std::vector<T, ArrayAllocator<T>>;

}  // namespace recon
