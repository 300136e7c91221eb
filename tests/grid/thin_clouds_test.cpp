// Slopes across thin sheets on grids: reported, not invented, with and without the particles.
#include "grid_support.hpp"

namespace recon::testing {
namespace {

TEST(GridThinClouds, NoSlopeAcrossASheet) {
  // Particles about the plane z = 0.25 of nodes; u = x + noise.
  StructuredGrid<double> grid;
  grid.dimension = 3;
  grid.origin = {0, 0, 0};
  grid.spacing = {0.25, 0.25, 0.25};
  grid.counts = {5, 5, 3};
  for (const double thickness : {1e-12, 1e-5, 5e-4}) {
    RandomNumbers random(5);
    PointList<double, 3> points;
    std::vector<double> u;
    for (int p = 0; p < 2000; ++p) {
      points.push_back(
          {random.uniform(), random.uniform(), 0.25 + thickness * random.uniform(-1, 1)});
      u.push_back(points.back()[0] + 1e-3 * random.uniform(-1, 1));
    }
    const Options options{.degree = 1, .neighbours = Radius{0.5}};
    const GridApply with_gradients{.gradients = Derivative::diffuse};
    const auto check = [&](const GridReconstruction& fit, const std::string& where) {
      for (std::size_t i = 0; i < grid.size(); ++i) {
        if (grid.index(i)[2] != 1) continue;
        const FitReport& report = fit.report()[i];
        const double x = grid.coordinate(grid.index(i)[0], 0);
        EXPECT_EQ(report.status, FitStatus::full) << where;
        EXPECT_EQ(report.gradient_rank, 2) << where;
        EXPECT_LT(report.gradient_amplification, 100) << where;
        EXPECT_NEAR(fit.values()(i, 0), x, 5e-3) << where;
        EXPECT_NEAR(fit.gradients()(i, 0), 1, 0.1) << where;
        EXPECT_NEAR(fit.gradients()(i, 1), 0, 0.1) << where;
        EXPECT_NEAR(fit.gradients()(i, 2), 0, 20 * thickness) << where;
      }
    };
    check(reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, with_gradients),
          "thickness " + std::to_string(thickness));
    // Without the particles only what the moments still know: the thickest of the three.
    if (thickness > 1e-4)
      check(GridMoments(points_of(points), {field_of(u)}, grid, options).solve(with_gradients),
            "from moments");
  }
}

}  // namespace
}  // namespace recon::testing
