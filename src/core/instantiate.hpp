// The scalars and dimensions that recon is compiled for, as lists for explicit instantiations.
#pragma once

// RECON_FLOAT(...): what is compiled for float (or long double), left out of a build for double alone (RECON_SINGLE_PRECISION=OFF).
#ifdef RECON_DOUBLE_ONLY
#define RECON_FLOAT(...)
#else
#define RECON_FLOAT(...) __VA_ARGS__
#endif

// INSTANTIATE(scalar, dimension)
#define RECON_FOR_EACH_SCALAR_AND_DIMENSION(INSTANTIATE)                            \
  RECON_FLOAT(INSTANTIATE(float, 1); INSTANTIATE(float, 2); INSTANTIATE(float, 3);) \
  INSTANTIATE(double, 1);                                                           \
  INSTANTIATE(double, 2);                                                           \
  INSTANTIATE(double, 3)
