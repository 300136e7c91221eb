#include "recon/core/array.hpp"

#include <cstdlib>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace recon::detail {

namespace {
constexpr std::size_t large_page = std::size_t{2} << 20;
}

void* allocate_large(std::size_t bytes) {
  if (bytes > static_cast<std::size_t>(-1) - large_page) throw std::bad_alloc();
  const std::size_t whole = (bytes + large_page - 1) / large_page * large_page;
  void* memory = std::aligned_alloc(large_page, whole);
  if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  madvise(memory, whole, MADV_HUGEPAGE);  // a wish: nothing is lost where it is not granted
#endif
  return memory;
}

void deallocate_large(void* memory) noexcept {
  std::free(memory);
}

}  // namespace recon::detail
