// The particle domains: partition of unity, linear completeness, closed forms.
#include "recon/mpm/domains.hpp"

#include <cmath>

#include "mpm/support.hpp"

namespace recon::mpm::test {
namespace {

constexpr double rounding = 1e-13;

template <class T>
class Domains : public testing::Test {};
TYPED_TEST_SUITE(Domains, AllDimensions);

template <int D, class Policy>
void expect_linear_completeness(Policy policy, const Particles<D>& particles, const Grid<D>& grid,
                                const char* name) {
  for (std::size_t p = 0; p < particles.size(); ++p) {
    ShapeFunctions<D> shape;
    policy.shape(grid, particles, p, shape);
    double sum = 0;
    Vector<D> slope = Vector<D>::Zero(), x = Vector<D>::Zero();
    Matrix<D> unit = Matrix<D>::Zero();
    for (std::size_t k = 0; k < shape.size(); ++k) {
      const Vector<D> node = grid.position(shape.node[k]);
      sum += shape.S[k];
      slope += shape.G[k];
      x += shape.S[k] * node;
      unit += node * shape.G[k].transpose();
      for (int d = 0; d < D; ++d) {
        const auto [first, last] = policy.nodes_along(grid, particles, p, d);
        EXPECT_GE(node[d], grid.node(first, d)) << name;
        EXPECT_LE(node[d], grid.node(last, d)) << name;
      }
    }
    EXPECT_NEAR(sum, 1, rounding) << name;
    EXPECT_LE(slope.norm() * grid.h(), rounding) << name;
    EXPECT_LE((x - particles.x[p]).norm(), rounding) << name;
    EXPECT_LE((unit - Matrix<D>::Identity()).norm(), 100 * rounding) << name;
  }
}

// Anywhere in the grid, also at its faces, whatever the deformation.
TYPED_TEST(Domains, ReproduceLinearFields) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(3);
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Ones(), 0.125);
  Particles<D> particles;
  for (int p = 0; p < 200; ++p) {
    Vector<D> x;
    for (int d = 0; d < D; ++d)
      x[d] = p % 5 == 0 ? 0.125 * static_cast<double>(random() % 9) : uniform(random, 0, 1);
    particles.add(x, 0.03 * random_deformation<D>(random, 0.2), 1, 0);
    // Some so long that their corners are gathered one by one.
    particles.F.back() = (p % 7 == 0 ? 8.0 : 1.0) * random_deformation<D>(random, 0.3);
  }
  expect_linear_completeness(PointDomain{}, particles, grid, "point");
  expect_linear_completeness(NineNode{}, particles, grid, "q9");
  if constexpr (D == 2) expect_linear_completeness(EightNode{}, particles, grid, "q8");
  expect_linear_completeness(BSpline<2>{}, particles, grid, "bspline2");
  expect_linear_completeness(BSpline<3>{}, particles, grid, "bspline3");
  expect_linear_completeness(MomentGradients{}, particles, grid, "mls_bspline2");
  expect_linear_completeness(UniformGimp{}, particles, grid, "ugimp");
  expect_linear_completeness(StretchedGimp{}, particles, grid, "cpgimp");
  expect_linear_completeness(Cpdi1{}, particles, grid, "cpdi1");
  for (std::size_t p = 0; p < particles.size(); ++p)
    particles.corners.push_back(particles.domain(p));
  expect_linear_completeness(Cpdi2{}, particles, grid, "cpdi2");
}

// On parallelepipeds both convected domains are the same.
TYPED_TEST(Domains, Cpdi2OfAParallelepipedIsCpdi1) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(5);
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Ones(), 0.1);
  Particles<D> particles;
  for (int p = 0; p < 50; ++p) {
    Vector<D> x;
    for (int d = 0; d < D; ++d) x[d] = uniform(random, 0.2, 0.8);
    particles.add(x, 0.03 * random_deformation<D>(random, 0.2), 1, 0);
    particles.F.back() = random_deformation<D>(random, 0.3);
    particles.corners.push_back(particles.domain(particles.size() - 1));
  }
  ShapeFunctions<D> one, two;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    Cpdi1::shape(grid, particles, p, one);
    const double volume = Cpdi2::shape(grid, particles, p, two);
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t k = 0; k < one.size(); ++k) {
      EXPECT_NEAR(one.S[k], two.S[k], rounding);
      EXPECT_LE((one.G[k] - two.G[k]).norm(), 1000 * rounding);
    }
    EXPECT_NEAR(volume, particles.volume(p), rounding * particles.volume(p) * 100);
  }
}

