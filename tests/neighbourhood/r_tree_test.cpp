// Particles that come, go and move: after every change the R-tree equals brute force
// over those alive.
#include "recon/neighbourhood/r_tree.hpp"

#include <gtest/gtest.h>

#include <map>

#include "neighbourhood/neighbourhood_support.hpp"
#include "recon/neighbourhood/brute_force.hpp"

namespace recon::testing {
namespace {

template <class Space>
class MovingParticles : public ::testing::Test {};
TYPED_TEST_SUITE(MovingParticles, Spaces);

TYPED_TEST(MovingParticles, EqualBruteForceOverTheLiving) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto start = random_points<Scalar, D>(60, 31);
  RTree<Scalar, D> tree(cloud_of(start));
  std::map<ParticleIndex, std::array<Scalar, D>> living;
  for (std::size_t i = 0; i < start.size(); ++i) living[static_cast<ParticleIndex>(i)] = start[i];

  RandomNumbers random(5);
  const auto anywhere = [&] {  // on a coarse lattice, so that duplicates and ties are common
    std::array<Scalar, D> x;
    for (auto& c : x) c = static_cast<Scalar>(static_cast<double>(random.next() % 8) / 8);
    return x;
  };
  std::vector<Neighbour<Scalar>> found, expected;
  for (int step = 0; step < 300; ++step) {
    const auto particle = static_cast<ParticleIndex>(random.next() % 80);
    const auto x = anywhere();
    if (!living.count(particle)) {
      EXPECT_FALSE(tree.contains(particle));
      tree.insert(particle, x);
      living[particle] = x;
    } else if (random.next() % 2 == 0) {
      tree.move(particle, x);
      living[particle] = x;
    } else {
      tree.erase(particle);
      living.erase(particle);
    }
    ASSERT_EQ(tree.size(), living.size());

    PointList<Scalar, D> points;
    std::vector<ParticleIndex> index;
    for (const auto& [i, at] : living) {
      index.push_back(i);
      points.push_back(at);
    }
    const BruteForce<Scalar, D> reference(cloud_of(points));
    const auto expect_same = [&] {
      for (auto& neighbour : expected) neighbour.index = index[neighbour.index];
      ASSERT_EQ(found, expected) << "after step " << step;
    };
    const auto target = anywhere();
    auto upper = target;
    for (auto& c : upper) c += Scalar(0.25);
    tree.nearest(target, 7, found);
    reference.nearest(target, 7, expected);
    expect_same();
    tree.within(target, Scalar(0.25), found);
    reference.within(target, Scalar(0.25), expected);
    expect_same();
    tree.in_box(target, upper, found);
    reference.in_box(target, upper, expected);
    expect_same();
    if (this->HasFatalFailure()) return;
  }
}

TEST(MovingParticle, WrongIndicesAreNamed) {
  RTree<double, 2> tree;
  EXPECT_EQ(tree.size(), 0u);
  tree.insert(3, {0.5, 0.5});
  EXPECT_EQ(blamed([&] { tree.insert(3, {0, 0}); }), "particle");
  EXPECT_EQ(blamed([&] { tree.erase(2); }), "particle");
  EXPECT_EQ(blamed([&] { tree.move(4, {0, 0}); }), "particle");
  EXPECT_EQ(blamed([&] { tree.move(3, {NAN, 0}); }), "coordinate x of the query point");
  EXPECT_TRUE(tree.contains(3));  // the failed move changed nothing
  tree.erase(3);
  EXPECT_FALSE(tree.contains(3));
}

}  // namespace
}  // namespace recon::testing
