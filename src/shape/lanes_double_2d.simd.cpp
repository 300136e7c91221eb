#include "shape/lanes_kernel.hpp"

template recon::detail::LaneFunctions<double> recon::RECON_SET::lane_functions<double, 2>(int,
                                                                                          Solver);
