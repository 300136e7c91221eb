#include "shape/lanes_kernel.hpp"

template recon::detail::LaneFunction<float> recon::RECON_SET::lane_function<float, 3>(int, Solver);
