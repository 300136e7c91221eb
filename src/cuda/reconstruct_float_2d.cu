#include "cuda/public.cuh"

RECON_CUDA_INSTANTIATE(2, float)
