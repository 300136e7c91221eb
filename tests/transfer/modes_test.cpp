// The polynomials about a particle: orthogonal, in closed form where the sources have one, and the
// best approximation of nodal data.
#include "recon/transfer/modes.hpp"

#include <Eigen/Dense>
#include <bit>
#include <cmath>

#include "recon/transfer/domain_functions.hpp"
#include "support/space.hpp"

namespace recon::test {
namespace {

constexpr double rounding_of_modes = 1e-13;

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
          EXPECT_LE(std::abs(mean), rounding_of_modes) << name;
          for (int q = 0; q <= r; ++q) {
            if (modes.norm(q) == 0) continue;
            double sum = 0;
            for (std::size_t n = 0; n < at.size(); ++n)
              sum += at.S[n] * modes.value(r, n) * modes.value(q, n);
            EXPECT_NEAR(sum, q == r ? modes.norm(r) : 0, rounding_of_modes) << name << r << q;
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
    EXPECT_NEAR(two.modes.norm(0), h * h / 4, rounding_of_modes);
    EXPECT_NEAR(three.modes.norm(0), h * h / 3, rounding_of_modes);
    const double z = x - h * std::round(x / h);
    const double kappa = z * (h * h - 4 * z * z) / (h * h);
    for (std::size_t n = 0; n < two.at.size(); ++n) {
      const double d = grid.position(two.at.node[n])[0] - x;
      EXPECT_NEAR(two.modes.value(0, n), d, rounding_of_modes);
      EXPECT_NEAR(two.modes.value(1, n), d * d - kappa * d - h * h / 4, rounding_of_modes);
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
                    1000 * rounding_of_modes)
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

// Over boxes and parallelepipeds a linear field has its slope as coefficients, and the particle shows
// it to every node; the moment is the sum that it stands for, of products as well.
TYPED_TEST(Modes, OfDomainsKeepLinearFields) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(5);
  std::mt19937 random(4);
  const SpaceMatrix<D> slope = random_deformation<D>(random, 1);
  std::vector<SpaceVector<D>> linear, any;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    linear.push_back(SpaceVector<D>::Ones() + slope * grid.position(i));
    any.push_back(random_point<D>(random, -1, 1));
  }
  const auto moment_of = [&](const auto& at, const SpaceVector<D>& x, const auto& modes,
                             const std::vector<SpaceVector<D>>& c) {
    std::vector<SpaceVector<D>> own(at.size(), SpaceVector<D>::Zero());
    modes.add_to(own, at.size(), c);
    SpaceMatrix<D> sum = SpaceMatrix<D>::Zero();
    for (std::size_t n = 0; n < at.size(); ++n)
      sum += at.S[n] * own[n] * (grid.position(at.node[n]) - x).transpose();
    return sum;
  };
  const auto check = [&](const auto& at, const SpaceVector<D>& x, const char* name) {
    DomainModes<D> modes;
    modes.fill(grid, at);
    std::vector<SpaceVector<D>> c(D), shown(at.size(), at.value(linear));
    modes.coefficients(at, linear, c);
    for (int d = 0; d < D; ++d) EXPECT_LE((c[d] - slope.col(d)).norm(), 1e-9) << name;
    modes.add_to(shown, at.size(), c);
    for (std::size_t n = 0; n < at.size(); ++n)
      EXPECT_LE((shown[n] - linear[at.node[n]]).norm(), 1e-9) << name;
    modes.coefficients(at, any, c);
    EXPECT_LE((modes.moment(c) - moment_of(at, x, modes, c)).norm(), rounding_of_modes) << name;
  };
  for (int round = 0; round < 20; ++round) {
    const SpaceVector<D> x = random_point<D>(random, 0.2, 0.8);
    const SpaceMatrix<D> half_edges = 0.08 * random_deformation<D>(random, 0.3);
    NodeFunctions<D> at;
    GimpFunctions::at(grid, ugimp_domain<D>(x, half_edges), at);
    check(at, x, "box");
    Cpdi1Functions::at(grid, ParallelepipedDomain<D>{x, half_edges}, at);
    check(at, x, "parallelepiped");
    for (const ModeSet set : {ModeSet::affine, ModeSet::polynomial}) {
      const Around around(SplineFunctions<2>{}, grid, x, set);
      std::vector<SpaceVector<D>> c(static_cast<std::size_t>(around.modes.count()));
      around.modes.coefficients(around.at, any, c);
      for (int r = 0; r < around.modes.count(); ++r)
        EXPECT_EQ(c[r], around.modes.coefficient(r, around.at, any));
      EXPECT_LE((around.modes.moment(c) - moment_of(around.at, x, around.modes, c)).norm(),
                rounding_of_modes);
    }
  }
}

// Small domains about a node, on an edge of cells, on a face of them: with the positions of nodes as
// data C is D D^+, the projection on the directions that the domain sees. So slopes along these are
// exact, and nothing is said of the others.
TYPED_TEST(Modes, OfSmallDomainsKnowWhatTheySee) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  std::mt19937 random(5);
  for (int seen = 0; seen < 1 << D; ++seen)
    for (const double tiny : {1e-12, 1e-7, 1e-4})
      for (int round = 0; round < 5; ++round) {
        SpaceVector<D> x = SpaceVector<D>::Constant(0.5);
        SpaceMatrix<D> half_edges = tiny * grid.h() * random_deformation<D>(random, 0.3);
        SpaceMatrix<D> projection = SpaceMatrix<D>::Zero();
        for (int d = 0; d < D; ++d)
          if (seen >> d & 1) {
            x[d] += uniform(random, 0.2, 0.8) * grid.h();
            projection(d, d) = 1;
          }
        NodeFunctions<D> at;
        Cpdi1Functions::at(grid, ParallelepipedDomain<D>{x, half_edges}, at);
        DomainModes<D> modes;
        modes.fill(grid, at);
        EXPECT_EQ(modes.rank(), std::popcount(static_cast<unsigned>(seen)));
        std::vector<SpaceVector<D>> positions, c(D);
        for (std::size_t i = 0; i < grid.size(); ++i) positions.push_back(grid.position(i));
        modes.coefficients(at, positions, c);
        for (int d = 0; d < D; ++d)
          EXPECT_LE((c[d] - projection.col(d)).norm(), 3 * tiny + 1e-11) << seen << " " << tiny;
      }
}

// At a node of linear functions that node is all that is seen: no slope. Data that are not finite
// are named.
TEST(ModesOfDomains, OfASingleNodeAreZero) {
  const CartesianGrid<2> grid = unit_grid<2>(4);
  std::vector<SpaceVector<2>> u(grid.size(), SpaceVector<2>(1, 2)), c(2);
  LinearFunctions::Nodes<2> at;
  LinearFunctions{}.at(grid, SpaceVector<2>(0.5, 0.5), at);
  DomainModes<2> modes;
  modes.fill(grid, at);
  modes.coefficients(at, u, c);
  EXPECT_EQ(c[0].norm() + c[1].norm(), 0);
  EXPECT_EQ(modes.rank(), 0);
  u[at.node[0]][1] = std::nan("");
  EXPECT_THROW(modes.coefficients(at, u, c), InvalidArgument);
  c[1][0] = std::nan("");
  std::vector<SpaceVector<2>> shown(at.size(), SpaceVector<2>::Zero());
  EXPECT_THROW(modes.add_to(shown, at.size(), c), InvalidArgument);
}

}  // namespace
}  // namespace recon::test
