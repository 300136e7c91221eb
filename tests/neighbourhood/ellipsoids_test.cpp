// Ellipsoids and PairEllipsoids: supports of any orientation, of targets and of particles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "recon/neighbourhood/find_neighbours_with.hpp"
#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/neighbourhood/sources.hpp"
#include "support/clouds.hpp"
#include "support/message_of.hpp"
#include "support/tensors.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

template <class C>
class EllipsoidSearch : public ::testing::Test {};
TYPED_TEST_SUITE(EllipsoidSearch, AllCases, CaseNames);

// Every pair, and every periodic image, is looked at; pairs within a rounding of the border may be
// listed or not.
TYPED_TEST(EllipsoidSearch, FindsThePairsThatADoubleLoopFinds) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto particles = cloud_of(random_points<Scalar, D>(120, 1));
  const auto targets = cloud_of(random_points<Scalar, D>(90, 2));
  const double least = D == 1 ? 0.01 : D == 2 ? 0.04 : 0.08;
  const auto of_particles = random_tensors<D>(particles.size(), least, 20 * least, 3);
  const auto of_targets = random_tensors<D>(targets.size(), least, 20 * least, 4);
  PeriodicDomain<Scalar> box;
  box.periodic[0] = true;
  box.lower[0] = 0;
  box.upper[0] = 1;
  enum class Kind { of_target, of_particle, mean };
  for (const bool periodic : {false, true})
    for (const Kind kind : {Kind::of_target, Kind::of_particle, Kind::mean})
      for (const SupportShape shape : {SupportShape::ball, SupportShape::cube})
        for (const SearchMethod search : {SearchMethod::automatic, SearchMethod::cell_grid,
                                          SearchMethod::r_tree, SearchMethod::brute_force}) {
          if (shape == SupportShape::cube && kind != Kind::of_target) continue;
          const PeriodicDomain<Scalar> domain = periodic ? box : PeriodicDomain<Scalar>{};
          NeighbourRule rule = Ellipsoids{field_of(of_targets)};
          if (kind == Kind::of_particle) rule = PairEllipsoids{field_of(of_particles)};
          if (kind == Kind::mean)
            rule = PairEllipsoids{field_of(of_particles), field_of(of_targets), PairSupport::mean};
          const auto tensor = [&](std::size_t t, std::size_t p) -> Matrix<D> {
            if (kind == Kind::of_target) return of_targets[t];
            if (kind == Kind::of_particle) return of_particles[p];
            return (of_particles[p] + of_targets[t]) / 2;
          };
          const auto list =
              find_neighbours(particles, targets, rule, domain, {.shape = shape, .search = search});
          list.validate(targets.size(), particles.size());
          constexpr int numbers = D * (D + 1) / 2;
          ASSERT_EQ(list.tensor.size(), targets.size() * numbers);
          ASSERT_EQ(list.pair_tensor.size(),
                    kind == Kind::of_target ? 0 : list.indices.size() * numbers);
          for (std::size_t t = 0; t < targets.size(); ++t) {
            using Found = std::tuple<std::size_t, int>;
            std::vector<Found> inside, outside, listed;
            for (std::size_t p = 0; p < particles.size(); ++p)
              for (int s = periodic ? -2 : 0; s <= (periodic ? 2 : 0); ++s) {
                auto apart = vector_of<Scalar, D>(particles.template point<D>(p));
                apart -= vector_of<Scalar, D>(targets.template point<D>(t));
                apart[0] += s;
                const Eigen::Matrix<double, D, 1> xi = tensor(t, p).ldlt().solve(apart);
                const double q = shape == SupportShape::ball ? xi.norm() : xi.cwiseAbs().maxCoeff();
                if (q < 1 - 1000 * TypeParam::eps) inside.push_back({p, s});
                if (q > 1 + 1000 * TypeParam::eps) outside.push_back({p, s});
              }
            for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
              const std::size_t p = list.indices[e];
              listed.push_back({p, list.shifts.empty() ? 0 : list.shifts[e][0]});
              if (kind == Kind::of_target) continue;
              const Matrix<D> expected = tensor(t, p);
              for (int i = 0, n = 0; i < D; ++i)
                for (int j = i; j < D; ++j, ++n)
                  ASSERT_EQ(list.pair_tensor[e * numbers + n], static_cast<Scalar>(expected(i, j)));
            }
            ASSERT_TRUE(std::is_sorted(listed.begin(), listed.end()));
            ASSERT_TRUE(std::includes(listed.begin(), listed.end(), inside.begin(), inside.end()))
                << "target " << t;
            std::vector<Found> wrong;
            std::set_intersection(listed.begin(), listed.end(), outside.begin(), outside.end(),
                                  std::back_inserter(wrong));
            ASSERT_TRUE(wrong.empty()) << "target " << t;
            // The support is the largest half axis of the target's tensor.
            Matrix<D> own;
            for (int i = 0, n = 0; i < D; ++i)
              for (int j = i; j < D; ++j, ++n) own(i, j) = own(j, i) = list.tensor[t * numbers + n];
            const double largest =
                Eigen::SelfAdjointEigenSolver<Matrix<D>>(own).eigenvalues()[D - 1];
            ASSERT_NEAR(list.support[t], largest, 20 * TypeParam::eps * largest);
          }
        }
}

