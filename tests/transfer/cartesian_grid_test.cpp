// The grid: which cell a point belongs to, numbers and places, and what it refuses.
#include "recon/transfer/cartesian_grid.hpp"

#include <cmath>
#include <limits>

#include "support/message_of.hpp"
#include "support/space.hpp"

namespace recon::test {
namespace {

TEST(GridCells, EdgesBelongToOneCell) {
  const CartesianGrid<1> grid(SpaceVector<1>(0), SpaceVector<1>(1), 0.25);
  EXPECT_EQ(grid.cell(0, 0), 0);
  EXPECT_EQ(grid.cell(-1e-18, 0), 0);
  EXPECT_EQ(grid.cell(0.25, 0), 1);
  EXPECT_EQ(grid.cell(1, 0), 3);
  EXPECT_EQ(grid.cell(1 + 1e-15, 0), 3);
  EXPECT_EQ(grid.cell(-1e300, 0), 0);
  EXPECT_EQ(grid.cell(1e300, 0), 3);
  EXPECT_TRUE(grid.contains(SpaceVector<1>(1 + 1e-15)));
  EXPECT_FALSE(grid.contains(SpaceVector<1>(1.1)));
  EXPECT_FALSE(grid.contains(SpaceVector<1>(std::nan(""))));
}

// Numbers, indices and places are those of StructuredGrid, for nodes and for centres of cells.
TEST(GridCells, AreNumberedAsStructuredGridsAre) {
  const CartesianGrid<3> grid({-1, 0, 2}, {0, 1, 2.5}, 0.25);
  EXPECT_EQ(grid.size(), 5u * 5 * 3);
  EXPECT_EQ(grid.cell_count(), 4u * 4 * 2);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const auto index = grid.nodes().index(i);
    EXPECT_EQ(grid.number({static_cast<int>(index[0]), static_cast<int>(index[1]),
                           static_cast<int>(index[2])}),
              i);
    for (int d = 0; d < 3; ++d)
      EXPECT_DOUBLE_EQ(grid.position(i)[d], grid.nodes().coordinate(index[d], d));
  }
  std::size_t number = 0;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        EXPECT_EQ(grid.cell_number(std::array{-1 + 0.25 * i + 0.1, 0.25 * j, 2.24 + 0.25 * k}),
                  number++);
}

TEST(GridErrors, NameArgumentValueAndRule) {
  using recon::testing::message_of;
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const auto made = [](double upper, double h) {
    return message_of([&] { CartesianGrid<2>({0, 0}, {1, upper}, h); });
  };
  EXPECT_EQ(made(1, 0), "grid spacing = 0: must be positive and finite");
  EXPECT_EQ(made(1, nan), "grid spacing = nan: must be positive and finite");
  EXPECT_EQ(
      made(1.125, 0.25),
      "edge of the grid along y in cells = 4.5: must be a whole number of cells, at least one");
  for (const double upper : {0.0, -1.0, nan, infinity})
    EXPECT_NE(made(upper, 0.25).find("edge of the grid along y in cells"), std::string::npos)
        << upper;
  EXPECT_NE(message_of([&] {
              CartesianGrid<1>(SpaceVector<1>(0), SpaceVector<1>(1e10), 1);
            }).find("edge of the grid"),
            std::string::npos);
  const CartesianGrid<1> grid(SpaceVector<1>(0), SpaceVector<1>(1), 0.25);
  EXPECT_EQ(message_of([&] { grid.cell(nan, 0); }), "coordinate x = nan: must be finite");
  EXPECT_EQ(message_of([&] { grid.cell_number(std::array{infinity}); }),
            "coordinate x = inf: must be finite");
}

// Nodes that round to one place, at either end of the grid.
TEST(GridErrors, NeighbouringNodesHavePlacesOfTheirOwn) {
  using recon::testing::message_of;
  const double ulp = std::numeric_limits<double>::epsilon();
  EXPECT_EQ(
      message_of([&] { CartesianGrid<1>(SpaceVector<1>(8), SpaceVector<1>(8 + 16 * ulp), ulp); }),
      "grid spacing along x = 2.2204460492503131e-16: must be larger: from the origin 8 to "
      "8.0000000000000036 neighbouring nodes would have the same coordinate in double");
  const CartesianGrid<1> fine(SpaceVector<1>(1 - 64 * ulp), SpaceVector<1>(1), 2 * ulp);
  for (std::uint32_t i = 1; i < fine.size(); ++i)
    EXPECT_LT(fine.position(i - 1)[0], fine.position(i)[0]) << i;
}

// A grid that nothing has been assigned to has nothing, and says so.
TEST(GridErrors, AGridWithoutCellsIsNamed) {
  using recon::testing::message_of;
  const CartesianGrid<2> none;
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(none.cell_count(), 0u);
  EXPECT_FALSE(none.contains(SpaceVector<2>(0, 0)));
  const std::string rule = "grid = without cells: must be made with its box and its spacing";
  for (const double x : {0.0, 0.5, -1.0, std::nan("")}) {
    EXPECT_EQ(message_of([&] { none.cell(x, 1); }), rule);
    EXPECT_EQ(message_of([&] { none.cell_number(SpaceVector<2>(x, x)); }), rule);
  }
  EXPECT_NE(message_of([&] { none.nodes().validate(); }).find("grid nodes along x = 0"),
            std::string::npos)
      << message_of([&] { none.nodes().validate(); });
}

}  // namespace
}  // namespace recon::test
