// The functions of the grid: what makes each of them what it is, and how splines end at faces.
// Sums, slopes and linear fields of all of them are in domain_functions_test.cpp.
#include "recon/transfer/point_functions.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <string>

#include "recon/transfer/cells.hpp"
#include "recon/weights/weight.hpp"
#include "support/space.hpp"

namespace recon::test {
namespace {

constexpr double rounding_of_points = 1e-13;

// S and G of all nodes of the grid at a point.
template <int D>
struct Functions {
  Eigen::VectorXd S;
  Eigen::Matrix<double, Eigen::Dynamic, D> G;

  template <class Policy>
  Functions(const Policy& policy, const CartesianGrid<D>& grid, const SpaceVector<D>& x)
      : S(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(grid.size()))) {
    G.setZero(S.size(), D);
    typename Policy::template Nodes<D> shape;
    policy.at(grid, x, shape);
    for (std::size_t k = 0; k < shape.size(); ++k) {
      S[shape.node[k]] += shape.S[k];
      G.row(shape.node[k]) += shape.G[k].transpose();
    }
  }
};
template <class Policy, int D>
Functions(const Policy&, const CartesianGrid<D>&, const SpaceVector<D>&) -> Functions<D>;

// Calls work(policy, name) with all bases that are for D dimensions.
template <int D, class Work>
void with_bases(const Work& work) {
  work(LinearFunctions{}, "linear");
  work(NineNodeFunctions{}, "q9");
  if constexpr (D == 2) work(EightNodeFunctions{}, "q8");
  using enum SplineBorder;
  for (const SplineBorder border : {corrected, extra_column, linear_cells}) {
    const std::string at = std::string(name_of(border));
    work(SplineFunctions<2>{{border}}, "bspline2 " + at);
    work(SplineFunctions<3>{{border}}, "bspline3 " + at);
  }
}

template <class T>
class Bases : public ::testing::Test {};
TYPED_TEST_SUITE(Bases, AllDimensions);

TYPED_TEST(Bases, GradientsAreSlopesOfTheValues) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(6);
  const double step = 1e-5 * grid.h();
  with_bases<D>([&](const auto& policy, const std::string& name) {
    std::mt19937 random(11);
    for (int round = 0; round < 60; ++round) {
      const SpaceVector<D> x = random_point<D>(random);
      const Functions at(policy, grid, x);
      for (int d = 0; d < D; ++d) {
        const SpaceVector<D> offset = step * SpaceVector<D>::Unit(d);
        const Eigen::VectorXd slope = (Functions(policy, grid, SpaceVector<D>(x + offset)).S -
                                       Functions(policy, grid, SpaceVector<D>(x - offset)).S) /
                                      (2 * step);
        EXPECT_LE((slope - at.G.col(d)).cwiseAbs().maxCoeff() * grid.h(), 1e-9) << name;
      }
    }
  });
}

// Exactly on an edge of a cell, or by rounding_of_points beside it, a node that sees a gradient has some of
// the point's mass: the force on it would have nothing to push otherwise.
TYPED_TEST(Bases, NodesWithASlopeHaveAValueOnEdges) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  const auto check = [&](const auto& policy, const char* name) {
    for (int edge = 0; edge <= 4; ++edge)
      for (const double off : {-1e-17, 0.0, 1e-17}) {
        const Functions at(policy, grid,
                           SpaceVector<D>(SpaceVector<D>::Constant(edge * 0.25 + off)));
        for (Eigen::Index i = 0; i < at.S.size(); ++i)
          if (at.G.row(i).norm() * grid.h() > 1e-6) {
            EXPECT_NE(at.S[i], 0) << name << " edge " << edge << " node " << i;
          }
      }
  };
  check(LinearFunctions{}, "linear");
  check(SplineFunctions<2>{}, "bspline2");
  check(SplineFunctions<3>{}, "bspline3");
  check(CellFunctions<1>{}, "cell_linear");
  check(CellFunctions<2>{}, "cell_bspline2");
}

