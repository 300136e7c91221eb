// Do sums over kernels add up? What a grid holds of a kernel sum, against what the particles have.
#pragma once

#include <optional>

#include "field_plan.hpp"
#include "particles.hpp"
#include "recon/fields/field_set.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon::program {

// Prints, for each kernel sum whose grid covers all particles, the sum over the nodes times the
// cell's volume beside the sum of the amounts; and a warning where the support is smaller than the
// spacing, so that the nodes miss what lies between them. (At the border of a grid that is not
// periodic the kernels reach out of it, and what they have there is not counted.)
void print_sums(const FieldPlan& plan, const Particles& particles,
                const StructuredGrid<double>& grid, const FieldSet& fields,
                std::optional<double> radius);

}  // namespace recon::program
