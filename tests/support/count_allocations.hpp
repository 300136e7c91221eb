// Counts what the whole test program allocates with operator new; for one file of a program.
// Sanitizers have an operator new of their own: RECON_COUNTS_ALLOCATIONS is 0 there.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RECON_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RECON_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef RECON_COUNTS_ALLOCATIONS
#define RECON_COUNTS_ALLOCATIONS 1
#endif

#if RECON_COUNTS_ALLOCATIONS
#include <malloc.h>

namespace recon::testing {

inline std::atomic<long> allocations{0}, bytes_in_use{0};

inline void* allocate(std::size_t size, std::size_t alignment) {
  ++allocations;
  size = (size + alignment - 1) / alignment * alignment;
  void* const memory = std::aligned_alloc(alignment, size == 0 ? alignment : size);
  if (memory == nullptr) throw std::bad_alloc();
  bytes_in_use += static_cast<long>(malloc_usable_size(memory));
  return memory;
}

// Not inlined: the compiler may see free() without the allocate() above, and warn of a mismatch.
[[gnu::noinline]] inline void release(void* memory) noexcept {
  if (memory != nullptr) bytes_in_use -= static_cast<long>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace recon::testing

void* operator new(std::size_t size) {
  return recon::testing::allocate(size, alignof(std::max_align_t));
}
void* operator new[](std::size_t size) {
  return recon::testing::allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return recon::testing::allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return recon::testing::allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  recon::testing::release(memory);
}
void operator delete[](void* memory) noexcept {
  recon::testing::release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  recon::testing::release(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  recon::testing::release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  recon::testing::release(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  recon::testing::release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  recon::testing::release(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  recon::testing::release(memory);
}

#endif
