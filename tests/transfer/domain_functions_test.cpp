// Points and particle domains: partition of unity, linear completeness, closed forms.
#include "recon/transfer/domain_functions.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "support/message_of.hpp"
#include "support/space.hpp"

namespace recon::test {
namespace {

constexpr double rounding_of_domains = 1e-13;

template <class T>
class Domains : public ::testing::Test {};
TYPED_TEST_SUITE(Domains, AllDimensions);

// What sums to one, to zero, to x and to the unit matrix, and the nodes that are announced.
template <int D, class Functions, class Domain>
void expect_linear_completeness(const Functions& functions, const CartesianGrid<D>& grid,
                                const Domain& domain, const SpaceVector<D>& centroid,
                                const char* name) {
  typename Functions::template Nodes<D> shape;
  functions.at(grid, domain, shape);
  double sum = 0;
  SpaceVector<D> slope = SpaceVector<D>::Zero();
  for (std::size_t k = 0; k < shape.size(); ++k) {
    sum += shape.S[k];
    slope += shape.G[k];
    const SpaceVector<D> node = grid.position(shape.node[k]);
    for (int d = 0; d < D; ++d) {
      const std::pair<int, int> nodes = functions.nodes_along(grid, domain, d);
      EXPECT_GE(node[d], grid.node(nodes.first, d)) << name;
      EXPECT_LE(node[d], grid.node(nodes.second, d)) << name;
    }
  }
  const auto place = [&](std::uint32_t i) { return grid.position(i); };
  EXPECT_NEAR(sum, 1, rounding_of_domains) << name;
  EXPECT_LE(slope.norm() * grid.h(), rounding_of_domains) << name;
  EXPECT_LE((shape.value(place) - centroid).norm(), rounding_of_domains) << name;
  EXPECT_LE((shape.gradient(place) - SpaceMatrix<D>::Identity()).norm(), 100 * rounding_of_domains)
      << name;
}

// Anywhere in the grid, also at its faces, whatever the deformation.
TYPED_TEST(Domains, ReproduceLinearFields) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(3);
  const CartesianGrid<D> grid = unit_grid<D>(8);
  for (int p = 0; p < 200; ++p) {
    SpaceVector<D> x;
    for (int d = 0; d < D; ++d)
      x[d] = p % 5 == 0 ? 0.125 * static_cast<double>(random() % 9) : uniform(random, 0, 1);
    const SpaceMatrix<D> H = 0.03 * random_deformation<D>(random, 0.2);
    // Some so long that their corners are gathered one by one.
    const SpaceMatrix<D> F = (p % 7 == 0 ? 8.0 : 1.0) * random_deformation<D>(random, 0.3);
    const auto check = [&](const auto& functions, const auto& domain, const char* name) {
      expect_linear_completeness<D>(functions, grid, domain, x, name);
    };
    check(LinearFunctions{}, x, "linear");
    check(ContinuedLinearFunctions{}, x, "continued linear");
    check(NineNodeFunctions{}, x, "q9");
    if constexpr (D == 2) check(EightNodeFunctions{}, x, "q8");
    check(SplineFunctions<2>{}, x, "bspline2");
    check(SplineFunctions<3>{}, x, "bspline3");
    check(MomentSplineFunctions{}, x, "bspline2 by moments");
    check(CellFunctions<1>{}, x, "cell_linear");
    check(CellFunctions<2>{}, x, "cell_bspline2");
    check(GimpFunctions{}, ugimp_domain<D>(x, H), "ugimp");
    check(GimpFunctions{}, cpgimp_domain<D>(x, H, F), "cpgimp");
    const ParallelepipedDomain<D> deformed{x, F * H};
    check(Cpdi1Functions{}, deformed, "cpdi1");
    check(Cpdi2Functions{}, CornerDomain<D>(corners_of(deformed)), "cpdi2");
    DomainCorners<D> corners = corners_of(deformed);
    for (auto& corner : corners) corner += random_point<D>(random, -0.003, 0.003);
    const CornerDomain<D> bent(corners);
    expect_linear_completeness<D>(Cpdi2Functions{}, grid, bent, bent.centroid(), "cpdi2 bent");
  }
}

// On parallelepipeds both convected domains are the same.
TYPED_TEST(Domains, Cpdi2OfAParallelepipedIsCpdi1) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(5);
  const CartesianGrid<D> grid = unit_grid<D>(10);
  Cpdi1Functions::Nodes<D> one;
  Cpdi2Functions::Nodes<D> two;
  for (int p = 0; p < 50; ++p) {
    const SpaceMatrix<D> H = 0.03 * random_deformation<D>(random, 0.2);
    const ParallelepipedDomain<D> domain{random_point<D>(random, 0.2, 0.8),
                                         random_deformation<D>(random, 0.3) * H};
    const CornerDomain<D> cell(corners_of(domain));
    Cpdi1Functions::at(grid, domain, one);
    Cpdi2Functions::at(grid, cell, two);
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t k = 0; k < one.size(); ++k) {
      EXPECT_NEAR(one.S[k], two.S[k], rounding_of_domains);
      EXPECT_LE((one.G[k] - two.G[k]).norm(), 1000 * rounding_of_domains);
    }
    const double volume = (1 << D) * domain.half_edges.determinant();
    EXPECT_NEAR(cell.volume, volume, rounding_of_domains * volume * 100);
    EXPECT_LE((cell.centroid() - domain.x).norm(), rounding_of_domains);
  }
}

