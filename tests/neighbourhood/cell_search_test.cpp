// The batch search by cells gives the list of brute force, for every instruction set and any number
// of threads, on clouds large enough to have many cells, bands of rows and blocks of targets.
#include <gtest/gtest.h>

#include <cmath>

#include "neighbourhood/neighbourhood_support.hpp"
#include "recon/core/instruction_set.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::testing {
namespace {

template <class Scalar>
void expect_same(const NeighbourList<Scalar>& list, const NeighbourList<Scalar>& expected) {
  ASSERT_EQ(list.offsets, expected.offsets);
  ASSERT_EQ(list.indices, expected.indices);
  ASSERT_EQ(list.shifts, expected.shifts);
  ASSERT_EQ(list.support, expected.support);
}

// By cells with every instruction set, and as find_neighbours would choose.
template <class Scalar>
void expect_reference(const PointCloud<Scalar>& particles, const PointCloud<Scalar>& targets,
                      const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain = {},
                      NeighbourOptions options = {},
                      SearchMethod reference = SearchMethod::brute_force) {
  options.search = reference;
  const auto expected = find_neighbours(particles, targets, rule, domain, options);
  options.search = SearchMethod::cell_grid;
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(std::string(name_of(set)));
    options.instruction_set = set;
    expect_same(find_neighbours(particles, targets, rule, domain, options), expected);
    if (::testing::Test::HasFatalFailure()) return;
  }
  options.search = SearchMethod::automatic;
  for (options.threads = 1; options.threads <= 3; ++options.threads) {
    SCOPED_TRACE("threads " + std::to_string(options.threads));
    expect_same(find_neighbours(particles, targets, rule, domain, options), expected);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

template <class Scalar, int D>
struct Scene {
  std::string name;
  PointList<Scalar, D> particles, targets;
};

// In the box of the particles, on them, and outside: just so, far, and very far.
template <class Scalar, int D>
PointList<Scalar, D> targets_around(const PointList<Scalar, D>& particles, std::size_t count) {
  auto targets = random_points<Scalar, D>(count, 41);
  for (std::size_t i = 0; i < count / 4; ++i) targets[i] = particles[7 * i % particles.size()];
  for (std::size_t i = count / 4; i < count / 3; ++i) targets[i][i % D] += Scalar(i % 2 ? 1 : -0.3);
  targets.back().fill(Scalar(50));
  targets[count - 2].fill(Scalar(-1e4));
  return targets;
}

template <class Scalar, int D>
std::vector<Scene<Scalar, D>> scenes() {
  constexpr std::size_t n = 1000, per_axis = D == 1 ? 800 : D == 2 ? 30 : 10, m = 100;
  std::vector<Scene<Scalar, D>> all;
  const auto add = [&](const char* name, const PointList<Scalar, D>& particles) {
    all.push_back({name, particles, targets_around<Scalar, D>(particles, m)});
  };
  add("random", random_points<Scalar, D>(n, 1));
  add("jittered", jittered_points<Scalar, D>(per_axis, 0.3, 2));
  auto lattice = regular_points<Scalar, D>(per_axis);
  for (auto& x : lattice)  // whole numbers / 64: ties are exact
    for (auto& c : x) c = std::round(c * Scalar(per_axis) - Scalar(0.5)) / 64;
  add("lattice", lattice);
  add("duplicated", duplicated_points<Scalar, D>(n / 5, 5, 3));
  add("many in one place", duplicated_points<Scalar, D>(4, n / 8, 3));
  add("clustered", clustered_points<Scalar, D>(n, 20, 0.01, 4));
  add("clustered at 1e-5", clustered_points<Scalar, D>(n, 4, 1e-5, 5));
  add("on a sphere", sphere_points<Scalar, D>(n, 0.4, 6));
  add("on the diagonal", diagonal_points<Scalar, D>(n, 7));
  add("collinear", flat_points<Scalar, D>(n, D - 1, 0, 8));
  add("almost collinear", flat_points<Scalar, D>(n, D - 1, 1e-3, 9));
  auto stray = random_points<Scalar, D>(n, 10);
  stray[17].fill(Scalar(1e5));
  add("one stray particle", stray);
  auto steep = random_points<Scalar, D>(n, 11);
  for (auto& x : steep)
    for (auto& c : x) c = c * c * c;
  add("denser towards a corner", steep);
  add("one point", random_points<Scalar, D>(1, 12));
  return all;
}

template <class Space>
class CellSearch : public ::testing::Test {};
TYPED_TEST_SUITE(CellSearch, Spaces);

TYPED_TEST(CellSearch, EqualsBruteForceForTheKNearest) {
  using Scalar = typename TypeParam::Scalar;
  for (const auto& [name, p, t] : scenes<Scalar, TypeParam::D>()) {
    const auto particles = cloud_of(p), targets = cloud_of(t);
    for (const std::size_t k : {1, 20, 200}) {
      SCOPED_TRACE(name + ", k = " + std::to_string(k));
      expect_reference(particles, targets, Nearest{k});
      if (this->HasFatalFailure()) return;
    }
    SCOPED_TRACE(name);
    expect_reference(particles, targets, Nearest{6}, {}, {.shape = SupportShape::cube});
    expect_reference(particles, targets, NearestWithin{12, 0.07});
    expect_reference(particles, targets, NearestWithin{3, 1e30});
    if (this->HasFatalFailure()) return;
  }
}

TYPED_TEST(CellSearch, EqualsBruteForceWithinARadius) {
  using Scalar = typename TypeParam::Scalar;
  for (const auto& [name, p, t] : scenes<Scalar, TypeParam::D>()) {
    const auto particles = cloud_of(p), targets = cloud_of(t);
    std::vector<double> radii;
    for (std::size_t i = 0; i < targets.size(); ++i) radii.push_back(0.002 + 0.02 * double(i % 7));
    for (const SupportShape shape : {SupportShape::ball, SupportShape::cube}) {
      for (const double radius : {1e-7, 0.03, 3.0 / 64}) {  // the last: exactly on a lattice
        SCOPED_TRACE(name + ", radius " + std::to_string(radius));
        expect_reference(particles, targets, Radius{radius}, {}, {.shape = shape});
        if (this->HasFatalFailure()) return;
      }
      SCOPED_TRACE(name);
      expect_reference(particles, targets, Radii{radii}, {}, {.shape = shape});
      if (this->HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(CellSearch, EqualsBruteForceInPeriodicDomains) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  PeriodicDomain<Scalar> domain;
  domain.upper = {1, D > 1 ? Scalar(1.25) : Scalar(0), 0};
  domain.periodic = {true, D > 1, false};
  auto lattice = regular_points<Scalar, D>(D == 1 ? 64 : D == 2 ? 32 : 8);
  for (const auto& p : {random_points<Scalar, D>(900, 1), lattice}) {
    const auto particles = cloud_of(p, domain);
    const auto targets = cloud_of(random_points<Scalar, D>(300, 2), domain);
    for (const auto* points : {&targets, &particles})  // particles among themselves: ties
      for (const NeighbourRule& rule :
           {NeighbourRule(Radius{0.07}), NeighbourRule(Radius{0.25}), NeighbourRule(Nearest{9}),
            NeighbourRule(Nearest{64}), NeighbourRule(NearestWithin{9, 0.125})}) {
        SCOPED_TRACE(rule.index());
        expect_reference(particles, *points, rule, domain);
        if (rule.index() != 3)
          expect_reference(particles, *points, rule, domain, {.shape = SupportShape::cube});
        if (this->HasFatalFailure()) return;
      }
  }
}

// Scales at which squares are near the limits of the scalar type, and coordinates that are coarse.
// Where squares of lengths underflow, distances could not be told apart, and nothing is sought.
TYPED_TEST(CellSearch, EqualsBruteForceOnAnyScale) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  constexpr auto least = double(std::numeric_limits<Scalar>::min());
  const double root = std::sqrt(least);
  for (const double scale : {least * 8, root * 1e-2, root * 1e2, 1e-6, 1e6, 1e-8 / root})
    for (const double offset : {0.0, 1e6 * scale}) {
      auto p = random_points<Scalar, D>(400, 1), t = random_points<Scalar, D>(60, 2);
      for (auto* list : {&p, &t})
        for (auto& x : *list)
          for (auto& c : x) c = Scalar(double(c) * scale + offset);
      const auto particles = cloud_of(p), targets = cloud_of(t);
      SCOPED_TRACE(std::to_string(scale) + " at " + std::to_string(offset));
      if (scale < root) {
        EXPECT_THROW(find_neighbours(particles, targets, Nearest{7}), InvalidArgument);
        EXPECT_THROW(find_neighbours(particles, targets, Radius{0.1 * scale}), InvalidArgument);
        continue;
      }
      expect_reference(particles, targets, Nearest{7});
      expect_reference(particles, targets, Radius{0.1 * scale});
      if (this->HasFatalFailure()) return;
    }
}

// Distances that differ by less than single precision, or a scale of the whole cloud, resolves: the
// search may look at rounded coordinates, but must not decide by them.
TYPED_TEST(CellSearch, EqualsBruteForceWhereRoundedCoordinatesCannotTell) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  constexpr double spacing = 1.0 / 64;
  constexpr std::size_t per_axis = D == 1 ? 800 : D == 2 ? 30 : 10;
  const auto lattice = [&](double noise) {
    auto points = regular_points<Scalar, D>(per_axis);
    RandomNumbers random(5);
    for (auto& x : points)
      for (auto& c : x)
        c = Scalar((std::round(double(c) * per_axis - 0.5) + noise * random.uniform(-1, 1)) *
                   spacing);
    return points;
  };
  const auto check = [&](const std::string& name, const PointList<Scalar, D>& p,
                         const PointList<Scalar, D>& t, double length,
                         const PeriodicDomain<Scalar>& domain = {}) {
    const auto particles = cloud_of(p, domain), targets = cloud_of(t, domain);
    std::vector<double> radii;
    for (std::size_t i = 0; i < targets.size(); ++i) radii.push_back((1 + double(i % 4)) * length);
    for (const NeighbourRule& rule :
         {NeighbourRule(Nearest{3}), NeighbourRule(Nearest{2 * D + 2}), NeighbourRule(Nearest{90}),
          NeighbourRule(Radius{length}), NeighbourRule(Radius{2 * length}),
          NeighbourRule(Radii{radii}), NeighbourRule(NearestWithin{2 * D, length})}) {
      SCOPED_TRACE(name + ", rule " + std::to_string(rule.index()));
      expect_reference(particles, targets, rule, domain);
      if (rule.index() < 3)
        expect_reference(particles, targets, rule, domain, {.shape = SupportShape::cube});
      if (this->HasFatalFailure()) return;
    }
  };
  for (const double noise : {0.0, 1e-13, 1e-9, 1e-7}) {  // of a spacing
    const auto p = lattice(noise);
    PointList<Scalar, D> at_nodes;  // and between them, where ties are as exact
    for (std::size_t i = 0; i < p.size(); i += p.size() / 60) {
      at_nodes.push_back(p[i]);
      auto between = p[i];
      between[0] += Scalar(spacing / 2);
      at_nodes.push_back(between);
    }
    check("lattice with noise " + std::to_string(noise), p, at_nodes, spacing);
    if (this->HasFatalFailure()) return;
    PeriodicDomain<Scalar> domain;
    domain.upper[0] = Scalar(per_axis * spacing);
    domain.periodic[0] = true;
    check("periodic lattice", p, at_nodes, spacing, domain);
    if (this->HasFatalFailure()) return;
  }
  // A small cloud far from the origin, one with a particle far from the others, a long thin one,
  // coincident ones among others, and dense spots whose width no float about their brick resolves.
  auto far = random_points<Scalar, D>(600, 1), with_stray = far, thin = far, spots = far,
       same = far;
  for (auto& x : far)
    for (auto& c : x) c += Scalar(sizeof(Scalar) == 4 ? 1e3 : 1e9);
  with_stray[5].fill(Scalar(1e7));
  for (auto& x : thin) x[0] *= Scalar(1e6);
  for (std::size_t i = 0; i < 300; ++i) {
    for (int d = 0; d < D; ++d) spots[i][d] = spots[i % 3][d] + spots[i][d] * Scalar(1e-9);
    same[i] = same[i % 7];
  }
  const auto some = [](const PointList<Scalar, D>& p) {
    return PointList<Scalar, D>(p.begin(), p.begin() + 100);
  };
  check("far from the origin", far, some(far), 0.1);
  check("one particle far away", with_stray, some(with_stray), 0.1);
  check("long and thin", thin, some(thin), 0.3 * (D == 1 ? 1e4 : 1));
  check("coincident", same, some(same), 0.1);
  check("spots", spots, some(spots), 0.5e-9);
}

// Targets so dense that those of a brick are cut into groups, which see only some of the particles.
TYPED_TEST(CellSearch, DenseTargetsInADenseSpot) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  auto p = random_points<Scalar, D>(6000, 1);
  for (std::size_t i = 0; i < 3000; ++i)
    for (auto& c : p[i]) c = Scalar(0.4) + c * Scalar(0.01);
  PointList<Scalar, D> t(p.begin(), p.begin() + 700);
  t.resize(800, p[3]);  // and many in one place
  const auto particles = cloud_of(p), targets = cloud_of(t);
  expect_reference(particles, targets, Nearest{7});
  expect_reference(particles, targets, Radius{1e-3});
}

// Many blocks of particles, buckets of cells and blocks of targets.
TYPED_TEST(CellSearch, ManyBlocks) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto cloud = cloud_of(random_points<Scalar, D>(40000, 1));
  const auto copy = cloud, few = cloud_of(random_points<Scalar, D>(2000, 2));
  const double radius = D == 1 ? 1e-4 : D == 2 ? 0.008 : 0.03;
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{10}), NeighbourRule(Radius{radius})}) {
    expect_reference(cloud, few, rule, {}, {}, SearchMethod::kd_tree);
    const auto own = find_neighbours(cloud, cloud, rule);  // sorts them once
    expect_same(own, find_neighbours(cloud, copy, rule));
    expect_same(own, find_neighbours(cloud, cloud, rule, {}, {.search = SearchMethod::kd_tree}));
  }
}

