// The fitted velocity maps: least squares at the nodes, by the library.
#pragma once

#include "recon/mpm/simulation.hpp"

namespace recon::mpm {

// Replaces nodes.mapped of the nodes with mass by the fit of the problem's method. Where no point
// lies in the support, the mass-weighted velocity is kept, and the node counted in nodes.unfitted.
template <int D>
void fit_velocity(const Problem<D>& problem, Nodes<D>& nodes);

extern template void fit_velocity(const Problem<1>&, Nodes<1>&);
extern template void fit_velocity(const Problem<2>&, Nodes<2>&);
extern template void fit_velocity(const Problem<3>&, Nodes<3>&);

}  // namespace recon::mpm
