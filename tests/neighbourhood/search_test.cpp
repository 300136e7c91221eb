// Every search gives the answers of brute force: same particles, same order, same bits.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "neighbourhood/neighbourhood_support.hpp"
#include "recon/neighbourhood/brute_force.hpp"
#include "recon/neighbourhood/cell_grid.hpp"
#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/neighbourhood/r_tree.hpp"

namespace recon::testing {
namespace {

template <class Scalar>
using Found = std::vector<Neighbour<Scalar>>;

// On the particles, between them, in and far outside their box.
template <class Scalar, int D>
PointList<Scalar, D> targets_for(const PointList<Scalar, D>& points) {
  auto targets = random_points<Scalar, D>(12, 99);
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 12)
    targets.push_back(points[i]);
  for (std::size_t i = 0; i + 1 < points.size(); i += 1 + points.size() / 6) {
    std::array<Scalar, D> middle;
    for (int d = 0; d < D; ++d) middle[d] = (points[i][d] + points[i + 1][d]) / 2;
    targets.push_back(middle);
  }
  for (const double far : {-3.0, 2.5, 1e4}) {
    std::array<Scalar, D> x;
    x.fill(static_cast<Scalar>(0.5));
    x[0] = static_cast<Scalar>(far);
    targets.push_back(x);
    x.fill(static_cast<Scalar>(far));
    targets.push_back(x);
  }
  return targets;
}

template <class S, class Reference>
void expect_equal(const S& search, const Reference& reference, const typename S::Point& x,
                  const char* name) {
  using Scalar = typename S::Scalar;
  Found<Scalar> found{{7, 7}}, expected;  // what was there before must go
  for (const double r : {0.0, 1e-30, 1e-6, 0.05, 0.25, 0.6, 1.0, 4.0, 2e4, 1e30}) {
    const auto radius = static_cast<Scalar>(r);
    search.within(x, radius, found);
    reference.within(x, radius, expected);
    ASSERT_EQ(found, expected) << name << " within " << radius;
    auto lower = x, upper = x;
    for (std::size_t d = 0; d < x.size(); ++d) {
      lower[d] -= radius;
      upper[d] += d == 0 ? radius : radius / 4;
    }
    search.in_box(lower, upper, found);
    reference.in_box(lower, upper, expected);
    ASSERT_EQ(found, expected) << name << " in box of " << radius;
    for (const std::size_t k : {1, 5, 1000}) {
      search.nearest_within(x, k, radius, found);
      reference.nearest_within(x, k, radius, expected);
      ASSERT_EQ(found, expected) << name << " nearest " << k << " within " << radius;
    }
  }
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{7},
                              std::size_t{27}, reference.size(), reference.size() + 1, SIZE_MAX}) {
    search.nearest(x, k, found);
    reference.nearest(x, k, expected);
    ASSERT_EQ(found, expected) << name << " nearest " << k;
  }
}

template <class Scalar, int D>
void expect_all_searches_equal(const PointList<Scalar, D>& points,
                               const PointList<Scalar, D>& targets) {
  const auto cloud = cloud_of(points);
  const BruteForce<Scalar, D> reference(cloud);
  const KdTree<Scalar, D> kd_tree(cloud);
  const RTree<Scalar, D> r_tree(cloud);
  const CellGrid<Scalar, D> grid(cloud), fine(cloud, 0.01), coarse(cloud, 100);
  for (const auto& x : targets) {
    expect_equal(kd_tree, reference, x, "k-d tree");
    expect_equal(r_tree, reference, x, "R-tree");
    expect_equal(grid, reference, x, "cell grid");
    expect_equal(fine, reference, x, "fine cell grid");
    expect_equal(coarse, reference, x, "coarse cell grid");
    if (::testing::Test::HasFatalFailure()) return;
  }
}

template <class Space>
class Search : public ::testing::Test {};
TYPED_TEST_SUITE(Search, Spaces);

