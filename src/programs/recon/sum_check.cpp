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

double widest_spacing(const StructuredGrid<double>& grid) {
  double widest = 0;
  for (int d = 0; d < grid.dimension; ++d) widest = std::max(widest, grid.spacing[d]);
  return widest;
}

}  // namespace

std::vector<SumCheck> check_sums(const FieldPlan& plan, const Particles& particles,
                                 const StructuredGrid<double>& grid, const FieldSet& fields,
                                 std::optional<double> radius) {
  double cell = 1;
  for (int d = 0; d < grid.dimension; ++d) cell *= grid.spacing[d];
  const bool covers = covers_all(grid, particles);
  std::vector<SumCheck> checks;
  for (const PlannedField& planned : plan) {
    if (!planned.is_kernel_sum()) continue;
    SumCheck check{planned.name, {}, {}, radius && *radius < widest_spacing(grid)};
    if (covers) {
      double over_grid = 0, of_particles = 0;
      for (const double value : fields[planned.name].values) over_grid += value * cell;
      for (const double amount : planned.amounts) of_particles += amount;
      check.over_grid = over_grid;
      check.of_particles = of_particles;
    }
    checks.push_back(std::move(check));
  }
  return checks;
}

void print_sums(const std::vector<SumCheck>& checks, const StructuredGrid<double>& grid,
                std::optional<double> radius) {
  std::string_view heading = "sums";
  for (const SumCheck& check : checks) {
    if (check.over_grid) {
      print_line(heading, check.name + ": " + number(*check.over_grid) + " over the grid, " +
                              number(*check.of_particles) + " of the particles");
      heading = "";
    }
    if (!check.small_support) continue;
    print_line("warning", check.name + ": the support radius " + number(*radius) +
                              " is smaller than the spacing " + number(widest_spacing(grid)) +
                              " of the grid; nodes");
    print_line("", "miss or overrate what lies between them: take a radius of twice the spacing");
  }
}

}  // namespace recon::program
