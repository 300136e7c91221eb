// PairRadii: supports that belong to particles, or to both of a pair.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <tuple>

#include "recon/neighbourhood/find_neighbours.hpp"
#include "support/clouds.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

constexpr std::array all_supports{PairSupport::particle, PairSupport::mean, PairSupport::larger};

// From `least` to thirty times that.
std::vector<double> uneven_radii(std::size_t count, double least, std::uint64_t seed) {
  std::vector<double> radii;
  for (const auto& x : random_points<double, 1>(count, seed))
    radii.push_back(least * std::pow(30, x[0]));
  return radii;
}

double radius_of(const PairRadii& rule, std::size_t t, std::size_t p) {
  if (rule.support == PairSupport::particle) return rule.particles[p];
  if (rule.support == PairSupport::mean) return (rule.particles[p] + rule.targets[t]) / 2;
  return std::max(rule.particles[p], rule.targets[t]);
}

template <class C>
class PairRadiiSearch : public ::testing::Test {};
TYPED_TEST_SUITE(PairRadiiSearch, AllCases, CaseNames);

// Every pair, and every periodic image, is looked at; pairs within a rounding of the border may be
// listed or not.
TYPED_TEST(PairRadiiSearch, FindsThePairsThatADoubleLoopFinds) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto particles = cloud_of(random_points<Scalar, D>(120, 1));
  const auto targets = cloud_of(random_points<Scalar, D>(90, 2));
  const double least = D == 1 ? 0.005 : D == 2 ? 0.02 : 0.04;
  const auto of_particles = uneven_radii(particles.size(), least, 3);
  const auto of_targets = uneven_radii(targets.size(), least, 4);
  PeriodicDomain<Scalar> box;
  box.periodic[0] = true;
  box.lower[0] = 0;
  box.upper[0] = 1;
  for (const bool periodic : {false, true})
    for (const PairSupport support : all_supports)
      for (const SupportShape shape : {SupportShape::ball, SupportShape::cube})
        for (const SearchMethod search : {SearchMethod::automatic, SearchMethod::kd_tree}) {
          const PeriodicDomain<Scalar> domain = periodic ? box : PeriodicDomain<Scalar>{};
          PairRadii rule{of_particles, {}, support};
          if (support != PairSupport::particle) rule.targets = of_targets;
          const auto list = find_neighbours(particles, targets, NeighbourRule(rule), domain,
                                            {.shape = shape, .search = search});
          list.validate(targets.size(), particles.size());
          ASSERT_EQ(list.pair_support.size(), list.indices.size());
          for (std::size_t t = 0; t < targets.size(); ++t) {
            double largest = 0;
            using Found = std::tuple<std::size_t, int>;
            std::vector<Found> inside, outside, listed;
            for (std::size_t p = 0; p < particles.size(); ++p)
              for (int s = periodic ? -2 : 0; s <= (periodic ? 2 : 0); ++s) {
                double distance = 0;
                for (int d = 0; d < D; ++d) {
                  const double along = std::abs(static_cast<double>(targets(t, d)) -
                                                particles(p, d) - (d == 0 ? s : 0));
                  distance = shape == SupportShape::ball ? std::hypot(distance, along)
                                                         : std::max(distance, along);
                }
                const double ratio = distance / radius_of(rule, t, p);
                if (ratio < 1 - 100 * TypeParam::eps) inside.push_back({p, s});
                if (ratio > 1 + 100 * TypeParam::eps) outside.push_back({p, s});
              }
            for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
              const std::size_t p = list.indices[e];
              listed.push_back({p, list.shifts.empty() ? 0 : list.shifts[e][0]});
              ASSERT_EQ(list.pair_support[e], static_cast<Scalar>(radius_of(rule, t, p)));
              largest = std::max(largest, radius_of(rule, t, p));
            }
            ASSERT_TRUE(std::is_sorted(listed.begin(), listed.end()));
            ASSERT_TRUE(std::includes(listed.begin(), listed.end(), inside.begin(), inside.end()))
                << "target " << t;
            std::vector<Found> wrong;
            std::set_intersection(listed.begin(), listed.end(), outside.begin(), outside.end(),
                                  std::back_inserter(wrong));
            ASSERT_TRUE(wrong.empty()) << "target " << t;
            if (!listed.empty()) {
              ASSERT_EQ(list.support[t], static_cast<Scalar>(largest));
            }
          }
        }
}

TEST(PairRadii, HideWhatATargetDoesNotSee) {
  const auto points = cloud_of(random_points<double, 2>(100, 5));
  const std::vector<double> radii(100, 0.3);
  NeighbourOptions options;
  options.visible = [](std::size_t target, std::size_t particle) { return target < particle; };
  const auto list = find_neighbours(points, points, NeighbourRule(PairRadii{radii}), {}, options);
  std::size_t found = 0;
  for (std::size_t t = 0; t < points.size(); ++t)
    for (const ParticleIndex p : list.of(t)) {
      EXPECT_LT(t, p);
      ++found;
    }
  EXPECT_GT(found, 100u);
}

// The searches from both sides are one account, which rises.
TEST(PairRadii, ProgressIsToldOfBothSearchesAsOne) {
  const auto points = cloud_of(random_points<double, 2>(2000, 7));
  const std::vector<double> radii(2000, 0.03);
  NeighbourOptions options;
  options.threads = 1;
  options.visible = [](std::size_t target, std::size_t) {
    static std::size_t last = 0;
    if (target != last) std::this_thread::sleep_for(std::chrono::microseconds(100));
    last = target;
    return true;
  };
  std::vector<double> told;
  options.progress = [&](double fraction) {
    told.push_back(fraction);
    return true;
  };
  find_neighbours(points, points, NeighbourRule(PairRadii{radii, radii, PairSupport::mean}), {},
                  options);
  ASSERT_GE(told.size(), 2u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_LT(told.front(), 0.5);
  EXPECT_GT(told.back(), 0.5);
  EXPECT_LE(told.back(), 1);
}

TEST(PairRadii, RadiiThatDoNotFitAreNamed) {
  const auto points = cloud_of(random_points<double, 2>(50, 5));
  const auto at = cloud_of(random_points<double, 2>(40, 6));
  const auto message = [&](const PairRadii& rule) {
    return message_of([&] { find_neighbours(points, at, NeighbourRule(rule)); });
  };
  std::vector<double> fifty(50, 0.1), forty(40, 0.1);
  EXPECT_NE(message({forty}).find("number of radii of particles = 40"), std::string::npos);
  EXPECT_NE(message({fifty, {}, PairSupport::mean}).find("number of radii of targets = 0"),
            std::string::npos);
  EXPECT_NE(message({fifty, forty}).find("must be 0 where pairs"), std::string::npos);
  EXPECT_NE(message({fifty, forty, static_cast<PairSupport>(7)}).find("support of pairs = 7"),
            std::string::npos);
  fifty[7] = -0.1;
  EXPECT_NE(message({fifty}).find("radius of particle 7 = -0.1"), std::string::npos);
  fifty[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message({fifty}).find("radius of particle 7 = nan"), std::string::npos);
}

}  // namespace
}  // namespace recon::testing
