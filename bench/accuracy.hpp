// The accuracy and cost studies: MLS or IMLS, which degree, which weight, how many neighbours, at
// what price. Sections of the report, in the order in which a user asks.
//
// Every case is checked before it counts or is timed: partition of unity and reproduction of all
// polynomials up to the reported degree, to rounding. A case that fails throws std::runtime_error.
#pragma once

#include <vector>

#include "context.hpp"

namespace recon_bench {

std::vector<Section> run_accuracy(const Context& context);

// The parts of it, one file each.
Section solver_study(const Context& context);      // cost and error by solver, degree, dimension
Section cloud_study(const Context& context);       // good and bad clouds
Section neighbour_study(const Context& context);   // how many neighbours
Section weight_study(const Context& context);      // which weight, how wide
Section order_study(const Context& context);       // orders of convergence
Section precision_study(const Context& context);   // float or double
Section flattening_study(const Context& context);  // clouds that approach a plane
Section tran_field_study(const Context& context);  // Tran et al. (2019), figures 4 and 5
Section tran_cost_study(const Context& context);   // Tran et al. (2019), figure 6
Section outside_study(const Context& context);     // values outside the range of the data

}  // namespace recon_bench
