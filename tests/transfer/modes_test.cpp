// The polynomials about a particle: orthogonal, in closed form where the sources have one, and the
// best approximation of nodal data.
#include "recon/transfer/modes.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "support/space.hpp"

namespace recon::test {
namespace {

constexpr double rounding = 1e-13;

template <class T>
class Modes : public ::testing::Test {};
TYPED_TEST_SUITE(Modes, AllDimensions);

template <int D, class Functions>
struct Around {
  typename Functions::template Nodes<D> at;
  PolynomialModes<D> modes;
  Around(const Functions& functions, const CartesianGrid<D>& grid, const SpaceVector<D>& x,
         ModeSet set) {
    functions.at(grid, x, at);
    modes.fill(grid, functions.axes(grid, x), x, set);
  }
};

// Calls work with all functions that are positive products.
template <class Work>
void with_products(const Work& work) {
  work(LinearFunctions{}, "linear");
  work(SplineFunctions<2>{}, "bspline2");
  work(SplineFunctions<3>{}, "bspline3");
  work(SplineFunctions<3>{{SplineBorder::linear_cells}}, "bspline3 with linear cells");
}

// sum_i S_i s_r s_q = 0 for r != q and norm_r for r = q, also with the constant, next to faces too;
// a norm of zero says that there is no such polynomial.
TYPED_TEST(Modes, AreOrthogonal) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(5);
  std::mt19937 random(1);
  with_products([&](const auto& functions, const char* name) {
    for (const ModeSet set : {ModeSet::affine, ModeSet::polynomial})
      for (int round = 0; round < 20; ++round) {
        const Around around(functions, grid, random_point<D>(random), set);
        const auto& [at, modes] = around;
        ASSERT_EQ(modes.count(), mode_count(set, D));
        for (int r = 0; r < modes.count(); ++r) {
          if (modes.norm(r) == 0) continue;
          double mean = 0;
          for (std::size_t n = 0; n < at.size(); ++n) mean += at.S[n] * modes.value(r, n);
          EXPECT_LE(std::abs(mean), rounding) << name;
          for (int q = 0; q <= r; ++q) {
            if (modes.norm(q) == 0) continue;
            double sum = 0;
            for (std::size_t n = 0; n < at.size(); ++n)
              sum += at.S[n] * modes.value(r, n) * modes.value(q, n);
            EXPECT_NEAR(sum, q == r ? modes.norm(r) : 0, rounding) << name << r << q;
          }
        }
      }
  });
}

// Inside the grid norm_1 is h^2 / 4 on quadratic and h^2 / 3 on cubic splines (Jiang et al. 2015),
// and s_2 = d^2 - kappa d - h^2 / 4 (Fu et al. 2017); linear functions have no s_2.
TEST(ModesOfSplines, AreThoseOfTheSources) {
  const CartesianGrid<1> grid(SpaceVector<1>(0), SpaceVector<1>(4), 0.5);
  const double h = 0.5;
  for (double x = 1.02; x < 3; x += 0.037) {
    const SpaceVector<1> place(x);
    const Around two(SplineFunctions<2>{}, grid, place, ModeSet::polynomial);
    const Around three(SplineFunctions<3>{}, grid, place, ModeSet::affine);
    EXPECT_NEAR(two.modes.norm(0), h * h / 4, rounding);
    EXPECT_NEAR(three.modes.norm(0), h * h / 3, rounding);
    const double z = x - h * std::round(x / h);
    const double kappa = z * (h * h - 4 * z * z) / (h * h);
    for (std::size_t n = 0; n < two.at.size(); ++n) {
      const double d = grid.position(two.at.node[n])[0] - x;
      EXPECT_NEAR(two.modes.value(0, n), d, rounding);
      EXPECT_NEAR(two.modes.value(1, n), d * d - kappa * d - h * h / 4, rounding);
    }
    const Around linear(LinearFunctions{}, grid, place, ModeSet::polynomial);
    EXPECT_EQ(linear.modes.norm(1), 0);
  }
}

// The slope of a linear field, and all nodal data where there are as many modes as nodes: three to
// an axis of quadratic splines. Numbers, arrays and vectors alike.
TYPED_TEST(Modes, ApproximateNodalData) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(5);
  std::mt19937 random(2);
  const SpaceVector<D> slope = random_point<D>(random, -1, 1);
  std::vector<double> linear(grid.size());
  std::vector<SpaceVector<D>> any;
  std::vector<std::array<double, D>> any_arrays(grid.size());
  for (std::size_t i = 0; i < grid.size(); ++i) {
    linear[i] = 3 + slope.dot(grid.position(i));
    any.push_back(random_point<D>(random, -1, 1));
    for (int d = 0; d < D; ++d) any_arrays[i][d] = any[i][d];
  }
  with_products([&](const auto& functions, const char* name) {
    for (const ModeSet set : {ModeSet::affine, ModeSet::polynomial}) {
      const Around around(functions, grid, random_point<D>(random, 0.01, 0.99), set);
      for (int d = 0; d < D; ++d)
        EXPECT_NEAR(around.modes.coefficient(linear_mode(set, d), around.at, linear), slope[d],
                    1000 * rounding)
            << name;
    }
  });
  for (int round = 0; round < 20; ++round) {
    const SpaceVector<D> x = random_point<D>(random, 0.11, 0.89);
    const Around around(SplineFunctions<2>{}, grid, x, ModeSet::polynomial);
    const auto& [at, modes] = around;
    std::vector<SpaceVector<D>> c, shown(at.size(), at.value(any));
    for (int r = 0; r < modes.count(); ++r) {
      c.push_back(modes.coefficient(r, at, any));
      const std::array<double, D> of_arrays = modes.coefficient(r, at, any_arrays);
      for (int d = 0; d < D; ++d) EXPECT_EQ(of_arrays[d], c[r][d]);
    }
    modes.add_to(shown, at.size(), c);
    for (std::size_t n = 0; n < at.size(); ++n)
      EXPECT_LE((shown[n] - any[at.node[n]]).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace recon::test