// Balls of any size are those of Radii, and of PairRadii.
TYPED_TEST(EllipsoidSearch, BallsAreThoseOfRadii) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto particles = cloud_of(random_points<Scalar, D>(300, 1));
  const auto targets = cloud_of(random_points<Scalar, D>(200, 2));
  std::vector<double> of_particles, of_targets;
  for (const auto& x : random_points<double, 1>(300, 3)) of_particles.push_back(0.05 + 0.3 * x[0]);
  for (const auto& x : random_points<double, 1>(200, 4)) of_targets.push_back(0.05 + 0.3 * x[0]);
  const auto balls = [](const std::vector<double>& radii) {
    std::vector<Matrix<D>> tensors;
    for (const double r : radii) tensors.push_back(r * Matrix<D>::Identity());
    return tensors;
  };
  const auto p = balls(of_particles), t = balls(of_targets);
  const auto expect_same = [&](const NeighbourRule& tensors, const NeighbourRule& radii) {
    const auto a = find_neighbours(particles, targets, tensors),
               b = find_neighbours(particles, targets, radii);
    EXPECT_EQ(a.offsets, b.offsets);
    EXPECT_EQ(a.indices, b.indices);
    for (std::size_t i = 0; i < targets.size(); ++i)
      EXPECT_NEAR(a.support[i], b.support[i], 4 * TypeParam::eps * b.support[i]);
  };
  expect_same(Ellipsoids{field_of(t)}, Radii{of_targets});
  expect_same(PairEllipsoids{field_of(p)}, PairRadii{of_particles});
  expect_same(PairEllipsoids{field_of(p), field_of(t), PairSupport::mean},
              PairRadii{of_particles, of_targets, PairSupport::mean});
}

// A thin ellipsoid far from all axes is found whole by a search of the reader's own.
TEST(EllipsoidRules, ASearchOfOnesOwnFindsThemToo) {
  const auto points = cloud_of(random_points<double, 2>(500, 1));
  const auto at = cloud_of(random_points<double, 2>(50, 2));
  const auto tensors = random_tensors<2>(50, 0.01, 0.5, 3),
             few = random_tensors<2>(500, 0.01, 0.2, 4);
  for (const NeighbourRule& rule : {NeighbourRule(Ellipsoids{field_of(tensors)}),
                                    NeighbourRule(PairEllipsoids{field_of(few)})}) {
    const auto own = find_neighbours_with(KdTree<double, 2>(points), points, at, rule),
               list = find_neighbours(points, at, rule);
    EXPECT_EQ(own.indices, list.indices);
    EXPECT_EQ(own.tensor, list.tensor);
    EXPECT_EQ(own.pair_tensor, list.pair_tensor);
    EXPECT_EQ(own.support, list.support);
  }
}

// Particles that a target does not see are left out, and Sources speak of the caller's particles.
TEST(EllipsoidRules, OfSourcesHaveTheNumbersOfTheCaller) {
  const auto points = random_points<double, 3>(400, 5);
  const auto tensors = random_tensors<3>(400, 0.05, 0.4, 6);
  const Sources sources(points_of(points));
  NeighbourOptions options;
  options.visible = [](std::size_t target, std::size_t particle) { return target < particle; };
  for (const NeighbourRule& rule : {NeighbourRule(Ellipsoids{field_of(tensors)}),
                                    NeighbourRule(PairEllipsoids{field_of(tensors)})}) {
    const auto a = find_neighbours(sources, points_of(points), rule, options),
               b = find_neighbours(cloud_of(points), cloud_of(points), rule, {}, options);
    ASSERT_GT(b.indices.size(), 1000u);
    EXPECT_EQ(a.offsets, b.offsets);
    for (std::size_t t = 0; t < points.size(); ++t) {
      std::vector<ParticleIndex> ours(a.of(t).begin(), a.of(t).end());
      std::sort(ours.begin(), ours.end());
      EXPECT_TRUE(std::equal(ours.begin(), ours.end(), b.of(t).begin()));
      for (const ParticleIndex p : ours) EXPECT_LT(t, p);
    }
  }
}

