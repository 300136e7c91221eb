// Must not compile: points with other coordinates than the grid has axes.
#include "recon/transfer/scatter.hpp"

#ifdef ARRAYS
using Point = std::array<double, 3>;
#else
using Point = Eigen::Vector3d;
#endif

void count(const std::vector<Point>& points, std::vector<double>& nodes) {
  const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, 0.5);
#ifdef ONE_POINT
  recon::NodeFunctions<2> at;
  recon::SplineFunctions<2>{}.at(grid, points[0], at);
  at.add(nodes, 1.0);
#else
  recon::scatter(
      grid, recon::LinearFunctions{}, points.size(), [&](std::size_t p) { return points[p]; },
      [&](std::size_t, const auto& at) { at.add(nodes, 1.0); });
#endif
}
