#include "cuda/public.cuh"

RECON_CUDA_INSTANTIATE(3, double)
