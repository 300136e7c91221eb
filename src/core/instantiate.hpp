// The scalars and dimensions that recon is compiled for, as a list for explicit instantiations.
#pragma once

// INSTANTIATE(scalar, dimension)
#define RECON_FOR_EACH_SCALAR_AND_DIMENSION(INSTANTIATE) \
  INSTANTIATE(float, 1);                                 \
  INSTANTIATE(float, 2);                                 \
  INSTANTIATE(float, 3);                                 \
  INSTANTIATE(double, 1);                                \
  INSTANTIATE(double, 2);                                \
  INSTANTIATE(double, 3)
