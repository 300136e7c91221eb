#include "recon/points/spatial_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "recon/points/generate.hpp"
#include "recon/points/make_view.hpp"

namespace recon {
namespace {

template <int D>
void expect_permutation(const PointList<double, D>& points) {
  const PointCloud<double> cloud(points_of(points));
  const auto order = spatial_order(cloud, 1);
  ASSERT_EQ(order.size(), points.size());
  auto all = order;
  std::sort(all.begin(), all.end());
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], i);
  const auto sorted = cloud.permuted(order);
  for (std::size_t i = 0; i < all.size(); ++i)
    for (int d = 0; d < D; ++d) EXPECT_EQ(sorted(i, d), points[order[i]][d]);
  EXPECT_EQ(order, spatial_order(cloud, 3));
}

TEST(SpatialOrder, IsAPermutationWhateverThePoints) {
  expect_permutation<1>(random_points<double, 1>(40000, 1));
  expect_permutation<2>(random_points<double, 2>(70000, 2));
  expect_permutation<3>(random_points<double, 3>(50000, 3));
  expect_permutation<3>({});
  expect_permutation<2>({{1, 2}});
  expect_permutation<3>(PointList<double, 3>(1000, {4, 5, 6}));
  auto far = random_points<double, 2>(5000, 4);
  far[17] = {1e100, -1e-300};
  expect_permutation<2>(far);
}

// In a cube of n random points, steps of a random order are 0.66 long on average; along the curve
// they are a few spacings n^(-1/3).
TEST(SpatialOrder, StepsAreShort) {
  const auto points = random_points<double, 3>(100000, 1);
  const PointCloud<double> cloud(points_of(points));
  const auto sorted = cloud.permuted(spatial_order(cloud));
  EXPECT_FALSE(is_spatially_ordered(cloud));
  EXPECT_TRUE(is_spatially_ordered(sorted));
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    double square = 0;
    for (int d = 0; d < 3; ++d) square += std::pow(sorted(i, d) - sorted(i - 1, d), 2);
    length += std::sqrt(square);
  }
  EXPECT_LT(length / 100000, 3 * std::cbrt(1e-5));
}

TEST(SpatialOrder, GridsAreInOrder) {
  PointList<double, 2> nodes;
  for (int j = 0; j < 50; ++j)
    for (int i = 0; i < 80; ++i) nodes.push_back({0.1 * i, 0.1 * j});
  EXPECT_TRUE(is_spatially_ordered(PointCloud<double>(points_of(nodes))));
}

}  // namespace
}  // namespace recon
