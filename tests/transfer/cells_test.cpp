// Cells of a grid: their numbers, Gauss points, sums and neighbours.
#include "recon/transfer/cells.hpp"

#include <limits>

#include "support/space.hpp"

namespace recon::test {
namespace {

template <class T>
class Cells : public ::testing::Test {};
TYPED_TEST_SUITE(Cells, AllDimensions);

// Numbers and indices are those of cell_number(), and the corner is the least point of the cell.
TYPED_TEST(Cells, HaveTheNumbersOfTheGrid) {
  constexpr int D = TypeParam::value;
  SpaceVector<D> upper;
  for (int d = 0; d < D; ++d) upper[d] = d + 1;
  const CartesianGrid<D> grid(SpaceVector<D>::Zero(), upper, 0.25);
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    const SpaceVector<D> corner = cell_corner(grid, c);
    const SpaceVector<D> middle = corner.array() + 0.125;
    EXPECT_EQ(grid.cell_number(middle), c);
    const std::array<int, D> index = cell_index(grid, c);
    for (int d = 0; d < D; ++d) {
      EXPECT_EQ(index[d], grid.cell(middle[d], d));
      EXPECT_EQ(corner[d], grid.node(index[d], d));
    }
  }
}

// One point is exact for products of linear functions of the axes, two an axis for cubics.
TYPED_TEST(Cells, PointsIntegrateProducts) {
  constexpr int D = TypeParam::value;
  const double h = 0.5;
  const CartesianGrid<D> grid(SpaceVector<D>::Constant(-1), SpaceVector<D>::Constant(1), h);
  for (const int per_axis : {1, 2}) {
    const CellPoints<D> points(grid, per_axis);
    const int degree = 2 * per_axis - 1;
    for (std::size_t c = 0; c < grid.cell_count(); ++c)
      for (int power = 0; power <= degree; ++power) {
        double sum = 0, exact = 1;
        for (std::size_t g = 0; g < points.per_cell(); ++g)
          sum += points.volume() * points.at(c, g).array().pow(power).prod();
        const SpaceVector<D> corner = cell_corner(grid, c);
        for (int d = 0; d < D; ++d)
          exact *=
              (std::pow(corner[d] + h, power + 1) - std::pow(corner[d], power + 1)) / (power + 1);
        EXPECT_NEAR(sum, exact, 1e-15) << per_axis << " " << power;
      }
  }
  EXPECT_THROW(CellPoints<D>(grid, 3), InvalidArgument);
  EXPECT_THROW(CellPoints<D>(CartesianGrid<D>(), 1), InvalidArgument);
}

// Of a filled block all cells but those at its border are inside; beyond a face of the grid there
// is nothing that could be empty.
TYPED_TEST(Cells, InsideIsWhatHasFilledNeighbours) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(6);
  std::vector<SpaceVector<D>> places;  // cells 0 to 3 of each axis
  std::vector<double> amounts;
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    const std::array<int, D> index = cell_index(grid, c);
    if (*std::max_element(index.begin(), index.end()) > 3) continue;
    for (int twice = 0; twice < 2; ++twice) {
      places.push_back(cell_corner(grid, c).array() + 0.05 + 0.05 * twice);
      amounts.push_back(1 + twice);
    }
  }
  const auto sums = sums_in_cells(grid, places, [&](std::size_t p) { return amounts[p]; });
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    const std::array<int, D> index = cell_index(grid, c);
    const int most = *std::max_element(index.begin(), index.end());
    EXPECT_EQ(sums[c], most > 3 ? 0 : 3);
    EXPECT_EQ(is_inside(grid, sums, c), most < 3) << c;
  }
  // A hole makes all its neighbours, also those by a corner, cells of the border.
  std::vector<double> all(grid.cell_count(), 1);
  const SpaceVector<D> in_hole = SpaceVector<D>::Constant(0.45);
  all[grid.cell_number(in_hole)] = 0;
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    const std::array<int, D> index = cell_index(grid, c);
    int farthest = 0;
    for (int d = 0; d < D; ++d) farthest = std::max(farthest, std::abs(index[d] - 2));
    EXPECT_EQ(is_inside(grid, all, c), farthest > 1);
  }
}

TEST(CellErrors, AreNamed) {
  const CartesianGrid<2> grid = unit_grid<2>(4);
  EXPECT_THROW(is_inside(grid, std::vector<double>(15), 0), InvalidArgument);
  EXPECT_THROW(is_inside(grid, std::vector<double>(16), 16), InvalidArgument);
  const std::vector<SpaceVector<2>> bad{{std::numeric_limits<double>::quiet_NaN(), 0}};
  EXPECT_THROW(sums_in_cells(grid, bad, [](std::size_t) { return 1.0; }), InvalidArgument);
}

}  // namespace
}  // namespace recon::test
