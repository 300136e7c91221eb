#include "recon/core/parallel.hpp"

#include <algorithm>
#include <exception>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace recon {

int default_threads() {
#ifdef _OPENMP
  return std::max(1, omp_get_max_threads());
#else
  return 1;
#endif
}

namespace detail {

void parallel_blocks(std::size_t count, std::size_t block, int threads, void* context,
                     void (*body)(void*, std::size_t, std::size_t)) {
  block = std::max<std::size_t>(1, block);
  const std::size_t blocks = (count + block - 1) / block;
  if (threads <= 0) threads = default_threads();
  threads = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads), blocks));

  std::exception_ptr error;
  std::size_t error_block = blocks;
  const auto run = [&](std::size_t b) {
    try {
      body(context, b * block, std::min(count, (b + 1) * block));
    } catch (...) {
#ifdef _OPENMP
#pragma omp critical(recon_parallel_error)
#endif
      if (b < error_block) {
        error_block = b;
        error = std::current_exception();
      }
    }
  };

#ifdef _OPENMP
  if (threads > 1) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (std::ptrdiff_t b = 0; b < static_cast<std::ptrdiff_t>(blocks); ++b)
      run(static_cast<std::size_t>(b));
  } else
#endif
    for (std::size_t b = 0; b < blocks; ++b) run(b);

  if (error) std::rethrow_exception(error);
}

}  // namespace detail
}  // namespace recon
