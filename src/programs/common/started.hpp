// Whether mpirun, srun or their like have started several copies of this program, as the environment
// says.
#pragma once

namespace recon::program {

// How many there are, and which of them this one is.
struct Started {
  int copies = 1, rank = 0;
  bool by_launcher = false;
};

Started started();

// Ranks are as many as there are processors: each has one thread, unless it is said (0: it is not).
int threads_of_a_rank(int said);

}  // namespace recon::program
