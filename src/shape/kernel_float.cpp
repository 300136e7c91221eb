#include "shape/kernel.hpp"

template std::unique_ptr<recon::ShapeKernel<float>> recon::make_shape_kernel(int,
                                                                             const ShapeChoice&);
