// Images in planes of symmetry: fields that are symmetric are the same fields seen in them.
#include "recon/transfer/images.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/space.hpp"

namespace recon {
namespace {

using test::AllDimensions;
using test::uniform;

template <class T>
class MirroredFields : public ::testing::Test {};
TYPED_TEST_SUITE(MirroredFields, AllDimensions);

// A vector field and a tensor field that are symmetric in the planes x_d = 0 of all axes: made of a
// scalar that is even in all coordinates, u_d = x_d s and sigma_de = x_d x_e s off the diagonal.
// Their values at images are those that the images get.
TYPED_TEST(MirroredFields, AreSeenBeyondThePlanes) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid(SpaceVector<D>::Zero(), SpaceVector<D>::Ones(), 0.1);
  Images<D> images(grid, 0.2);
  EXPECT_TRUE(images.empty());
  for (int d = 0; d < D; ++d) images.mirror(d, false);
  EXPECT_FALSE(images.empty());
  const auto scalar = [](const SpaceVector<D>& x) { return 1 + x.squaredNorm(); };
  const auto vector = [&](const SpaceVector<D>& x) { return SpaceVector<D>(x * scalar(x)); };
  const auto tensor = [&](const SpaceVector<D>& x, int r, int c) {
    return r == c ? scalar(x) : x[r] * x[c] * scalar(x);
  };
  std::mt19937 random(5);
  std::vector<SpaceVector<D>> places(200), vectors;
  for (auto& x : places)
    for (int d = 0; d < D; ++d) x[d] = uniform(random, 0, 1);
  RowsOfParticles rows(200, D * D + 1);
  std::vector<Parity> parities{scalar_parity};
  for (int r = 0; r < D; ++r)
    for (int c = 0; c < D; ++c) parities.push_back(tensor_parity(r, c));
  const auto row_of = [&](const SpaceVector<D>& x) {
    Eigen::RowVectorXd row(D * D + 1);
    row[0] = scalar(x);
    for (int r = 0; r < D; ++r)
      for (int c = 0; c < D; ++c) row[1 + r * D + c] = tensor(x, r, c);
    return row;
  };
  for (const auto& x : places) {
    rows.row(static_cast<Eigen::Index>(vectors.size())) = row_of(x);
    vectors.push_back(vector(x));
  }
  const auto seen = images.of(places);
  const auto all_places = with_places(places, seen), all_vectors = with_vectors(vectors, seen);
  append_rows(rows, seen, parities);
  ASSERT_EQ(all_places.size(), 200 + seen.size());
  ASSERT_EQ(static_cast<std::size_t>(rows.rows()), all_places.size());
  for (std::size_t i = 0; i < all_places.size(); ++i) {
    EXPECT_LE((all_vectors[i] - vector(all_places[i])).norm(), 1e-15);
    EXPECT_LE((rows.row(static_cast<Eigen::Index>(i)) - row_of(all_places[i])).norm(), 1e-15);
  }
  // As many as there are ways to mirror each place that stay within reach.
  std::size_t expected = 0;
  for (const auto& x : places) expected += (1u << (x.array() <= 0.2).count()) - 1;
  EXPECT_EQ(seen.size(), expected);
}

// Between two mirrors a place has images at 2 a - x, and at both again and again as far as the
// reach goes: those of a cosine that both mirrors leave as it is.
TEST(Mirrors, FaceEachOther) {
  const CartesianGrid<1> grid(SpaceVector<1>(1.0), SpaceVector<1>(1.5), 0.25);
  Images<1> images(grid, 1.2);
  images.mirror(0, false);
  images.mirror(0, true);
  const auto seen = images.of({SpaceVector<1>(1.1)});
  std::vector<double> places;
  for (const auto& image : seen) {
    places.push_back(image.x[0]);
    EXPECT_EQ(image.mirrored, std::abs(std::remainder(image.x[0] - 1.1, 1.0)) < 1e-12 ? 0u : 1u);
  }
  std::sort(places.begin(), places.end());
  const std::vector<double> expected{-0.1, 0.1, 0.9, 1.9, 2.1};  // 2.7 is the reach's end
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_NEAR(places[i], expected[i], 1e-14);
}

// A vector field that is odd in x = 0.32 in all its components and even, with the component along y
// odd, in y = 0.71; and one that is odd in two planes of an axis, so that it repeats itself.
TEST(Mirrors, AreOddWhereAWallHoldsAll) {
  const CartesianGrid<2> grid({0, 0}, {1, 1}, 0.1);
  Images<2> images(grid, 0.3);
  images.mirror(0, false, 0.32, Mirror::odd);
  images.mirror(1, true, 0.71, Mirror::even);
  const auto field = [](const SpaceVector<2>& x) {
    const double odd = std::sin(3 * (x[0] - 0.32)), y = x[1] - 0.71;
    return SpaceVector<2>(odd * std::cos(2 * y), odd * std::sin(5 * y));
  };
  std::mt19937 random(7);
  std::vector<SpaceVector<2>> places(100), vectors;
  for (auto& x : places) {
    x = {uniform(random, 0.32, 1), uniform(random, 0, 0.71)};
    vectors.push_back(field(x));
  }
  const auto seen = images.of(places);
  const auto all = with_vectors(vectors, seen);
  std::size_t corners = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_LE((all[100 + i] - field(seen[i].x)).norm(), 1e-15);
    EXPECT_GE(seen[i].x[0], 0.32 - 0.3);
    EXPECT_LE(seen[i].x[1], 0.71 + 0.3);
    corners += seen[i].mirrored == 3 ? 1 : 0;
  }
  EXPECT_GT(corners, 5u);