// A box keeps its reference edges (ugimp), or stretches them by the diagonal of F (cpgimp); edges
// that are not along the axes count with the box about them. Both are then the box of those edges.
TYPED_TEST(Domains, BoxesAreKeptOrStretched) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(6);
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Ones(), 0.1);
  Particles<D> particles, kept, stretched;
  for (int p = 0; p < 30; ++p) {
    Vector<D> x;
    for (int d = 0; d < D; ++d) x[d] = uniform(random, 0.3, 0.7);
    const Matrix<D> half = 0.03 * random_deformation<D>(random, 0.3);
    const Matrix<D> F = 1.5 * random_deformation<D>(random, 0.2);
    particles.add(x, half, 1, 0);
    particles.F.back() = F;
    const Vector<D> edges = half.cwiseAbs().rowwise().sum();
    kept.add(x, edges.asDiagonal().toDenseMatrix(), 1, 0);
    stretched.add(x, edges.cwiseProduct(F.diagonal()).asDiagonal().toDenseMatrix(), 1, 0);
  }
  ShapeFunctions<D> shape, expected;
  const auto expect_same = [&] {
    ASSERT_EQ(shape.size(), expected.size());
    for (std::size_t k = 0; k < shape.size(); ++k) {
      EXPECT_EQ(shape.node[k], expected.node[k]);
      EXPECT_NEAR(shape.S[k], expected.S[k], rounding);
      EXPECT_LE((shape.G[k] - expected.G[k]).norm(), 1000 * rounding);
    }
  };
  for (std::size_t p = 0; p < particles.size(); ++p) {
    UniformGimp::shape(grid, particles, p, shape);
    UniformGimp::shape(grid, kept, p, expected);
    expect_same();
    StretchedGimp::shape(grid, particles, p, shape);
    UniformGimp::shape(grid, stretched, p, expected);
    expect_same();
  }
}

// What a policy gives back is the particle's volume now, det F times that at first.
TYPED_TEST(Domains, VolumesAreOfNow) {
  constexpr int D = TypeParam::value;
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Ones(), 0.125);
  Particles<D> particles;
  particles.add(Vector<D>::Constant(0.4), 0.05 * Matrix<D>::Identity(), 1, 0);
  particles.F[0] = 1.25 * Matrix<D>::Identity();
  particles.corners.push_back(particles.domain(0));
  const double volume = std::pow(0.125, D);
  ShapeFunctions<D> shape;
  const auto check = [&](const auto& policy, const char* name) {
    EXPECT_NEAR(policy.shape(grid, particles, 0, shape), volume, 100 * rounding * volume) << name;
  };
  check(PointDomain{}, "point");
  check(NineNode{}, "q9");
  if constexpr (D == 2) check(EightNode{}, "q8");
  check(BSpline<2>{}, "bspline2");
  check(BSpline<3>{}, "bspline3");
  check(MomentGradients{}, "mls_bspline2");
  check(UniformGimp{}, "ugimp");
  check(StretchedGimp{}, "cpgimp");
  check(Cpdi1{}, "cpdi1");
  check(Cpdi2{}, "cpdi2");
}

// Corners follow a linear velocity field exactly, also beyond the grid, and x is their centroid: of
// a cell cut in simplices the mean of theirs, weighted by area.
TEST(Cpdi2Move, CornersFollowTheGridAndTheParticleItsCentroid) {
  const Grid<2> grid(Vector<2>(0, 0), Vector<2>(1, 1), 0.25);
  Matrix<2> slope;
  slope << 0.5, -1, 0.25, 2;
  const auto velocity_at = [&](const Vector<2>& x) {
    return Vector<2>(Vector<2>(1, -2) + slope * x);
  };
  std::vector<Vector<2>> velocity;
  for (std::size_t i = 0; i < grid.size(); ++i) velocity.push_back(velocity_at(grid.position(i)));
  Particles<2> particles;
  particles.add(Vector<2>(0.9, 0.5), 0.1 * Matrix<2>::Identity(), 1, 0);
  const Particles<2>::Corners before{Vector<2>(0.8, 0.35), Vector<2>(1.05, 0.4),
                                     Vector<2>(0.8, 0.6), Vector<2>(0.95, 0.7)};
  particles.corners.push_back(before);
  const double dt = 0.01;
  Cpdi2::move<2>(grid, particles, 0, velocity, dt);
  const auto& now = particles.corners[0];
  for (std::size_t a = 0; a < 4; ++a)
    EXPECT_LE((now[a] - before[a] - dt * velocity_at(before[a])).norm(), rounding);
  double area = 0;
  Vector<2> centroid = Vector<2>::Zero();
  for (const std::size_t a : {std::size_t{1}, std::size_t{2}}) {  // 0 1 3 and 0 3 2
    const Vector<2>& b = now[a == 1 ? 1 : 3];
    const Vector<2>& c = now[a == 1 ? 3 : 2];
    const double part = ((b - now[0])[0] * (c - now[0])[1] - (b - now[0])[1] * (c - now[0])[0]) / 2;
    area += part;
    centroid += part * (now[0] + b + c) / 3;
  }
  EXPECT_LE((particles.x[0] - centroid / area).norm(), rounding);
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
  const Grid<1> grid(Vector<1>(0), Vector<1>(4), h);
  for (double x = 0.61; x < 3.4; x += 0.0137) {
    Particles<1> particles;
    particles.add(Vector<1>(x), Matrix<1>(l), 1, 0);
    ShapeFunctions<1> shape;
    UniformGimp::shape(grid, particles, 0, shape);
    for (std::size_t k = 0; k < shape.size(); ++k) {
      const double s = x - grid.position(shape.node[k])[0];
      EXPECT_NEAR(shape.S[k], S(s), rounding);
      EXPECT_NEAR(shape.G[k][0], slope(s), 100 * rounding);
    }
  }
}

