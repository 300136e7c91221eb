// Every way to view particle data reads the right numbers, and bad ones are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/register/point.hpp>
#include <deque>
#include <list>

#include "recon/points/boost_geometry.hpp"
#include "recon/points/generate.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/point_cloud.hpp"
#include "recon/points/structured_grid.hpp"

// A registered type whose coordinates are reached through functions only.
class Hidden {
 public:
  Hidden() = default;
  Hidden(double a, double b) : b_(b), a_(a) {}
  double a() const { return a_; }
  double b() const { return b_; }
  void set_a(double v) { a_ = v; }
  void set_b(double v) { b_ = v; }

 private:
  double b_ = 0, a_ = 0;
};
BOOST_GEOMETRY_REGISTER_POINT_2D_GET_SET(Hidden, double, boost::geometry::cs::cartesian, a, b,
                                         set_a, set_b)

namespace recon {
namespace {

struct Grain {
  char tag;
  std::array<double, 3> position;
  float temperature;
  double velocity[2];
  Eigen::Matrix3d stress;
};
struct Float3 {
  float x, y, z;
};
struct Double2 {
  double x, y;
};

TEST(Views, MembersOfYourOwnStruct) {
  std::vector<Grain> grains(3);
  grains[2].position = {1, 2, 3};
  grains[1].velocity[1] = 7;
  grains[1].temperature = 4;
  grains[2].stress.setZero();
  grains[2].stress(1, 2) = 5;
  const auto x = points_of(grains, &Grain::position);
  EXPECT_EQ(x.size(), 3u);
  EXPECT_EQ(x.dimension(), 3);
  EXPECT_EQ(x(2, 0), 1);
  EXPECT_EQ(x(2, 2), 3);
  EXPECT_EQ(points_of(grains, &Grain::velocity)(1, 1), 7);
  const auto t = field_of(grains, &Grain::temperature);
  static_assert(std::is_same_v<decltype(t)::scalar_type, float>);
  EXPECT_EQ(t(1, 0), 4);
  const auto s = field_of(grains, &Grain::stress);
  EXPECT_EQ(s.components(), 9);
  EXPECT_EQ(s(2, 7), 5);  // column-major, as it lies
  t(0, 0) = 9;            // the data are not const: the view writes through
  EXPECT_EQ(grains[0].temperature, 9);
  const auto& constant = grains;
  static_assert(std::is_const_v<
                std::remove_reference_t<decltype(field_of(constant, &Grain::temperature)(0, 0))>>);
}

TEST(Views, ArraysOfCoordinates) {
  std::vector<Float3> a{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(points_of(a)(1, 2), 6);
  static_assert(std::is_same_v<decltype(points_of(a)), PointsView<float>>);
  std::vector<Double2> b{{1, 2}, {3, 4}};
  EXPECT_EQ(points_of(b).dimension(), 2);
  EXPECT_EQ(points_of(b)(1, 0), 3);
  std::vector<Eigen::Vector3d> c{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(points_of(c)(1, 1), 5);
  std::vector<double> d{1, 2, 3};
  EXPECT_EQ(points_of(d).dimension(), 1);
  EXPECT_EQ(points_of(std::span<const double>(d).subspan(1))(0, 0), 2);
  double e[2][3] = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(points_of(e)(1, 0), 4);
  const std::array<std::array<float, 2>, 2> f{{{1, 2}, {3, 4}}};
  EXPECT_EQ(points_of(f)(1, 1), 4);
}

TEST(Views, OneArrayPerAxisAndFlat) {
  const std::vector<double> x{1, 2}, y{3, 4}, z{5, 6}, flat{1, 2, 3, 4, 5, 6};
  EXPECT_EQ(points_of(x, y)(1, 1), 4);
  EXPECT_EQ(points_of(x, y, z)(0, 2), 5);
  EXPECT_EQ(points_of_flat(flat, 3)(1, 0), 4);
  EXPECT_EQ(points_of_flat(flat, 2)(2, 1), 6);
  EXPECT_EQ(field_of_flat(flat, 3)(1, 2), 6);
  EXPECT_THROW(points_of_flat(flat, 4), InvalidArgument);
  EXPECT_THROW(field_of_flat(flat, 5), InvalidArgument);
  EXPECT_THROW(points_of(x, flat), InvalidArgument);
}

TEST(Views, EigenMatricesInAnyOrder) {
  Eigen::MatrixXd columns(4, 3);
  for (int i = 0; i < 12; ++i) columns(i / 3, i % 3) = i;
  const Eigen::Matrix<double, 4, 3, Eigen::RowMajor> rows = columns;
  const Eigen::MatrixXd across = columns.transpose();
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(points_of(columns)(i, d), 3 * i + d);
      EXPECT_EQ(points_of(rows)(i, d), 3 * i + d);
      EXPECT_EQ(points_of(across.transpose())(i, d), 3 * i + d);
      EXPECT_EQ(field_of(columns)(i, d), 3 * i + d);
    }
  EXPECT_EQ(points_of(columns.block(1, 0, 2, 2))(1, 1), 7);
  EXPECT_THROW(points_of(across), InvalidArgument);  // 4 columns: points are rows
  auto writable = field_of(columns);
  writable(2, 1) = -1;
  EXPECT_EQ(columns(2, 1), -1);
}

TEST(Views, BoostGeometryPoints) {
  const std::vector<boost::geometry::model::d2::point_xy<double>> a{{1, 2}, {3, 4}};
  EXPECT_EQ(points_of(a).dimension(), 2);
  EXPECT_EQ(points_of(a)(1, 0), 3);
  const std::vector<boost::geometry::model::point<float, 3, boost::geometry::cs::cartesian>> b{
      {1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(points_of(b)(1, 2), 6);
  const std::vector<Hidden> c{{1, 2}, {3, 4}};
  EXPECT_EQ(points_of(c)(1, 0), 3);
  EXPECT_EQ(points_of(c)(0, 1), 2);
}

template <class T>
concept Viewable = requires(T&& t) {
  points_of(std::forward<T>(t));
};
// Temporaries that own their numbers, and containers that are not contiguous, have no views.
static_assert(Viewable<std::vector<double>&> && Viewable<std::span<const double>>);
static_assert(!Viewable<std::vector<double>> && !Viewable<std::vector<std::array<double, 3>>>);
static_assert(!Viewable<std::list<double>&> && !Viewable<std::deque<double>&>);
static_assert(!Viewable<std::vector<int>&> && !Viewable<std::vector<std::string>&>);

TEST(Views, EmptyContainers) {
  std::vector<Grain> none;
  EXPECT_EQ(points_of(none, &Grain::position).size(), 0u);
  EXPECT_EQ(points_of(none, &Grain::position).dimension(), 3);
  EXPECT_EQ(field_of(none, &Grain::stress).components(), 9);
}

TEST(PointCloud, WrapsAndChecks) {
  std::vector<double> x{-0.25, 0.5, 3.75, 1.0, -1e-18};
  PeriodicDomain<double> unit{{0}, {1}, {true}};
  const PointCloud<double> cloud(points_of(x), "points", unit);
  EXPECT_EQ(cloud(0, 0), 0.75);
  EXPECT_EQ(cloud(1, 0), 0.5);
  EXPECT_EQ(cloud(2, 0), 0.75);
  EXPECT_EQ(cloud(3, 0), 0.0);
  EXPECT_GE(cloud(4, 0), 0.0);  // a hair outside: in [0, 1) all the same
  EXPECT_LT(cloud(4, 0), 1.0);
  x[1] = 1e200;
  EXPECT_THROW(PointCloud<double>(points_of(x)), InvalidArgument);  // its square overflows
  x[1] = std::nan("");
  EXPECT_THROW(PointCloud<double>(points_of(x)), InvalidArgument);
  EXPECT_THROW(PointCloud<double>(points_of(x), "points", {{0}, {0}, {true}}), InvalidArgument);
}

TEST(StructuredGrid, CoversTheBoxAndFitsThePeriod) {
  Box<double> box{{-0.1, 0, 0.3}, {1.0, 2, 0.7}, 3};
  PeriodicDomain<double> domain{{0, 0, 0}, {0, 2.1, 0}, {false, true, false}};
  const auto grid = covering_grid(box, 0.25, domain);
  EXPECT_EQ(grid.origin[0], -0.25);
  EXPECT_EQ(grid.counts[0], 6u);  // -0.25 ... 1.0
  EXPECT_EQ(grid.counts[1], 9u);  // 2.1 / 9, the node at 2.1 being the one at 0
  EXPECT_NEAR(grid.spacing[1] * 9, 2.1, 1e-15);
  EXPECT_EQ(grid.origin[2], 0.25);
  EXPECT_EQ(grid.counts[2], 3u);
  const auto nodes = grid.nodes();
  EXPECT_EQ(nodes.view().size(), grid.size());
  EXPECT_EQ(nodes.view()(1, 0), 0.0);  // x runs fastest
  EXPECT_EQ(nodes.view()(6, 1), grid.spacing[1]);
  const StructuredGrid<double> plane{.dimension = 2, .spacing = {0.5, 0.5}, .counts = {3, 2}};
  EXPECT_EQ(plane.size(), 6u);  // the third axis is not the caller's business
  EXPECT_EQ(plane.nodes().view()(5, 1), 0.5);
  EXPECT_THROW(covering_grid(box, 0.0), InvalidArgument);
  EXPECT_THROW(covering_grid(box, 1e-9), InvalidArgument);  // too many nodes
  EXPECT_THROW(covering_grid(Box<double>::empty(2), 1.0), InvalidArgument);
}

// The generator gives the same clouds everywhere: these digits are part of its contract.
TEST(Generate, IsReproducible) {
  RandomNumbers random(1);
  EXPECT_EQ(random.next(), 10451216379200822465ull);
  const auto points = random_points<double, 2>(2, 42);
  EXPECT_DOUBLE_EQ(points[0][0], 0.74156487877182331);
  for (const auto& x : sphere_points<double, 3>(20, 0.3, 1))
    EXPECT_NEAR(std::hypot(x[0] - 0.5, x[1] - 0.5, x[2] - 0.5), 0.3, 1e-15);
}

}  // namespace
}  // namespace recon
