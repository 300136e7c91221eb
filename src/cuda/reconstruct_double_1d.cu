#include "cuda/public.cuh"

RECON_CUDA_INSTANTIATE(1, double)
