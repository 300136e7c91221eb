#include "programs/common/started.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>

namespace recon::program {
namespace {

// A whole number of the environment; -1 where there is none.
int number_in_environment(const char* name) {
  const char* text = std::getenv(name);
  int number = -1;
  if (text == nullptr) return number;
  const char* end = text + std::strlen(text);
  const auto read = std::from_chars(text, end, number);
  return read.ec == std::errc() && read.ptr == end ? number : -1;
}

}  // namespace

Started started() {
  struct Names {
    const char *copies, *rank;
  };
  // OpenMPI; MPICH, Intel and what else has its PMI; MVAPICH.
  for (const Names& names :
       {Names{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"}, Names{"PMI_SIZE", "PMI_RANK"},
        Names{"MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"}})
    if (const int copies = number_in_environment(names.copies); copies > 0)
      return {copies, std::max(number_in_environment(names.rank), 0), true};
  // A step of Slurm; one of a single task may be a shell, too.
  if (const int copies = number_in_environment("SLURM_STEP_NUM_TASKS"); copies > 1)
    return {copies, std::max(number_in_environment("SLURM_PROCID"), 0), true};
  return {};
}

int threads_of_a_rank(int said) {
  return said == 0 && std::getenv("OMP_NUM_THREADS") == nullptr ? 1 : said;
}

}  // namespace recon::program
