#include "programs/common/launch.hpp"

#include <algorithm>
#include <cstdlib>

namespace recon::program {

Launch launched() {
  struct Names {
    const char *rank, *size;
  };
  constexpr Names known[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                             {"PMI_RANK", "PMI_SIZE"},
                             {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}};
  for (const Names& names : known) {
    const char* const rank = std::getenv(names.rank);
    const char* const size = std::getenv(names.size);
    if (rank != nullptr && size != nullptr)
      return {std::max(0, std::atoi(rank)), std::max(1, std::atoi(size))};
  }
  return {};
}

}  // namespace recon::program