// Also where the grid is as small as it can be: a spline on one cell is linear there.
TYPED_TEST(Bases, OneCellIsEnoughForSplines) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(1);
  std::mt19937 random(12);
  for (int round = 0; round < 20; ++round) {
    const SpaceVector<D> x = random_point<D>(random);
    const Functions linear(LinearFunctions{}, grid, x), quadratic(SplineFunctions<2>{}, grid, x),
        cubic(SplineFunctions<3>{}, grid, x);
    EXPECT_LE((quadratic.S - linear.S).norm() + (cubic.S - linear.S).norm(), rounding_of_points);
    EXPECT_LE((quadratic.G - linear.G).norm() + (cubic.G - linear.G).norm(),
              10 * rounding_of_points);
    const Functions one(CellFunctions<1>{}, grid, x), two(CellFunctions<2>{}, grid, x);
    EXPECT_LE((one.S - linear.S).norm() + (two.S - linear.S).norm(), rounding_of_points);
    EXPECT_LE((one.G - linear.G).norm() + (two.G - linear.G).norm(), 10 * rounding_of_points);
  }
}

// S_i = sum_c k_c N_i(x_c) and G_i = sum_c k_c grad N_i(x_c), with the tensor B-spline k about the
// centres of cells, where no cell beyond a face counts (Liang, Zhang, Liu 2019).
TYPED_TEST(Bases, CellFunctionsGoThroughTheCells) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(6);
  const double h = grid.h();
  std::mt19937 random(15);
  const auto check = [&](const auto& policy, const auto& spline, double support, double middle) {
    for (int round = 0; round < 30; ++round) {
      const SpaceVector<D> x = random_point<D>(random, h + 1e-9, 1 - h - 1e-9);
      const Functions at(policy, grid, x);
      Functions<D> sum(LinearFunctions{}, grid, x);
      sum.S.setZero();
      sum.G.setZero();
      for (std::size_t c = 0; c < grid.cell_count(); ++c) {
        const SpaceVector<D> centre = cell_corner(grid, c).array() + h / 2;
        double k = 1;
        for (int d = 0; d < D; ++d)
          k *= middle / spline(0.0) * spline(std::abs(x[d] - centre[d]) / (support * h));
        const Functions linear(LinearFunctions{}, grid, centre);
        sum.S += k * linear.S;
        sum.G += k * linear.G;
      }
      EXPECT_NEAR(sum.S.sum(), 1, rounding_of_points);
      EXPECT_LE((at.S - sum.S).norm(), rounding_of_points);
      EXPECT_LE((at.G - sum.G).norm() * h, 10 * rounding_of_points);
    }
  };
  check(CellFunctions<1>{}, BSpline<1>{}, 1.0, 1.0);
  check(CellFunctions<2>{}, BSpline<2>{}, 1.5, 0.75);
}

// On one axis their slopes are those of the spline of one degree more.
TEST(CellFunctionsOnALine, HaveTheSlopesOfSplines) {
  const CartesianGrid<1> grid = unit_grid<1>(6);
  std::mt19937 random(16);
  for (int round = 0; round < 100; ++round) {
    const SpaceVector<1> x = random_point<1>(random);
    const Functions one(CellFunctions<1>{}, grid, x), two(CellFunctions<2>{}, grid, x),
        quadratic(SplineFunctions<2>{}, grid, x), cubic(SplineFunctions<3>{}, grid, x);
    EXPECT_LE((one.G - quadratic.G).norm(), 100 * rounding_of_points);
    EXPECT_LE((two.G - cubic.G).norm(), 100 * rounding_of_points);
  }
}

// With the border `corrected` splines are positive, and at a face only its own nodes have any.
TYPED_TEST(Bases, SplinesArePositiveAndInterpolateAtFaces) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(13);
  for (const int cells : {1, 2, 3, 5}) {
    const CartesianGrid<D> grid = unit_grid<D>(cells);
    const auto check = [&](const auto& policy) {
      for (int round = 0; round < 100; ++round) {
        SpaceVector<D> x = random_point<D>(random);
        EXPECT_GE(Functions(policy, grid, x).S.minCoeff(), -1e-16);
        const int axis = round % D, face = round / D % 2;
        x[axis] = face;
        const Functions at(policy, grid, x);
        for (std::size_t i = 0; i < grid.size(); ++i)
          if (std::abs(grid.position(i)[axis] - face) > 0.5 * grid.h()) {
            EXPECT_NEAR(at.S[static_cast<Eigen::Index>(i)], 0, rounding_of_points);
          }
      }
    };
    check(SplineFunctions<2>{});
    check(SplineFunctions<3>{});
    check(CellFunctions<1>{});
    check(CellFunctions<2>{});
  }
}

