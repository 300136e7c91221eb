#include "grid/row_kernel_impl.hpp"

template recon::RowKernel<double> recon::RECON_SET::row_kernel<double>(int, int);
