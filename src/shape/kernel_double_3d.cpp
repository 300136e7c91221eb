#include "shape/kernel.hpp"

template std::unique_ptr<recon::ShapeKernel<double>> recon::detail::make_kernel<double, 3>(
    const ShapeChoice&);