// The largest jump of S, of its slope times h and of its second derivative times h^2, over the
// knots and the faces' neighbourhood: all multiples of h / 2.
template <class Policy>
std::array<double, 3> jumps(const Policy& policy, const CartesianGrid<1>& grid) {
  std::array<double, 3> most{};
  const double h = grid.h(), step = 1e-4 * h;
  for (int knot = 1; knot < 2 * grid.cells(0); ++knot) {
    const auto at = [&](double steps) {
      return Functions(policy, grid, SpaceVector<1>(knot * h / 2 + steps * step));
    };
    const Functions left(at(-1)), right(at(1)), before(at(-2)), after(at(2));
    // Extrapolated to the knot, so that what is left is the jump.
    const auto jump = [&](const auto& value) {
      return ((2 * value(right) - value(after)) - (2 * value(left) - value(before)))
          .cwiseAbs()
          .maxCoeff();
    };
    most[0] = std::max(most[0], jump([](const auto& f) { return f.S; }));
    most[1] = std::max(most[1], h * jump([](const auto& f) { return Eigen::VectorXd(f.G); }));
    most[2] = std::max(
        most[2], h * h * ((after.G - right.G) - (left.G - before.G)).cwiseAbs().maxCoeff() / step);
  }
  return most;
}

// Quadratic splines have one continuous derivative, cubic ones two, also next to the faces;
// elements have none, and the linear cells of a border are not even continuous to the splines.
TEST(Splines, AreSmooth) {
  for (const int cells : {2, 3, 6}) {
    const CartesianGrid<1> grid = unit_grid<1>(cells);
    const auto quadratic = jumps(SplineFunctions<2>{}, grid),
               cubic = jumps(SplineFunctions<3>{}, grid);
    const double flat = 1e-6;
    EXPECT_LE(quadratic[0] + cubic[0], flat);
    EXPECT_LE(quadratic[1] + cubic[1], flat);
    EXPECT_LE(cubic[2], 1e-3);
    EXPECT_GE(quadratic[2], 0.99);
    EXPECT_GE(jumps(LinearFunctions{}, grid)[1], 0.99);
  }
  EXPECT_GE(jumps(NineNodeFunctions{}, unit_grid<1>(6))[1], 0.99);
  const CartesianGrid<1> grid = unit_grid<1>(6);
  // From the linear functions (0, 1, 0) at the second node to (1/8, 3/4, 1/8) and (1/6, 2/3, 1/6).
  EXPECT_NEAR(jumps(SplineFunctions<2>{{SplineBorder::linear_cells}}, grid)[0], 0.25, 1e-6);
  EXPECT_NEAR(jumps(SplineFunctions<3>{{SplineBorder::linear_cells}}, grid)[0], 1.0 / 3, 1e-6);
}

// Andersen, Andersen 2007: eq. 23, and the 16 products that it gives in 2-D.
TEST(Splines, AreThoseOfTheSource) {
  const auto cubic = [](double xi) {
    xi = std::abs(xi);
    return xi < 1   ? 2.0 / 3 - xi * xi + xi * xi * xi / 2
           : xi < 2 ? (2 - xi) * (2 - xi) * (2 - xi) / 6
                    : 0.0;
  };
  const auto quadratic = [](double xi) {
    xi = std::abs(xi);
    return xi < 0.5 ? 0.75 - xi * xi : xi < 1.5 ? (1.5 - xi) * (1.5 - xi) / 2 : 0.0;
  };
  const CartesianGrid<1> line = unit_grid<1>(8);
  for (double x = 0.13; x < 0.87; x += 0.0137) {
    const Functions two(SplineFunctions<2>{}, line, SpaceVector<1>(x)),
        three(SplineFunctions<3>{}, line, SpaceVector<1>(x));
    for (int i = 0; i <= 8; ++i) {
      EXPECT_NEAR(two.S[i], quadratic(8 * x - i), rounding_of_points);
      EXPECT_NEAR(three.S[i], cubic(8 * x - i), rounding_of_points);
    }
  }
  const auto product = [](double xi, double eta, int number) {
    const auto one = [](double s, int k) {
      return k == 0   ? (1 - s) * (1 - s) * (1 - s) / 6
             : k == 1 ? 2.0 / 3 - s * s + s * s * s / 2
             : k == 2 ? 1.0 / 6 + s / 2 + s * s / 2 - s * s * s / 2
                      : s * s * s / 6;
    };
    return one(xi, (number - 1) / 4) * one(eta, (number - 1) % 4);
  };
  const CartesianGrid<2> plane = unit_grid<2>(8);
  std::mt19937 random(14);
  for (int round = 0; round < 50; ++round) {
    const double xi = uniform(random, 0, 1), eta = uniform(random, 0, 1);
    const Functions at(SplineFunctions<3>{}, plane, SpaceVector<2>((3 + xi) / 8, (4 + eta) / 8));
    for (int number = 1; number <= 16; ++number) {
      const std::uint32_t node = plane.number({2 + (number - 1) / 4, 3 + (number - 1) % 4});
      EXPECT_NEAR(at.S[node], product(xi, eta, number), rounding_of_points);
    }
  }
}

