// Weights with which particles stand for cells: what they sum to, what they reproduce, and their
// transpose.
#include "recon/transfer/cell_weights.hpp"

#include <cmath>
#include <limits>

#include "support/space.hpp"

namespace recon::test {
namespace {

constexpr double rounding_of_weights = 1e-12;

// Particles that are not regular in [lower, 1]^D, about 3^D in a cell.
template <int D>
struct Filled {
  CartesianGrid<D> grid = unit_grid<D>(7);
  std::vector<SpaceVector<D>> places;
  std::vector<double> volumes;
  explicit Filled(double lower, double upper = 1) {
    std::mt19937 random(3);
    const double edge = grid.h() / 3;
    const int count = static_cast<int>(std::lround((upper - lower) / edge));
    const int all = static_cast<int>(std::lround(std::pow(count, D)));
    for (int i = 0; i < all; ++i) {
      SpaceVector<D> x;
      for (int d = 0, rest = i; d < D; ++d, rest /= count)
        x[d] = lower + (rest % count + uniform(random, 0.2, 0.8)) * edge;
      places.push_back(x);
      volumes.push_back(std::pow(edge, D) * uniform(random, 0.8, 1.2));
    }
  }
  CellWeights<D> weights(int degree) const {
    CellWeights<D> made;
    made.fill(grid, degree, places, volumes);
    return made;
  }
};

template <class T>
class CellWeightsOf : public ::testing::Test {};
TYPED_TEST_SUITE(CellWeightsOf, AllDimensions);

// In cells that are fitted sum_p W_cp u_p = V_c u(x_c) for linear u; they are those of which all
// neighbours hold particles, and there are some. In the others W_cp >= 0, and where a particle sees no
// fitted cell, sum_c W_cp = V_p: at walls too.
TYPED_TEST(CellWeightsOf, FitInsideAndSumAtBorders) {
  constexpr int D = TypeParam::value;
  for (const int degree : {1, 2})
    for (const double lower : {0.0, 2.0 / 7}) {
      const Filled<D> cloud(lower);
      const CellWeights<D> weights = cloud.weights(degree);
      const std::vector<double> fitted = weights.fitted();
      const auto& grid = cloud.grid;
      std::vector<double> volume(grid.cell_count());
      std::vector<SpaceVector<D>> place(grid.cell_count(), SpaceVector<D>::Zero());
      for (std::size_t p = 0; p < cloud.places.size(); ++p) {
        double sum = 0;
        bool none = true;
        weights.for_cells(grid, cloud.places[p], cloud.volumes[p],
                          [&](std::size_t c, double weight) {
                            if (fitted[c] == 0) {
                              EXPECT_GE(weight, 0);
                            }
                            none = none && fitted[c] == 0;
                            sum += weight;
                            volume[c] += weight;
                            place[c] += weight * cloud.places[p];
                          });
        if (none) {
          EXPECT_NEAR(sum, cloud.volumes[p], rounding_of_weights * cloud.volumes[p]);
        }
      }
      const double V = std::pow(grid.h(), D);
      for (std::size_t c = 0; c < grid.cell_count(); ++c) {
        const SpaceVector<D> centre = cell_corner(grid, c).array() + grid.h() / 2;
        const bool inside = centre.minCoeff() > lower + (lower > 0 ? grid.h() : 0);
        EXPECT_EQ(fitted[c], inside ? 1 : 0);
        if (!inside) continue;
        EXPECT_NEAR(volume[c], V, rounding_of_weights * V);
        EXPECT_LE((place[c] / V - centre).norm(), rounding_of_weights);
      }
    }
}

// What G and W_p make of the particles is what the cells give, and the way back its transpose; linear
// fields have their slope.
TYPED_TEST(CellWeightsOf, GradientsAreThoseOfTheCells) {
  constexpr int D = TypeParam::value;
  const auto check = [&](const auto& functions, int degree, double lower) {
    const Filled<D> cloud(lower, 6.0 / 7);
    const auto& grid = cloud.grid;
    const CellWeights<D> weights = cloud.weights(degree);
    std::mt19937 random(4);
    std::vector<SpaceVector<D>> v;
    for (std::size_t i = 0; i < grid.size(); ++i) v.push_back(random_point<D>(random, -1, 1));
    std::vector<SpaceMatrix<D>> cell_stress(grid.cell_count(), SpaceMatrix<D>::Zero());
    std::vector<SpaceVector<D>> force(grid.size(), SpaceVector<D>::Zero()), of_cells = force;
    double power = 0;
    typename std::decay_t<decltype(functions)>::template Nodes<D> at;
    for (std::size_t p = 0; p < cloud.places.size(); ++p) {
      const SpaceMatrix<D> stress = random_deformation<D>(random, 1);
      weights.for_cells(grid, cloud.places[p], cloud.volumes[p],
                        [&](std::size_t c, double weight) { cell_stress[c] += weight * stress; });
      functions.at(grid, cloud.places[p], at);
      const double volume = weights.gradients(grid, cloud.places[p], cloud.volumes[p], at);
      at.add_gradient(force, SpaceMatrix<D>(-volume * stress));
      power -= volume * stress.cwiseProduct(at.gradient(v)).sum();
      SpaceMatrix<D> slope = SpaceMatrix<D>::Zero();
      for (std::size_t k = 0; k < at.size(); ++k)
        slope += grid.position(at.node[k]) * at.G[k].transpose();
      EXPECT_LE((slope - SpaceMatrix<D>::Identity()).norm(), rounding_of_weights);
    }
    LinearFunctions::Nodes<D> linear;
    double of_nodes = 0;
    for (std::size_t c = 0; c < grid.cell_count(); ++c) {
      LinearFunctions{}.at(grid, SpaceVector<D>(cell_corner(grid, c).array() + grid.h() / 2),
                           linear);
      linear.add_gradient(of_cells, SpaceMatrix<D>(-cell_stress[c]));
    }
    for (std::size_t i = 0; i < grid.size(); ++i) {
      EXPECT_LE((force[i] - of_cells[i]).norm(), rounding_of_weights);
      of_nodes += of_cells[i].dot(v[i]);
    }
    EXPECT_NEAR(of_nodes, power, rounding_of_weights);
  };
  for (const double lower : {0.0, 2.0 / 7}) {
    check(CellFunctions<1>{}, 1, lower);
    check(CellFunctions<2>{}, 2, lower);
  }
}

// A sheet of particles has no slope across, and so no fit; a single particle neither.
TEST(CellWeightsOfFewPoints, AreSums) {
  const CartesianGrid<2> grid = unit_grid<2>(3);
  std::vector<SpaceVector<2>> places;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 3; ++j) places.push_back({(i + 0.5) / 9, (j + 0.5) / 3});
  const std::vector<double> volumes(places.size(), 1.0 / 27);
  CellWeights<2> weights;
  EXPECT_TRUE(weights.empty());
  weights.fill(grid, 1, places, volumes);
  EXPECT_FALSE(weights.empty());
  EXPECT_EQ(weights.fitted(), std::vector<double>(9, 0.0));
}

TEST(CellWeightsOfFewPoints, RefuseWhatIsWrong) {
  const CartesianGrid<2> grid = unit_grid<2>(3);
  const std::vector<SpaceVector<2>> places{{0.5, 0.5}}, bad{{0.5, std::nan("")}};
  const std::vector<double> volumes{1}, infinite{std::numeric_limits<double>::infinity()},
      two{1, 1};
  CellWeights<2> weights;
  EXPECT_THROW(weights.fill(grid, 3, places, volumes), InvalidArgument);
  EXPECT_THROW(weights.fill(grid, 2, places, two), InvalidArgument);
  EXPECT_THROW(weights.fill(grid, 2, bad, volumes), InvalidArgument);
  EXPECT_THROW(weights.fill(grid, 2, places, infinite), InvalidArgument);
  EXPECT_NO_THROW(weights.fill(grid, 2, places, volumes));
}

}  // namespace
}  // namespace recon::test
