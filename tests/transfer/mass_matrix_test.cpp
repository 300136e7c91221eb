// The consistent mass matrix: its sums, its solutions, and the nodes that it does not determine.
#include "recon/transfer/mass_matrix.hpp"

#include <limits>

#include "support/space.hpp"

namespace recon::test {
namespace {

// Random particles of mass 1 + p / 10, many in each cell.
template <int D>
struct Matrix {
  CartesianGrid<D> grid = unit_grid<D>(3);
  std::vector<SpaceVector<D>> x;
  std::vector<double> mass, lumped = std::vector<double>(grid.size());
  Eigen::SparseMatrix<double> matrix;

  Matrix() {
    std::mt19937 random(1);
    MassEntries entries;
    LinearFunctions::Nodes<D> at;
    for (int p = 0; p < 400; ++p) {
      x.push_back(random_point<D>(random));
      mass.push_back(1 + 0.1 * p);
      LinearFunctions{}.at(grid, x.back(), at);
      add_mass(at, mass.back(), entries);
      at.add(lumped, mass.back());
    }
    matrix = mass_matrix(grid.size(), entries);
  }
};

template <class T>
class MassMatrices : public ::testing::Test {};
TYPED_TEST_SUITE(MassMatrices, AllDimensions);

// Row sums are the lumped masses, v M v twice the kinetic energy of the particles in the field v, and
// a solution gives its right side back.
TYPED_TEST(MassMatrices, AreThoseOfTheParticles) {
  constexpr int D = TypeParam::value;
  const Matrix<D> of;
  std::mt19937 random(2);
  const auto count = static_cast<Eigen::Index>(of.grid.size());
  Eigen::VectorXd v(count);
  for (double& each : v) each = uniform(random, -1, 1);
  const Eigen::VectorXd sums = of.matrix * Eigen::VectorXd::Ones(count);
  for (std::size_t i = 0; i < of.lumped.size(); ++i)
    EXPECT_NEAR(sums[static_cast<Eigen::Index>(i)], of.lumped[i], 1e-12 * of.lumped[i]);
  double twice_energy = 0;
  LinearFunctions::Nodes<D> at;
  for (std::size_t p = 0; p < of.x.size(); ++p) {
    LinearFunctions{}.at(of.grid, of.x[p], at);
    const double seen = at.value(v);
    twice_energy += of.mass[p] * seen * seen;
  }
  EXPECT_NEAR(v.dot(of.matrix * v), twice_energy, 1e-12 * twice_energy);
  MassSolver solver;
  EXPECT_FALSE(solver.factor(of.matrix, std::vector<bool>(of.grid.size(), true)));
  EXPECT_LE((solver.solve(of.matrix * v) - v).cwiseAbs().maxCoeff(), 1e-10);
}

// Nodes that are not free are 0, and the others solve the rows and columns that are left.
TYPED_TEST(MassMatrices, AreSolvedForFreeNodes) {
  constexpr int D = TypeParam::value;
  const Matrix<D> of;
  std::vector<bool> free(of.grid.size(), true);
  for (std::size_t i = 0; i < free.size(); i += 3) free[i] = false;
  const auto count = static_cast<Eigen::Index>(of.grid.size());
  MassSolver solver;
  ASSERT_FALSE(solver.factor(of.matrix, free));
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(count, 1, 2);
  const Eigen::VectorXd v = solver.solve(right), back = of.matrix * v;
  for (Eigen::Index i = 0; i < count; ++i) {
    const bool solved = free[static_cast<std::size_t>(i)];
    EXPECT_NEAR(solved ? back[i] - right[i] : v[i], 0, solved ? 1e-10 : 0);
  }
}

// One particle in a cell does not tell its two nodes apart.
TEST(MassMatrixErrors, NameTheNode) {
  const CartesianGrid<1> grid = unit_grid<1>(2);
  LinearFunctions::Nodes<1> at;
  MassEntries entries;
  LinearFunctions{}.at(grid, SpaceVector<1>(0.2), at);
  add_mass(at, 1, entries);
  const auto matrix = mass_matrix(grid.size(), entries);
  MassSolver solver;
  EXPECT_THROW(solver.solve(Eigen::VectorXd::Ones(3)), InvalidArgument);
  const auto node = solver.factor(matrix, {true, true, false});
  ASSERT_TRUE(node);
  EXPECT_LT(*node, 2u);
  EXPECT_THROW(solver.solve(Eigen::VectorXd::Ones(3)), InvalidArgument);  // nothing is left to use
  EXPECT_FALSE(solver.factor(matrix, {true, false, false}));
  EXPECT_NEAR(solver.solve(Eigen::VectorXd::Ones(3))[0], 1 / (0.6 * 0.6), 1e-12);
  EXPECT_THROW(solver.solve(Eigen::VectorXd::Ones(2)), InvalidArgument);
  EXPECT_THROW(solver.factor(matrix, {true}), InvalidArgument);
  EXPECT_THROW(mass_matrix(2, {{2, 0, 1.0}}), InvalidArgument);
  EXPECT_THROW(add_mass(at, std::numeric_limits<double>::quiet_NaN(), entries), InvalidArgument);
}

}  // namespace
}  // namespace recon::test
