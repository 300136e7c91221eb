#include "memory.hpp"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> counting{false};
std::atomic<std::ptrdiff_t> in_use{0}, most{0};

void* counted(void* memory) {
  if (!memory) throw std::bad_alloc();
  if (counting.load(std::memory_order_relaxed)) {
    const auto size = static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
    const std::ptrdiff_t now = in_use.fetch_add(size) + size;
    std::ptrdiff_t before = most.load();
    while (now > before && !most.compare_exchange_weak(before, now)) {
    }
  }
  return memory;
}

void release(void* memory) {
  if (memory && counting.load(std::memory_order_relaxed))
    in_use.fetch_sub(static_cast<std::ptrdiff_t>(malloc_usable_size(memory)));
  std::free(memory);
}

}  // namespace

// The forms for arrays and those that do not throw end in these.
void* operator new(std::size_t size) {
  return counted(std::malloc(std::max<std::size_t>(size, 1)));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto bytes = static_cast<std::size_t>(alignment);
  return counted(
      std::aligned_alloc(bytes, (std::max<std::size_t>(size, 1) + bytes - 1) / bytes * bytes));
}
void operator delete(void* memory) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  release(memory);
}

namespace recon_bench {

HeapUse heap_use(const std::function<void()>& run) {
  in_use = 0;
  most = 0;
  counting = true;
  run();
  counting = false;
  return {static_cast<std::size_t>(most.load()),
          static_cast<std::size_t>(std::max<std::ptrdiff_t>(in_use.load(), 0))};
}

}  // namespace recon_bench