// A box keeps its reference edges (ugimp), or stretches them by the diagonal of F (cpgimp); edges
// that are not along the axes count with the box about them.
TEST(Gimp, BoxesAreKeptOrStretched) {
  SpaceMatrix<2> H, F;
  H << 1, -0.5, 0.25, 2;
  F << -3, 0.1, 0.2, 0.5;
  const SpaceVector<2> x(7, 8);
  EXPECT_EQ(ugimp_domain<2>(x, H).half_edges, SpaceVector<2>(1.5, 2.25));
  EXPECT_EQ(cpgimp_domain<2>(x, H, F).half_edges, SpaceVector<2>(4.5, 1.125));
  EXPECT_EQ(ugimp_domain<2>(x, H).x, x);
  EXPECT_EQ(cpgimp_domain<2>(x, H, F).x, x);
}

// The averages are those of many points of the domain, in it and of their gradients.
TYPED_TEST(Domains, AreAveragesOfLinearFunctions) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  const SpaceVector<D> x = SpaceVector<D>::Constant(0.45);
  const SpaceVector<D> half = SpaceVector<D>::LinSpaced(0.09, 0.17);
  GimpFunctions::Nodes<D> box;
  GimpFunctions::at(grid, {x, half}, box);
  const auto dense = [&](const auto& shape, Eigen::VectorXd& S, Eigen::MatrixXd& G, double part) {
    for (std::size_t k = 0; k < shape.size(); ++k) {
      S[shape.node[k]] += part * shape.S[k];
      G.row(shape.node[k]) += part * shape.G[k].transpose();
    }
  };
  const auto size = static_cast<Eigen::Index>(grid.size());
  Eigen::VectorXd S = Eigen::VectorXd::Zero(size), averages = S;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(size, D), slopes = G;
  dense(box, S, G, 1);
  constexpr int per_axis = D == 3 ? 40 : 100;
  int all = 1;
  for (int d = 0; d < D; ++d) all *= per_axis;
  LinearFunctions::Nodes<D> point;
  for (int n = 0; n < all; ++n) {
    SpaceVector<D> at = x;
    for (int d = 0, rest = n; d < D; ++d, rest /= per_axis)
      at[d] += half[d] * ((rest % per_axis + 0.5) * 2 / per_axis - 1);
    LinearFunctions{}.at(grid, at, point);
    dense(point, averages, slopes, 1.0 / all);
  }
  EXPECT_LE((S - averages).cwiseAbs().maxCoeff(), 0.5 / per_axis);
  EXPECT_LE((G - slopes).cwiseAbs().maxCoeff() * grid.h(), 2.0 / per_axis);
}

// The closed form of one axis (Gong 2015, section 6.3; docs/misprints.md, G21).
TEST(Gimp, ClosedForm) {
  const double h = 0.5, l = 0.1;
  const auto S = [&](double s) {
    s = std::abs(s);
    if (s <= l) return 1 - (s * s + l * l) / (2 * h * l);
    if (s <= h - l) return 1 - s / h;
    return s <= h + l ? (h + l - s) * (h + l - s) / (4 * h * l) : 0;
  };
  const auto slope = [&](double s) {
    const double sign = s < 0 ? -1 : 1, a = std::abs(s);
    if (a <= l) return -s / (h * l);
    if (a <= h - l) return -sign / h;
    return a <= h + l ? -sign * (h + l - a) / (2 * h * l) : 0;
  };
  const CartesianGrid<1> grid(SpaceVector<1>(0), SpaceVector<1>(4), h);
  for (double x = 0.61; x < 3.4; x += 0.0137) {
    NodeFunctions<1> shape;
    GimpFunctions::at(grid, {SpaceVector<1>(x), SpaceVector<1>(l)}, shape);
    for (std::size_t k = 0; k < shape.size(); ++k) {
      const double s = x - grid.position(shape.node[k])[0];
      EXPECT_NEAR(shape.S[k], S(s), rounding_of_domains);
      EXPECT_NEAR(shape.G[k][0], slope(s), 100 * rounding_of_domains);
    }
  }
}

