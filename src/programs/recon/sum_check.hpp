// Do sums over kernels add up? What a grid holds of a kernel sum, against what the particles have.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "field_plan.hpp"
#include "particles.hpp"
#include "recon/fields/field_set.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon::program {

// For a kernel sum: where the grid covers all particles, the sum over the nodes times the cell's
// volume beside the sum of the amounts. (At the border of a grid that is not periodic the kernels
// reach out of it, and what they have there is not counted.) Where the support is smaller than the
// spacing, the nodes miss what lies between them.
struct SumCheck {
  std::string name;
  std::optional<double> over_grid, of_particles;
  bool small_support = false;
};
std::vector<SumCheck> check_sums(const FieldPlan& plan, const Particles& particles,
                                 const StructuredGrid<double>& grid, const FieldSet& fields,
                                 std::optional<double> radius);

// The sums in lines, with a warning of small supports.
void print_sums(const std::vector<SumCheck>& checks, const StructuredGrid<double>& grid,
                std::optional<double> radius);

}  // namespace recon::program
