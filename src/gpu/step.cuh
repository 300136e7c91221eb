// The step on a GPU; each dimension is compiled in a file of its own.
#pragma once

// Eigen is included, and is for the processor alone: nvcc 13 does not like its marks for nvcc.
#define EIGEN_NO_CUDA

#include "cuda/device.cuh"
#include "gpu/on_gpu.hpp"
#include "gpu/step_on.hpp"

// In a file of its own for each.
#define RECON_GPU_INSTANTIATE(D)                                                        \
  namespace recon::mpm {                                                                \
  template <>                                                                           \
  std::unique_ptr<DeviceStep<D>> make_on_gpu(Plan<D>&& plan) {                          \
    return std::make_unique<StepOn<cuda::Device, D>>(                                   \
        std::make_shared<cuda::Device>(cuda::Stream()), std::move(plan));               \
  }                                                                                     \
  }
