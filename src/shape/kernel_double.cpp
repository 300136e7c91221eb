#include "shape/kernel.hpp"

template std::unique_ptr<recon::ShapeKernel<double>> recon::make_shape_kernel(int,
                                                                              const ShapeChoice&);
