#include "recon/core/array.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace recon::detail {

namespace {
constexpr std::size_t large_page = std::size_t{2} << 20;
}

// By operator new, so that a program that replaces it sees these allocations, too.
void* allocate_large(std::size_t bytes) {
  if (bytes > static_cast<std::size_t>(-1) - large_page) throw std::bad_alloc();
  const std::size_t whole = (bytes + large_page - 1) / large_page * large_page;
  void* memory = ::operator new (whole, std::align_val_t{large_page});
#ifdef MADV_HUGEPAGE
  madvise(memory, whole, MADV_HUGEPAGE);  // a wish: nothing is lost where it is not granted
#endif
  return memory;
}

void deallocate_large(void* memory) noexcept {
  ::operator delete (memory, std::align_val_t{large_page});
}

}  // namespace recon::detail