// Inside the grid they are the weights of weights/ at q = |x - x_i| / rho, rho = (P + 1) h / 2, up
// to rounding_of_points: the closed forms here keep one rounding_of_points less.
TEST(Splines, AreTheWeightsOfThatDegree) {
  const CartesianGrid<1> line = unit_grid<1>(8);
  const auto check = [&]<int P>(std::integral_constant<int, P>) {
    const double rho = (P + 1) / 2.0 / 8;
    for (double x = 0.26; x < 0.74; x += 0.00137) {
      const Functions at(SplineFunctions<P>{}, line, SpaceVector<1>(x));
      for (int i = 0; i <= 8; ++i) {
        const double q = std::min(std::abs(x - i / 8.0) / rho, 1.0), sign = x > i / 8.0 ? 1 : -1;
        EXPECT_NEAR(at.S[i], BSpline<P>{}(q), 1e-15);
        EXPECT_NEAR(at.G(i, 0), sign / rho * BSpline<P>{}.derivative(q), 1e-13);
      }
    }
  };
  check(std::integral_constant<int, 2>{});
  check(std::integral_constant<int, 3>{});
}

// 1 less the function of the node beyond the face, which is held at rest; linear fields are wrong
// there and right inside.
TEST(Splines, LoseTheExtraColumn) {
  const CartesianGrid<1> grid = unit_grid<1>(8);
  for (double s = 0.005; s < 8; s += 0.0371) {
    const double near = std::min(s, 8 - s);
    const double two = near < 0.5 ? (0.5 - near) * (0.5 - near) / 2 : 0;
    const double three = near < 1 ? (1 - near) * (1 - near) * (1 - near) / 6 : 0;
    const auto border = SplineBorder::extra_column;
    EXPECT_NEAR(Functions(SplineFunctions<2>{{border}}, grid, SpaceVector<1>(s / 8)).S.sum(),
                1 - two, rounding_of_points);
    EXPECT_NEAR(Functions(SplineFunctions<3>{{border}}, grid, SpaceVector<1>(s / 8)).S.sum(),
                1 - three, rounding_of_points);
  }
}

// Linear cells keep all sums and linear fields, right up to where they end.
TEST(Splines, OnLinearCellsReproduceLinearFields) {
  const auto border = SplineBorder::linear_cells;
  for (const int cells : {1, 2, 3, 6}) {
    const CartesianGrid<1> grid = unit_grid<1>(cells);
    Eigen::VectorXd place(cells + 1);
    for (int i = 0; i <= cells; ++i) place[i] = grid.node(i, 0);
    for (double x = 0; x < 1; x += 0.0173) {
      const auto check = [&](const auto& policy) {
        const Functions at(policy, grid, SpaceVector<1>(x));
        EXPECT_NEAR(at.S.sum(), 1, rounding_of_points);
        EXPECT_NEAR(at.S.dot(place), x, rounding_of_points);
        EXPECT_NEAR(at.G.col(0).dot(place), 1, 10 * rounding_of_points);
      };
      check(SplineFunctions<2>{{border}});
      check(SplineFunctions<3>{{border}});
    }
  }
}

// The value and the gradient that nodal values of `field` have at x, less those of the field.
template <int D, class Policy, class Field, class Slope>
double error_of(const Policy& policy, const CartesianGrid<D>& grid, const SpaceVector<D>& x,
                const Field& field, const Slope& slope) {
  const Functions at(policy, grid, x);
  Eigen::VectorXd nodes(at.S.size());
  for (Eigen::Index i = 0; i < nodes.size(); ++i)
    nodes[i] = field(grid.position(static_cast<std::size_t>(i)));
  return std::abs(at.S.dot(nodes) - field(x)) +
         grid.h() * (at.G.transpose() * nodes - slope(x)).norm();
}