TYPED_TEST(Search, EqualsBruteForceOnHostileClouds) {
  using Scalar = typename TypeParam::Scalar;
  for (const auto& [name, points] : hostile_clouds<Scalar, TypeParam::D>()) {
    SCOPED_TRACE(name);
    expect_all_searches_equal<Scalar, TypeParam::D>(points,
                                                    targets_for<Scalar, TypeParam::D>(points));
    if (this->HasFatalFailure()) return;
  }
}

// Far from the origin floats are so coarse that nearly all distances are ties.
TYPED_TEST(Search, EqualsBruteForceFarFromTheOrigin) {
  using Scalar = typename TypeParam::Scalar;
  for (auto [name, points] : hostile_clouds<Scalar, TypeParam::D>()) {
    SCOPED_TRACE(name);
    auto targets = targets_for<Scalar, TypeParam::D>(points);
    for (auto* list : {&points, &targets})
      for (auto& x : *list)
        for (auto& c : x) c += Scalar(1e6);
    expect_all_searches_equal<Scalar, TypeParam::D>(points, targets);
    if (this->HasFatalFailure()) return;
  }
}

// Squares of distances underflow here, and everything is as near as everything else.
TYPED_TEST(Search, EqualsBruteForceWhereSquaresUnderflow) {
  using Scalar = typename TypeParam::Scalar;
  const auto tiny = std::numeric_limits<Scalar>::min() * 8;
  auto points = random_points<Scalar, TypeParam::D>(60, 21);
  auto targets = points;
  for (auto* list : {&points, &targets})
    for (auto& x : *list)
      for (auto& c : x) c *= tiny;
  const auto cloud = cloud_of(points);
  const BruteForce<Scalar, TypeParam::D> reference(cloud);
  for (const auto& x : targets) {
    expect_equal(KdTree<Scalar, TypeParam::D>(cloud), reference, x, "k-d tree");
    expect_equal(RTree<Scalar, TypeParam::D>(cloud), reference, x, "R-tree");
    expect_equal(CellGrid<Scalar, TypeParam::D>(cloud), reference, x, "cell grid");
    if (this->HasFatalFailure()) return;
  }
}

// A node of a lattice: the second nearest is shared by 2 D nodes, and the one with the
// smallest index wins.
TYPED_TEST(Search, TiesGoToTheSmallerIndex) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  PointList<Scalar, D> points = regular_points<Scalar, D>(5);
  for (auto& x : points)
    for (auto& c : x) c = std::round(5 * c - Scalar(0.5));  // whole numbers: exact ties
  const std::size_t middle = points.size() / 2, layer = points.size() / 5;
  const Found<Scalar> expected{{static_cast<ParticleIndex>(middle), 0},
                               {static_cast<ParticleIndex>(middle - layer), 1}};
  const auto cloud = cloud_of(points);
  Found<Scalar> found;
  BruteForce<Scalar, D>(cloud).nearest(points[middle], 2, found);
  EXPECT_EQ(found, expected);
  KdTree<Scalar, D>(cloud).nearest(points[middle], 2, found);
  EXPECT_EQ(found, expected);
  RTree<Scalar, D>(cloud).nearest(points[middle], 2, found);
  EXPECT_EQ(found, expected);
  CellGrid<Scalar, D>(cloud).nearest(points[middle], 2, found);
  EXPECT_EQ(found, expected);
}