// The corner weights of a quadrilateral (Gong 2015, eq. 6.29, 6.30; docs/misprints.md, G23) and the
// gradients (6.32); its corners run counter-clockwise 1 2 3 4, ours are numbered by bits.
TEST(Cpdi2Cell, ClosedForms) {
  std::mt19937 random(7);
  for (int round = 0; round < 100; ++round) {
    const auto near = [&](double x, double y) {
      return SpaceVector<2>(x + uniform(random, -0.2, 0.2), y + uniform(random, -0.2, 0.2));
    };
    const SpaceVector<2> x1 = near(0, 0), x2 = near(1, 0), x3 = near(1, 1), x4 = near(0, 1);
    const CornerDomain<2> cell({x1, x2, x4, x3});
    const auto cross = [](const SpaceVector<2>& a, const SpaceVector<2>& b) {
      return a[0] * b[1] - a[1] * b[0];
    };
    const double area = (cross(x3 - x1, x4 - x2)) / 2;
    const double a = (x4 - x1)[0] * (x2 - x3)[1] - (x2 - x3)[0] * (x4 - x1)[1];
    const double b = (x3 - x4)[0] * (x1 - x2)[1] - (x1 - x2)[0] * (x3 - x4)[1];
    EXPECT_NEAR(cell.volume, area, rounding_of_domains);
    EXPECT_NEAR(cell.weight[0], (6 * area - a - b) / (24 * area), rounding_of_domains);
    EXPECT_NEAR(cell.weight[1], (6 * area - a + b) / (24 * area), rounding_of_domains);
    EXPECT_NEAR(cell.weight[3], (6 * area + a + b) / (24 * area), rounding_of_domains);
    EXPECT_NEAR(cell.weight[2], (6 * area + a - b) / (24 * area), rounding_of_domains);
    const auto slope = [&](const SpaceVector<2>& from, const SpaceVector<2>& to) {
      return SpaceVector<2>(SpaceVector<2>((from - to)[1], (to - from)[0]) / (2 * area));
    };
    EXPECT_LE((cell.slope[0] - slope(x2, x4)).norm(), 10 * rounding_of_domains);
    EXPECT_LE((cell.slope[1] - slope(x3, x1)).norm(), 10 * rounding_of_domains);
    EXPECT_LE((cell.slope[3] - slope(x4, x2)).norm(), 10 * rounding_of_domains);
    EXPECT_LE((cell.slope[2] - slope(x1, x3)).norm(), 10 * rounding_of_domains);
  }
}

TEST(DomainErrors, NameWhatIsWrong) {
  using recon::testing::message_of;
  const CartesianGrid<2> grid = unit_grid<2>(50);
  const SpaceVector<2> x(0.5, 0.5);
  NodeFunctions<2> shape;
  const auto box = [&](double along_x, double along_y) {
    return message_of([&] {
      GimpFunctions::at(grid, {x, SpaceVector<2>(along_x, along_y)}, shape);
    });
  };
  const std::string edge = "half edge of the particle domain along ";
  EXPECT_EQ(box(0.01, 0), edge + "y = 0: must be positive and finite");
  EXPECT_EQ(box(-0.25, 0.01), edge + "x = -0.25: must be positive and finite");
  EXPECT_EQ(box(std::nan(""), 0.01), edge + "x = nan: must be positive and finite");
  EXPECT_EQ(box(0.5, 0.01), "cells of the particle domain along x = 50: must be at most 32");
  EXPECT_EQ(message_of([&] {
              GimpFunctions::nodes_along(grid, BoxDomain<2>{x, {0.01, -0.25}}, 1);
            }),
            edge + "y = -0.25: must be positive and finite");
  // Most of a wide box may lie beyond the grid.
  EXPECT_EQ(message_of([&] {
              GimpFunctions::at(unit_grid<2>(8), {x, SpaceVector<2>(10, 10)}, shape);
            }),
            "no InvalidArgument was thrown");
  SpaceMatrix<2> flat;
  flat << 0.25, 0.5, 0.25, 0.5;
  EXPECT_EQ(
      message_of([&] {
        Cpdi1Functions::at(grid, ParallelepipedDomain<2>{x, flat}, shape);
      }),
      "determinant of the half edges of the particle domain = 0: must be finite and not zero");
  flat(1, 0) = HUGE_VAL;
  EXPECT_EQ(message_of([&] {
              Cpdi1Functions::at(grid, ParallelepipedDomain<2>{x, flat}, shape);
            }),
            "component y of half edge 0 of the particle domain = inf: must be finite");
  EXPECT_EQ(message_of([&] {
              CornerDomain<2>({x, x, x, x});
            }),
            "volume of the particle domain = 0: must be finite and not zero: its corners must span "
            "a cell");
  EXPECT_EQ(message_of([&] {
              CornerDomain<2>({x, x, SpaceVector<2>(0, std::nan("")), x});
            }),
            "coordinate y of corner 2 of the particle domain = nan: must be finite");
}

}  // namespace
}  // namespace recon::test