// Packed and full matrices, members of a struct and arrays of components are the same tensors.
TEST(EllipsoidRules, TakeTensorsFromAnyLayout) {
  const auto points = cloud_of(random_points<double, 2>(300, 5));
  const auto tensors = random_tensors<2>(300, 0.02, 0.2, 6);
  struct Grain {
    float mass;
    std::array<double, 3> packed;
  };
  std::vector<Grain> grains;
  std::vector<double> xx, xy, yy;
  for (const Matrix<2>& a : tensors) {
    grains.push_back({1, {a(0, 0), a(0, 1), a(1, 1)}});
    xx.push_back(a(0, 0));
    xy.push_back(a(0, 1));
    yy.push_back(a(1, 1));
  }
  const auto full = find_neighbours(points, points, Ellipsoids{field_of(tensors)});
  ASSERT_GT(full.indices.size(), 1000u);
  for (const FieldView<double>& view : {FieldView<double>(field_of(grains, &Grain::packed)),
                                        FieldView<double>(field_of(xx, xy, yy))}) {
    const auto list = find_neighbours(points, points, Ellipsoids{view});
    EXPECT_EQ(list.indices, full.indices);
    EXPECT_EQ(list.tensor, full.tensor);
  }
}

template <int D>
void expect_tensors_of_deformed_balls() {
  RandomNumbers random(7);
  std::vector<std::array<double, D * D>> axes;
  std::vector<Matrix<D>> deformations;
  for (int i = 0; i < 20; ++i) {
    Matrix<D> F;
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) F(a, b) = (a == b) + random.uniform(-0.8, 0.8);
    deformations.push_back(0.3 * F);
    std::array<double, D * D> columns;
    for (int c = 0; c < D * D; ++c) columns[c] = 0.3 * F(c % D, c / D);
    axes.push_back(columns);
  }
  const std::vector<double> packed = support_tensors(field_of(axes));
  const FieldView<double> view = field_of_flat(packed, D * (D + 1) / 2);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    // A sphere that F has deformed is where |F^-1 y| = 1, which must be where |A^-1 y| = 1.
    Matrix<D> A;
    for (int a = 0, n = 0; a < D; ++a)
      for (int b = a; b < D; ++b, ++n) A(a, b) = A(b, a) = view(i, n);
    const Matrix<D> expected = deformations[i] * deformations[i].transpose();
    EXPECT_LT((A * A - expected).norm(), 1e-14);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix<D>>(A).eigenvalues()[0], 0);
  }
}

TEST(SupportTensors, AreThoseOfDeformedBalls) {
  expect_tensors_of_deformed_balls<1>();
  expect_tensors_of_deformed_balls<2>();
  expect_tensors_of_deformed_balls<3>();
}

TEST(SupportTensors, OfWrongHalfAxesAreRefused) {
  const std::vector<std::array<double, 3>> three{{1, 0, 1}};
  EXPECT_NE(
      message_of([&] { support_tensors(field_of(three)); }).find("components of half axes = 3"),
      std::string::npos);
  const std::vector<std::array<double, 4>> infinite{{1, 0, 0, 1}, {1, INFINITY, 0, 1}};
  EXPECT_NE(message_of([&] { support_tensors(field_of(infinite)); }).find("particle 1 = inf"),
            std::string::npos);
}