  Images<2> between(grid, 1.5);
  between.mirror(0, true, 0.9, Mirror::even);
  between.mirror(0, false, 0.4, Mirror::odd);  // a quarter of a wave of length 2
  const auto wave = [](double x) { return std::sin(std::acos(-1) * (x - 0.4)); };
  const auto across = between.of({SpaceVector<2>(0.55, 0.5)});
  EXPECT_EQ(across.size(), 6u);
  for (const auto& image : across) {
    const SpaceVector<2> v = image.vector({1, 1});
    // Along the axis even mirrors turn the component, across it they do not.
    EXPECT_NEAR(v[1] * wave(0.55), wave(image.x[0]), 1e-14) << image.x[0];
    EXPECT_EQ(std::abs(v[0]), 1);
  }
}

// The images of a period are those of a field that repeats itself, several times within the reach.
TEST(Periods, RepeatThemselves) {
  const CartesianGrid<1> grid(SpaceVector<1>(0.0), SpaceVector<1>(2.0), 0.1);
  Images<1> images(grid, 0.5);
  images.repeat(0, 0.7, 1.0);
  const auto seen = images.of({SpaceVector<1>(0.75)});
  std::vector<double> places;
  for (const auto& image : seen) {
    places.push_back(image.x[0]);
    EXPECT_EQ(image.mirrored, 0u);
    EXPECT_EQ(image.reversed, 0u);
  }
  std::sort(places.begin(), places.end());
  const std::vector<double> expected{0.45, 1.05, 1.35};
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_NEAR(places[i], expected[i], 1e-14);

  EXPECT_THROW(images.mirror(0, false), InvalidArgument);
  EXPECT_THROW(images.repeat(1, 0, 1), InvalidArgument);
  EXPECT_THROW(images.repeat(0, 1, 1), InvalidArgument);
  EXPECT_THROW(images.repeat(0, 0, NAN), InvalidArgument);
  Images<1> mirrors(grid, 0.5);
  EXPECT_THROW(mirrors.mirror(0, false, NAN, Mirror::odd), InvalidArgument);
  mirrors.mirror(0, false, 0.5, Mirror::odd);
  EXPECT_THROW(mirrors.mirror(0, true, 0.4, Mirror::odd), InvalidArgument);
  EXPECT_THROW(mirrors.repeat(0, 0, 1), InvalidArgument);
}

TEST(Mirrors, RefuseWhatTheyCannotMirror) {
  const CartesianGrid<2> grid({0, 0}, {1, 1}, 0.5);
  EXPECT_THROW(Images<2>(grid, 0), InvalidArgument);
  EXPECT_THROW(Images<2>(grid, NAN), InvalidArgument);
  EXPECT_THROW(Images<2>(CartesianGrid<2>(), 1), InvalidArgument);
  Images<2> images(grid, 0.1);
  EXPECT_THROW(images.mirror(2, false), InvalidArgument);
  images.mirror(1, true);
  EXPECT_THROW(images.of({SpaceVector<2>(0, NAN)}), InvalidArgument);
  const auto seen = images.of({SpaceVector<2>(0, 0), SpaceVector<2>(0, 0.95)});
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].of, 1u);
  EXPECT_THROW(with_places({SpaceVector<2>(0, 0)}, seen), InvalidArgument);
  EXPECT_THROW(with_vectors({SpaceVector<2>(0, 0)}, seen), InvalidArgument);
  RowsOfParticles rows(2, 3);
  EXPECT_THROW(append_rows(rows, seen, std::vector<Parity>(2)), InvalidArgument);
}

}  // namespace
}  // namespace recon
