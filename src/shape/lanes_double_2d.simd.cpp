#include "shape/lanes_kernel.hpp"

template recon::detail::LaneFunction<double> recon::RECON_SET::lane_function<double, 2>(int,
                                                                                        Solver);