template <class S>
void expect_wrong_input_is_named(const S& search) {
  using Scalar = typename S::Scalar;
  typename S::Point x{}, bad{};
  bad[0] = std::numeric_limits<Scalar>::quiet_NaN();
  Found<Scalar> found;
  const Scalar infinity = std::numeric_limits<Scalar>::infinity();
  EXPECT_EQ(blamed([&] { search.within(x, Scalar(-1), found); }), "radius");
  EXPECT_EQ(blamed([&] { search.within(x, bad[0], found); }), "radius");
  EXPECT_EQ(blamed([&] { search.within(x, infinity, found); }), "radius");
  EXPECT_EQ(blamed([&] { search.nearest_within(x, 3, Scalar(-1), found); }), "radius");
  EXPECT_EQ(blamed([&] { search.within(bad, Scalar(1), found); }),
            "coordinate x of the query point");
  EXPECT_EQ(blamed([&] { search.nearest(bad, 1, found); }), "coordinate x of the query point");
  EXPECT_EQ(blamed([&] { search.in_box(bad, x, found); }), "coordinate x of the lower corner");
  EXPECT_EQ(blamed([&] { search.in_box(x, bad, found); }), "coordinate x of the upper corner");
  x[0] = std::sqrt(std::numeric_limits<Scalar>::max());
  EXPECT_EQ(blamed([&] { search.nearest(x, 1, found); }), "squared size of the query point");
}

TYPED_TEST(Search, WrongInputIsNamed) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D, other = D % 3 + 1;
  const auto cloud = cloud_of(random_points<Scalar, D>(20, 1));
  expect_wrong_input_is_named(BruteForce<Scalar, D>(cloud));
  expect_wrong_input_is_named(KdTree<Scalar, D>(cloud));
  expect_wrong_input_is_named(RTree<Scalar, D>(cloud));
  expect_wrong_input_is_named(CellGrid<Scalar, D>(cloud));
  const auto wrong = cloud_of(random_points<Scalar, other>(20, 1));
  EXPECT_EQ(blamed([&] { BruteForce<Scalar, D>{wrong}; }), "dimension of the points");
  EXPECT_EQ(blamed([&] { KdTree<Scalar, D>{wrong}; }), "dimension of the points");
  EXPECT_EQ(blamed([&] { RTree<Scalar, D>{wrong}; }), "dimension of the points");
  EXPECT_EQ(blamed([&] { CellGrid<Scalar, D>{wrong}; }), "dimension of the points");
  EXPECT_EQ(blamed([&] { CellGrid<Scalar, D>(cloud, 0); }), "cell_size");
  EXPECT_EQ(blamed([&] { CellGrid<Scalar, D>(cloud, -NAN); }), "cell_size");
}

TEST(SearchMessage, HasArgumentValueAndRule) {
  const auto cloud = cloud_of(random_points<double, 2>(20, 1));
  Found<double> found;
  try {
    KdTree<double, 2>(cloud).within({0, 0}, -0.5, found);
    FAIL() << "a negative radius was accepted";
  } catch (const InvalidArgument& error) {
    EXPECT_STREQ(error.what(), "radius = -0.5: must be at least 0 and finite");
  }
}

// One stray particle, or clusters, may make the cells large but not many.
TYPED_TEST(Search, CellsAreLimitedByTheNumberOfParticles) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  auto points = random_points<Scalar, D>(500, 3);
  points.back().fill(Scalar(1e6));
  const auto cloud = cloud_of(points);
  for (const double size : {0.01, 1e-6, 1e-300, 5e-324})
    EXPECT_LE((CellGrid<Scalar, D>(cloud, size).cells()), 4 * points.size()) << size;
  EXPECT_LE((CellGrid<Scalar, D>(cloud).cells()), 4 * points.size());
  const auto clusters = cloud_of(clustered_points<Scalar, D>(500, 4, 1e-6, 3));
  EXPECT_LE((CellGrid<Scalar, D>(clusters, 1e-7).cells()), 4 * points.size());
  EXPECT_EQ((CellGrid<Scalar, D>(cloud_of(PointList<Scalar, D>(3)), 0.1).cells()), 1u);
  // and where nothing is extreme the size asked for is kept
  const auto even = cloud_of(regular_points<Scalar, D>(D == 1 ? 1000 : 10));
  EXPECT_EQ((CellGrid<Scalar, D>(even, 0.25).cell_size()), 0.25);
  expect_equal(CellGrid<Scalar, D>(cloud, 0.01), BruteForce<Scalar, D>(cloud), points[0], "stray");
}

}  // namespace
}  // namespace recon::testing
