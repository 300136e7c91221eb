#include "shape/lanes_kernel.hpp"

template recon::detail::LaneFunctions<float> recon::RECON_SET::lane_functions<float, 1>(int,
                                                                                        Solver);