// A spot so dense that a k-d tree is built for the targets there: each costs 9500 candidates, and
// after some 4200 of them that is as much as the tree.
TYPED_TEST(CellSearch, HardTargetsAreLeftToATree) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  if (D == 1) return;  // a border of cells lies in the middle of the spot
  auto particles = random_points<Scalar, D>(100000, 1);
  for (std::size_t i = 0; i < 9500; ++i)
    for (auto& c : particles[i]) c = Scalar(0.3) + c * Scalar(1e-6);
  PointList<Scalar, D> targets = random_points<Scalar, D>(500, 2);
  targets.insert(targets.end(), particles.begin(), particles.begin() + 7000);
  const auto cloud = cloud_of(particles), at = cloud_of(targets);
  for (const NeighbourRule& rule :
       {NeighbourRule(Nearest{5}), NeighbourRule(Radius{2e-9}), NeighbourRule(Nearest{40})}) {
    const auto expected = find_neighbours(cloud, at, rule, {}, {.search = SearchMethod::kd_tree});
    for (const int threads : {1, 3})
      expect_same(find_neighbours(cloud, at, rule, {}, {.threads = threads}), expected);
    if (this->HasFatalFailure()) return;
  }
}

TEST(CellSearchOptions, InstructionSetsThatAreNotThereAreNamed) {
  const auto cloud = cloud_of(random_points<double, 2>(50, 1));
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    const auto sets = available_instruction_sets();
    const bool there = std::find(sets.begin(), sets.end(), set) != sets.end();
    EXPECT_EQ(
        blamed([&] { find_neighbours(cloud, cloud, Nearest{3}, {}, {.instruction_set = set}); }),
        there ? "" : "instruction_set");
  }
}

}  // namespace
}  // namespace recon::testing
