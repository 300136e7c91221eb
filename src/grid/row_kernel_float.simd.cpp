#include "grid/row_kernel_impl.hpp"

template recon::RowKernel<float> recon::RECON_SET::row_kernel<float>(int, int);