TEST(EllipsoidRules, WhatIsWrongIsNamed) {
  const auto points = cloud_of(random_points<double, 3>(20, 5));
  const auto at = cloud_of(random_points<double, 3>(10, 6));
  const auto good = random_tensors<3>(20, 0.1, 0.3, 7), ten = random_tensors<3>(10, 0.1, 0.3, 8);
  const auto expect_message = [&](const NeighbourRule& rule, const std::string& text) {
    const std::string message = message_of([&] { find_neighbours(points, at, rule); });
    EXPECT_NE(message.find(text), std::string::npos) << message;
  };
  const auto changed = [&](const auto& change) {
    auto tensors = ten;
    change(tensors[7]);
    return tensors;
  };
  const auto expect_refused = [&](const auto& change, const std::string& text) {
    const auto tensors = changed(change);
    expect_message(Ellipsoids{field_of(tensors)}, text);
    expect_message(PairEllipsoids{field_of(good), field_of(tensors), PairSupport::mean}, text);
    auto particles = good;
    particles[7] = tensors[7];
    std::string of_particle = text;
    const std::size_t place = text.find("target 7");
    if (place != std::string::npos) of_particle.replace(place, 8, "particle 7");
    expect_message(PairEllipsoids{field_of(particles)}, of_particle);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused([&](Matrix<3>& a) { a(0, 1) = a(1, 0) = nan; },
                 "support tensor xy of target 7 = nan: must be finite");
  expect_refused([&](Matrix<3>& a) { a(2, 2) = INFINITY; },
                 "support tensor zz of target 7 = inf: must be finite");
  expect_refused([](Matrix<3>& a) { a(0, 2) += 0.01; },
                 "difference of xz and zx in the support tensor of target 7 = 0.0");
  expect_refused([](Matrix<3>& a) { a = Eigen::Vector3d(1, -0.5, 2).asDiagonal(); },
                 "smallest eigenvalue of the support tensor of target 7 = -0.5: must be positive");
  expect_refused([](Matrix<3>& a) { a.setZero(); },
                 "smallest eigenvalue of the support tensor of target 7 = 0: must be positive");
  expect_refused([](Matrix<3>& a) { a = -a; },
                 "must be positive: the eigenvalues are the half axes");
  expect_refused([](Matrix<3>& a) { a = Eigen::Vector3d(1e-5, 1e-5, 2).asDiagonal(); },
                 "ratio of the half axes of target 7 = ");
  expect_refused([](Matrix<3>& a) { a *= 1e-200; }, "must have a square that neither underflows");
  expect_refused([](Matrix<3>& a) { a *= 1e200; }, "must have a square that neither underflows");
  // One of rank 2, up to rounding.
  expect_refused(
      [](Matrix<3>& a) {
        const Eigen::Vector3d u(0.6, 0.5, 0.3), v(-0.5, 0.7, 0.1);
        a = u * u.transpose() + v * v.transpose();
      },
      "half axes");

  expect_message(Ellipsoids{field_of(good)}, "number of support tensors of targets = 20: must be");
  expect_message(PairEllipsoids{field_of(ten)},
                 "number of support tensors of particles = 10: must");
  expect_message(PairEllipsoids{field_of(good), {}, PairSupport::mean},
                 "number of support tensors of targets = 0: must be the number of targets");
  expect_message(PairEllipsoids{field_of(good), field_of(ten)}, "must be 0 where pairs");
  expect_message(PairEllipsoids{field_of(good), field_of(ten), PairSupport::larger},
                 "support of pairs = 2: must be PairSupport::particle or mean");
  const auto flat = random_tensors<2>(10, 0.1, 0.3, 8);
  expect_message(Ellipsoids{field_of(flat)},
                 "components of a support tensor of a target = 4: must be 6 (packed) or 9 (full)");
  EXPECT_NE(message_of([&] {
              find_neighbours(points, at, PairEllipsoids{field_of(good)}, {},
                              {.shape = SupportShape::cube});
            }).find("support shape = cube"),
            std::string::npos);
}

// In float the half axes may differ by a factor of 1e3.
TEST(EllipsoidRules, OfFloatAreRounder) {
  const auto points = cloud_of(random_points<float, 2>(20, 5));
  std::vector<Matrix<2>> tensors(20, Matrix<2>::Identity());
  tensors[3](0, 0) = 900;
  EXPECT_NO_THROW(find_neighbours(points, points, Ellipsoids{field_of(tensors)}));
  tensors[3](0, 0) = 2000;
  EXPECT_NE(message_of([&] {
              find_neighbours(points, points, Ellipsoids{field_of(tensors)});
            }).find("ratio of the half axes of target 3 = 2000: must be at most 1000 in float"),
            std::string::npos);
}

TEST(OwnTensorList, WhatIsWrongIsNamed) {
  const auto message = [](const auto& change) {
    NeighbourList<double> list;
    list.offsets = {0, 2, 3};
    list.indices = {0, 3, 1};
    list.support = {1, 1};
    list.tensor = {1, 0, 1, 1, 0.5, 1};
    list.pair_tensor = {1, 0, 1, 1, 0, 1, 1, 0, 1};
    change(list);
    return message_of([&] { list.validate(2, 4); });
  };
  EXPECT_EQ(message([](auto&) {}), "no InvalidArgument was thrown");
  const auto expect = [&](const auto& change, const std::string& text) {
    EXPECT_NE(message(change).find(text), std::string::npos) << message(change);
  };
  expect([](auto& l) { l.tensor.pop_back(); }, "numbers in the tensors = 5");
  expect([](auto& l) { l.pair_tensor.resize(6); }, "numbers in the tensors of pairs = 6");
  expect([](auto& l) { l.tensor.assign({1.0, 1.0}); }, "dimension of the tensors of pairs = 2");
  expect([](auto& l) { l.tensor[4] = 1.5; }, "eigenvalue of the support tensor of target 1 = -0.5");
  expect([](auto& l) { l.pair_tensor[5] = -1; }, "support tensor of entry 1 = -1");
  expect([](auto& l) { l.pair_support.assign({1.0, 1.0, 1.0}); }, "number of pair supports = 3");
  expect([](auto& l) { l.support_factor = 1.5; }, "must be 0 where there are tensors");
}

}  // namespace
}  // namespace recon::testing
