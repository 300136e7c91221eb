// What is compiled by nvcc: steps on the GPU that is there.
#pragma once

#include "gpu/device_step.hpp"

namespace recon::mpm {

// Defined for 1, 2 and 3 dimensions (step.cuh).
template <int D>
std::unique_ptr<DeviceStep<D>> make_on_gpu(Plan<D>&& plan);
template <>
std::unique_ptr<DeviceStep<1>> make_on_gpu(Plan<1>&& plan);
template <>
std::unique_ptr<DeviceStep<2>> make_on_gpu(Plan<2>&& plan);
template <>
std::unique_ptr<DeviceStep<3>> make_on_gpu(Plan<3>&& plan);

}  // namespace recon::mpm