// The corner weights of a quadrilateral (Gong 2015, eq. 6.29, 6.30; docs/misprints.md, G23) and the
// gradients (6.32); its corners run counter-clockwise 1 2 3 4, ours are numbered by bits.
TEST(Cpdi2Cell, ClosedForms) {
  std::mt19937 random(7);
  for (int round = 0; round < 100; ++round) {
    const auto near = [&](double x, double y) {
      return Vector<2>(x + uniform(random, -0.2, 0.2), y + uniform(random, -0.2, 0.2));
    };
    const Vector<2> x1 = near(0, 0), x2 = near(1, 0), x3 = near(1, 1), x4 = near(0, 1);
    const Cpdi2::Cell<2> cell(Particles<2>::Corners{x1, x2, x4, x3});
    const auto cross = [](const Vector<2>& a, const Vector<2>& b) {
      return a[0] * b[1] - a[1] * b[0];
    };
    const double area = (cross(x3 - x1, x4 - x2)) / 2;
    const double a = (x4 - x1)[0] * (x2 - x3)[1] - (x2 - x3)[0] * (x4 - x1)[1];
    const double b = (x3 - x4)[0] * (x1 - x2)[1] - (x1 - x2)[0] * (x3 - x4)[1];
    EXPECT_NEAR(cell.volume, area, rounding);
    EXPECT_NEAR(cell.weight[0], (6 * area - a - b) / (24 * area), rounding);
    EXPECT_NEAR(cell.weight[1], (6 * area - a + b) / (24 * area), rounding);
    EXPECT_NEAR(cell.weight[3], (6 * area + a + b) / (24 * area), rounding);
    EXPECT_NEAR(cell.weight[2], (6 * area + a - b) / (24 * area), rounding);
    const auto slope = [&](const Vector<2>& from, const Vector<2>& to) {
      return Vector<2>(Vector<2>((from - to)[1], (to - from)[0]) / (2 * area));
    };
    EXPECT_LE((cell.slope[0] - slope(x2, x4)).norm(), 10 * rounding);
    EXPECT_LE((cell.slope[1] - slope(x3, x1)).norm(), 10 * rounding);
    EXPECT_LE((cell.slope[3] - slope(x4, x2)).norm(), 10 * rounding);
    EXPECT_LE((cell.slope[2] - slope(x1, x3)).norm(), 10 * rounding);
  }
}

TEST(GridCells, EdgesBelongToOneCell) {
  const Grid<1> grid(Vector<1>(0), Vector<1>(1), 0.25);
  EXPECT_EQ(grid.cell(0, 0), 0);
  EXPECT_EQ(grid.cell(-1e-18, 0), 0);
  EXPECT_EQ(grid.cell(0.25, 0), 1);
  EXPECT_EQ(grid.cell(1, 0), 3);
  EXPECT_EQ(grid.cell(1 + 1e-15, 0), 3);
  EXPECT_TRUE(grid.contains(Vector<1>(1 + 1e-15)));
  EXPECT_FALSE(grid.contains(Vector<1>(1.1)));
  EXPECT_FALSE(grid.contains(Vector<1>(std::nan(""))));
}

}  // namespace
}  // namespace recon::mpm::test
