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
