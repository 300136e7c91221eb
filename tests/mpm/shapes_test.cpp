// What particles are to the functions of the grid: their domains, volumes, and corners that move.
#include "recon/mpm/shapes.hpp"

#include <cmath>

#include "mpm/support.hpp"

namespace recon::mpm::test {
namespace {

constexpr double rounding_of_shapes = 1e-13;

template <class T>
class Shapes : public testing::Test {};
TYPED_TEST_SUITE(Shapes, AllDimensions);

// A box keeps its reference edges (ugimp), or stretches them by the diagonal of F (cpgimp); edges
// that are not along the axes count with the box about them. Both are then the box of those edges.
TYPED_TEST(Shapes, BoxesAreKeptOrStretched) {
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
  NodeFunctions<D> shape, expected;
  const auto expect_same = [&] {
    ASSERT_EQ(shape.size(), expected.size());
    for (std::size_t k = 0; k < shape.size(); ++k) {
      EXPECT_EQ(shape.node[k], expected.node[k]);
      EXPECT_NEAR(shape.S[k], expected.S[k], rounding_of_shapes);
      EXPECT_LE((shape.G[k] - expected.G[k]).norm(), 1000 * rounding_of_shapes);
    }
  };
  for (std::size_t p = 0; p < particles.size(); ++p) {
    UniformGimp{}.shape(grid, particles, p, shape);
    UniformGimp{}.shape(grid, kept, p, expected);
    expect_same();
    StretchedGimp{}.shape(grid, particles, p, shape);
    UniformGimp{}.shape(grid, stretched, p, expected);
    expect_same();
  }
}

// The nodes of a policy lie in the rows that it announces, and the domains move and deform with the
// particle.
TYPED_TEST(Shapes, SeeTheNodesThatTheyAnnounce) {
  constexpr int D = TypeParam::value;
  std::mt19937 random(4);
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Ones(), 0.125);
  Particles<D> particles;
  for (int p = 0; p < 100; ++p) {
    Vector<D> x;
    for (int d = 0; d < D; ++d) x[d] = uniform(random, 0, 1);
    particles.add(x, 0.03 * random_deformation<D>(random, 0.2), 1, 0);
    particles.F.back() = (p % 7 == 0 ? 8.0 : 1.0) * random_deformation<D>(random, 0.3);
    particles.corners.push_back(particles.domain(particles.size() - 1));
  }
  for (const char* name : {"mpm", "ugimp", "cpgimp", "cpdi1", "cpdi2", "bspline2", "bspline3", "q9",
                           "sgmp", "impm_adjoint"})
    with_shape(method_named(name), [&](auto policy) {
      typename decltype(policy)::template Nodes<D> shape;
      for (std::size_t p = 0; p < particles.size(); ++p) {
        policy.shape(grid, particles, p, shape);
        Vector<D> centroid = Vector<D>::Zero();
        for (std::size_t k = 0; k < shape.size(); ++k) {
          const Vector<D> node = grid.position(shape.node[k]);
          centroid += shape.S[k] * node;
          for (int d = 0; d < D; ++d) {
            const std::pair<int, int> rows = policy.nodes_along(grid, particles, p, d);
            EXPECT_GE(node[d], grid.node(rows.first, d)) << name;
            EXPECT_LE(node[d], grid.node(rows.second, d)) << name;
          }
        }
        EXPECT_LE((centroid - particles.x[p]).norm(), rounding_of_shapes) << name;
      }
    });
}

// What a policy gives back is the particle's volume now, det F times that at first.
TYPED_TEST(Shapes, VolumesAreOfNow) {
  constexpr int D = TypeParam::value;
  const Grid<D> grid(Vector<D>::Zero(), Vector<D>::Ones(), 0.125);
  Particles<D> particles;
  particles.add(Vector<D>::Constant(0.4), 0.05 * Matrix<D>::Identity(), 1, 0);
  particles.F[0] = 1.25 * Matrix<D>::Identity();
  particles.corners.push_back(particles.domain(0));
  const double volume = std::pow(0.125, D);
  NodeFunctions<D> shape;
  const auto check = [&](const auto& policy, const char* name) {
    EXPECT_NEAR(policy.shape(grid, particles, 0, shape), volume, 100 * rounding_of_shapes * volume)
        << name;
  };
  check(PointShape<LinearFunctions>{}, "point");
  check(PointShape<NineNodeFunctions>{}, "q9");
  if constexpr (D == 2) check(PointShape<EightNodeFunctions>{}, "q8");
  check(PointShape<SplineFunctions<2>>{}, "bspline2");
  check(PointShape<SplineFunctions<3>>{}, "bspline3");
  check(PointShape<MomentSplineFunctions>{}, "mls_bspline2");
  check(UniformGimp{}, "ugimp");
  check(StretchedGimp{}, "cpgimp");
  check(Cpdi1{}, "cpdi1");
  check(Cpdi2{}, "cpdi2");
}

// Corners follow a velocity field, and x is their centroid: of a cell cut in simplices the mean of
// theirs, weighted by area.
TEST(Cpdi2Move, CornersFollowTheGridAndTheParticleItsCentroid) {
  Matrix<2> slope;
  slope << 0.5, -1, 0.25, 2;
  const auto velocity_at = [&](const Vector<2>& x) {
    return Vector<2>(Vector<2>(1, -2) + slope * x);
  };
  Particles<2> particles;
  particles.add(Vector<2>(0.9, 0.5), 0.1 * Matrix<2>::Identity(), 1, 0);
  const Particles<2>::Corners before{Vector<2>(0.8, 0.35), Vector<2>(1.05, 0.4),
                                     Vector<2>(0.8, 0.6), Vector<2>(0.95, 0.7)};
  particles.corners.push_back(before);
  const double dt = 0.01;
  Cpdi2::move<2>(particles, 0, velocity_at, dt);
  const auto& now = particles.corners[0];
  for (std::size_t a = 0; a < 4; ++a)
    EXPECT_LE((now[a] - before[a] - dt * velocity_at(before[a])).norm(), rounding_of_shapes);
  double area = 0;
  Vector<2> centroid = Vector<2>::Zero();
  for (const std::size_t a : {std::size_t{1}, std::size_t{2}}) {  // 0 1 3 and 0 3 2
    const Vector<2>& b = now[a == 1 ? 1 : 3];
    const Vector<2>& c = now[a == 1 ? 3 : 2];
    const double part = ((b - now[0])[0] * (c - now[0])[1] - (b - now[0])[1] * (c - now[0])[0]) / 2;
    area += part;
    centroid += part * (now[0] + b + c) / 3;
  }
  EXPECT_LE((particles.x[0] - centroid / area).norm(), rounding_of_shapes);
}

TEST(Elements, NeedAnEvenNumberOfCells) {
  for (const char* method : {"q8", "q9"}) {
    EXPECT_NO_THROW(block<2>(6, 0, 1, method).validate());
    EXPECT_THROW(block<2>(5, 0, 1, method).validate(), InvalidArgument);
  }
}

}  // namespace
}  // namespace recon::mpm::test
