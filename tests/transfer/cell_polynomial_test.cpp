// Polynomials of cells: what they reproduce, and what they keep.
#include "recon/transfer/cell_polynomial.hpp"

#include <limits>

#include "support/space.hpp"

namespace recon::test {
namespace {

template <class T>
class CellPolynomials : public ::testing::Test {};
TYPED_TEST_SUITE(CellPolynomials, AllDimensions);

constexpr std::size_t cell_of_test = 1;

template <int D>
std::vector<SpaceVector<D>> places_in(const CartesianGrid<D>& grid, int count) {
  std::mt19937 random(3);
  std::vector<SpaceVector<D>> places;
  for (int p = 0; p < count; ++p)
    places.push_back(cell_corner(grid, cell_of_test) + grid.h() * random_point<D>(random));
  return places;
}

// A polynomial of degree 2 without a constant of its own in either way: with as many points as
// determine it, it comes back; its mean over the cell is what is conserved.
TYPED_TEST(CellPolynomials, ReproduceQuadraticsOfTheirMean) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  const auto u = [](const SpaceVector<D>& x) {
    double value = 1.5;
    for (int d = 0; d < D; ++d) {
      value += (d + 1) * x[d] - x[d] * x[d];
      for (int e = 0; e < d; ++e) value += 2 * x[d] * x[e];
    }
    return value;
  };
  const auto places = places_in(grid, 12);
  Eigen::MatrixXd data(12, 2);
  for (int p = 0; p < 12; ++p) data.row(p).setConstant(u(places[p]));
  const CellPoints<D> points(grid, 2);
  double mean = 0;
  for (std::size_t g = 0; g < points.per_cell(); ++g)
    mean += u(points.at(cell_of_test, g)) / static_cast<double>(points.per_cell());
  CellPolynomial<D> in_cell;
  in_cell.fit(grid, cell_of_test, places, data, Eigen::RowVectorXd::Constant(2, mean),
              {true, false});
  for (const SpaceVector<D>& x : places) {
    EXPECT_NEAR(in_cell(x)[0], u(x), 1e-12);
    EXPECT_NEAR(in_cell(x)[1], u(x), 1e-12);
  }
}

// Whatever the data, the integral of a conserved column is the given one; the others do not see
// the mean.
TYPED_TEST(CellPolynomials, KeepTheMean) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  const CellPoints<D> points(grid, 2);
  std::mt19937 random(5);
  for (const int count : {1, 2, D + 1, D + 2, 12}) {
    const auto places = places_in(grid, count);
    Eigen::MatrixXd data(count, 2);
    for (int p = 0; p < count; ++p) data.row(p).setConstant(uniform(random, -1, 1));
    CellPolynomial<D> a, b;
    a.fit(grid, cell_of_test, places, data, Eigen::RowVectorXd::Constant(2, 7), {true, false});
    b.fit(grid, cell_of_test, places, data, Eigen::RowVectorXd::Constant(2, -3), {true, false});
    double mean = 0;
    for (std::size_t g = 0; g < points.per_cell(); ++g) {
      const SpaceVector<D> x = points.at(cell_of_test, g);
      mean += a(x)[0] / static_cast<double>(points.per_cell());
      EXPECT_EQ(a(x)[1], b(x)[1]);
    }
    EXPECT_NEAR(mean, 7, 1e-11) << count;
    if (count <= D + 1) {  // too few for a slope
      EXPECT_EQ(a(places[0])[1], a(cell_corner(grid, cell_of_test))[1]);
    }
  }
}

TEST(CellPolynomialErrors, AreNamed) {
  const CartesianGrid<1> grid = unit_grid<1>(4);
  const std::vector<SpaceVector<1>> places{SpaceVector<1>(0.3)};
  const Eigen::MatrixXd u = Eigen::MatrixXd::Ones(1, 1);
  const Eigen::RowVectorXd mean = Eigen::RowVectorXd::Ones(1);
  CellPolynomial<1> in_cell;
  EXPECT_THROW(in_cell(places[0]), InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 4, places, u, mean, {true}), InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 1, {}, u, mean, {true}), InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 1, places, Eigen::MatrixXd::Ones(2, 1), mean, {true}),
               InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 1, places, u, Eigen::RowVectorXd::Ones(2), {true}),
               InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 1, places, u, mean, {}), InvalidArgument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(in_cell.fit(grid, 1, places, u * nan, mean, {true}), InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 1, places, u, mean * nan, {true}), InvalidArgument);
  EXPECT_THROW(in_cell.fit(grid, 1, std::vector{SpaceVector<1>(nan)}, u, mean, {true}),
               InvalidArgument);
}

}  // namespace
}  // namespace recon::test
