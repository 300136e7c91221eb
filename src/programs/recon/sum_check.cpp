#include "sum_check.hpp"

#include <algorithm>
#include <cmath>

#include "programs/common/text.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

bool covers_all(const StructuredGrid<double>& grid, const Particles& particles) {
  for (int d = 0; d < grid.dimension; ++d) {
    if (particles.grid_domain.periodic[d]) continue;
    const double last = grid.coordinate(grid.counts[d] - 1, d);
    if (particles.domain.periodic[d] || grid.origin[d] > particles.extent.lower[d] ||
        last < particles.extent.upper[d])
      return false;
  }
  return true;
}

}  // namespace

void print_sums(const FieldPlan& plan, const Particles& particles,
                const StructuredGrid<double>& grid, const FieldSet& fields,
                std::optional<double> radius) {
  double cell = 1, widest = 0;
  for (int d = 0; d < grid.dimension; ++d) {
    cell *= grid.spacing[d];
    widest = std::max(widest, grid.spacing[d]);
  }
  std::string_view heading = "sums";
  for (const PlannedField& planned : plan) {
    if (!planned.is_kernel_sum()) continue;
    if (covers_all(grid, particles)) {
      double over_grid = 0, of_particles = 0;
      for (const double value : fields[planned.name].values) over_grid += value * cell;
      for (const double amount : planned.amounts) of_particles += amount;
      print_line(heading, planned.name + ": " + number(over_grid) + " over the grid, " +
                              number(of_particles) + " of the particles");
      heading = "";
    }
    if (!radius || *radius >= widest) continue;
    print_line("warning", planned.name + ": the support radius " + number(*radius) +
                              " is smaller than the spacing " + number(widest) +
                              " of the grid; nodes");
    print_line("", "miss or overrate what lies between them: take a radius of twice the spacing");
  }
}

}  // namespace recon::program