// x^a y^b z^c with its slope; powers[d] is that of axis d.
template <int D>
auto monomial(const std::array<int, 3>& powers) {
  const auto field = [powers](const SpaceVector<D>& x) {
    double value = 1;
    for (int d = 0; d < D; ++d) value *= std::pow(x[d], powers[d]);
    return value;
  };
  const auto slope = [powers](const SpaceVector<D>& x) {
    SpaceVector<D> all;
    for (int e = 0; e < D; ++e) {
      all[e] = 1;
      for (int d = 0; d < D; ++d)
        all[e] *= d != e ? std::pow(x[d], powers[d])
                         : powers[d] * std::pow(x[d], std::max(powers[d] - 1, 0));
    }
    return all;
  };
  return std::pair(field, slope);
}

TYPED_TEST(Bases, NineNodeElementsHaveAllQuadratics) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  std::mt19937 random(15);
  for (int number = 0; number < 27; ++number) {
    const auto [field, slope] = monomial<D>({number % 3, number / 3 % 3, number / 9});
    for (int round = 0; round < 20; ++round)
      EXPECT_LE(error_of(NineNodeFunctions{}, grid, random_point<D>(random), field, slope),
                rounding_of_points);
  }
  const auto [field, slope] = monomial<D>({3, 0, 0});
  EXPECT_GE(error_of(NineNodeFunctions{}, grid, SpaceVector<D>(SpaceVector<D>::Constant(0.4)),
                     field, slope),
            1e-4);
}

// All of degree 2, x^2 y and x y^2; but not x^2 y^2, which has -1 instead of 0 in the middle of
// [-1, 1]^2 (there corners have -1/4, sides 1/2).
TEST(Elements, EightNodesHaveQuadraticsAndTwoCubics) {
  const CartesianGrid<2> grid = unit_grid<2>(4);
  std::mt19937 random(16);
  using Powers = std::array<int, 3>;
  for (const Powers& powers :
       {Powers{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}, {2, 1}, {1, 2}}) {
    const auto [field, slope] = monomial<2>(powers);
    for (int round = 0; round < 20; ++round)
      EXPECT_LE(error_of(EightNodeFunctions{}, grid, random_point<2>(random), field, slope),
                rounding_of_points);
  }
  const Functions middle(EightNodeFunctions{},
                         CartesianGrid<2>(SpaceVector<2>(-1, -1), SpaceVector<2>(1, 1), 1),
                         SpaceVector<2>(0, 0));
  Eigen::VectorXd values(9);
  values << 1, 0, 1, 0, 0, 0, 1, 0, 1;
  EXPECT_NEAR(middle.S.dot(values), -1, rounding_of_points);
}

// The printed functions of the elements (Andersen, Andersen 2007, section 3.4), their nodes counter
// clockwise from the lower left corner.
TEST(Elements, AreThoseOfTheSource) {
  const CartesianGrid<2> grid(SpaceVector<2>(-1, -1), SpaceVector<2>(1, 1), 1);
  constexpr int place[9][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2},
                               {1, 2}, {0, 2}, {0, 1}, {1, 1}};
  std::mt19937 random(17);
  for (int round = 0; round < 50; ++round) {
    const double x = uniform(random, -1, 1), y = uniform(random, -1, 1);
    const double nine[9] = {
        (x * x - x) * (y * y - y) / 4, (1 - x * x) * (y * y - y) / 2, (x * x + x) * (y * y - y) / 4,
        (x * x + x) * (1 - y * y) / 2, (x * x + x) * (y * y + y) / 4, (1 - x * x) * (y * y + y) / 2,
        (x * x - x) * (y * y + y) / 4, (x * x - x) * (1 - y * y) / 2, (1 - x * x) * (1 - y * y)};
    const double eight[9] = {(1 - x) * (1 - y) * (-x - y - 1) / 4,
                             (1 - x * x) * (1 - y) / 2,
                             (1 + x) * (1 - y) * (x - y - 1) / 4,
                             (1 + x) * (1 - y * y) / 2,
                             (1 + x) * (1 + y) * (x + y - 1) / 4,
                             (1 - x * x) * (1 + y) / 2,
                             (1 - x) * (1 + y) * (-x + y - 1) / 4,
                             (1 - x) * (1 - y * y) / 2,
                             0};
    const Functions q8(EightNodeFunctions{}, grid, SpaceVector<2>(x, y)),
        q9(NineNodeFunctions{}, grid, SpaceVector<2>(x, y));
    for (int n = 0; n < 9; ++n) {
      const std::uint32_t node = grid.number({place[n][0], place[n][1]});
      EXPECT_NEAR(q8.S[node], eight[n], rounding_of_points);
      EXPECT_NEAR(q9.S[node], nine[n], rounding_of_points);
    }
  }
}

