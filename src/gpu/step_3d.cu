#include "gpu/step.cuh"

RECON_GPU_INSTANTIATE(3)
