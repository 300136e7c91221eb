// Bytes of heap: a counting operator new (memory.cpp replaces the global one for the
// whole program).
#pragma once

#include <cstddef>
#include <functional>

namespace recon_bench {

struct HeapUse {
  std::size_t peak = 0;   // most bytes in use at once during the call, beyond those before it
  std::size_t after = 0;  // bytes still in use when it returns
};

// What `run` allocates with operator new (Eigen's matrices use malloc and are not seen). Counting
// costs time: nothing is timed meanwhile.
HeapUse heap_use(const std::function<void()>& run);

}  // namespace recon_bench