// At each of its own nodes a function is one and all others are zero, from all sides.
TYPED_TEST(Bases, ElementsInterpolateAtTheirNodes) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  for (std::size_t i = 0; i < grid.size(); ++i)
    for (const double off : {-1e-15, 0.0, 1e-15}) {
      const SpaceVector<D> x = grid.position(i).array() + off;
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(static_cast<Eigen::Index>(grid.size()),
                                                         static_cast<Eigen::Index>(i));
      EXPECT_LE((Functions(NineNodeFunctions{}, grid, x).S - unit).norm(), 10 * rounding_of_points);
      if constexpr (D == 2) {
        const auto index = grid.nodes().index(i);
        if (index[0] % 2 == 1 && index[1] % 2 == 1) continue;  // no node of q8
        EXPECT_LE((Functions(EightNodeFunctions{}, grid, x).S - unit).norm(),
                  10 * rounding_of_points);
      }
    }
}

// The integral of a corner's function over its element is -1/12 of the area with 8 nodes, so that a
// full grid has negative masses; with 9 nodes it is 1/36.
TEST(Elements, OfEightNodesHaveNegativeCorners) {
  const CartesianGrid<2> grid(SpaceVector<2>(-1, -1), SpaceVector<2>(1, 1), 1);
  Eigen::VectorXd eight = Eigen::VectorXd::Zero(9), nine = eight;
  const double place = std::sqrt(0.6);
  for (const double x : {-place, 0.0, place})
    for (const double y : {-place, 0.0, place}) {
      const double weight = (x == 0 ? 8.0 : 5.0) / 9 * (y == 0 ? 8.0 : 5.0) / 9;
      eight += weight * Functions(EightNodeFunctions{}, grid, SpaceVector<2>(x, y)).S;
      nine += weight * Functions(NineNodeFunctions{}, grid, SpaceVector<2>(x, y)).S;
    }
  for (const int corner : {0, 2, 6, 8}) {
    EXPECT_NEAR(eight[corner], -4.0 / 12, rounding_of_points);
    EXPECT_NEAR(nine[corner], 4.0 / 36, rounding_of_points);
  }
  for (const int side : {1, 3, 5, 7}) EXPECT_NEAR(eight[side], 4.0 / 3, rounding_of_points);
}

TEST(Elements, NeedAnEvenNumberOfCells) {
  NodeFunctions<2> shape;
  const auto fails = [&](const auto& functions, int cells) {
    try {
      functions.at(unit_grid<2>(cells), SpaceVector<2>(0.5, 0.9), shape);
    } catch (const InvalidArgument& error) {
      return std::string(error.what()) ==
             "cells of the grid along x = 5: must be even with elements of 2 x 2 cells";
    }
    return false;
  };
  EXPECT_TRUE(fails(NineNodeFunctions{}, 5));
  EXPECT_TRUE(fails(EightNodeFunctions{}, 5));
  EXPECT_FALSE(fails(NineNodeFunctions{}, 6));
  EXPECT_FALSE(fails(EightNodeFunctions{}, 6));
}

// Inside the grid G = (4 / h^2) S d (Hu et al. 2018), which is not the slope of S.
TYPED_TEST(Bases, MomentGradientsAreMomentsOfTheSplines) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(6);
  std::mt19937 random(18);
  double most = 0;
  for (int round = 0; round < 50; ++round) {
    const SpaceVector<D> x = random_point<D>(random, 0.5 / 6, 5.5 / 6);
    const Functions at(MomentSplineFunctions{}, grid, x), spline(SplineFunctions<2>{}, grid, x);
    EXPECT_LE((at.S - spline.S).norm(), rounding_of_points);
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const auto n = static_cast<Eigen::Index>(i);
      const SpaceVector<D> expected = 4 * 36 * spline.S[n] * (grid.position(i) - x);
      EXPECT_LE((at.G.row(n).transpose() - expected).norm() * grid.h(), 10 * rounding_of_points);
    }
    most = std::max(most, (at.G - spline.G).norm() * grid.h());
  }
  EXPECT_GE(most, 0.1);
}

}  // namespace
}  // namespace recon::test
