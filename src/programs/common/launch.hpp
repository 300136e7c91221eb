// Whether mpirun or srun has started this program, as the environment says.
#pragma once

namespace recon::program {

// This process among those that were started together.
struct Launch {
  int rank = 0, size = 1;
};

// By the variables of Open MPI, MPICH and its kin (PMI), and srun (a step of Slurm).
Launch launched();

}  // namespace recon::program
