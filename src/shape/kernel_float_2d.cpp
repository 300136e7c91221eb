#include "shape/kernel.hpp"

template std::unique_ptr<recon::ShapeKernel<float>> recon::detail::make_kernel<float, 2>(
    const ShapeChoice&);
