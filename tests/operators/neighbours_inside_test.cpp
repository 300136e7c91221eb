// Inside a reconstruction only membership matters: rows are not ordered by distance, and a block of
// targets is fitted as soon as its neighbours are known. What it finds is still the k nearest, and
// what it fits is what a list of these gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "recon/core/instruction_set.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/neighbourhood/search.hpp"
#include "recon/operators/reconstruct.hpp"
#include "support/clouds.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

template <class Kind>
class NeighboursInside : public ::testing::Test {
 protected:
  using Scalar = typename Kind::Scalar;
  static constexpr int D = Kind::D;
  using List = PointList<Scalar, D>;
  // More than the targets of two blocks, and enough to be put into an order.
  static constexpr std::size_t many = 1300;

  // Half of the targets are particles, the others lie about the box of the particles.
  static List targets_among(const List& particles) {
    List targets(many);
    auto at = random_points<Scalar, D>(many, 31);
    std::array<Scalar, D> lower = particles[0], upper = particles[0];
    for (const auto& x : particles)
      for (int d = 0; d < D; ++d) {
        lower[d] = std::min(lower[d], x[d]);
        upper[d] = std::max(upper[d], x[d]);
      }
    for (std::size_t t = 0; t < many; ++t)
      for (int d = 0; d < D; ++d)
        targets[t][d] =
            t % 2 ? particles[7 * t % particles.size()][d]
                  : lower[d] + (Scalar(1.2) * at[t][d] - Scalar(0.1)) * (upper[d] - lower[d]);
    return targets;
  }

  static std::vector<Scalar> sorted_distances(const List& particles, const List& targets,
                                              const NeighbourList<Scalar>& list, std::size_t t,
                                              const PeriodicDomain<Scalar>& domain) {
    std::vector<Scalar> squares;
    for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
      std::array<Scalar, D> x = targets[t];
      for (int d = 0; d < D && !list.shifts.empty(); ++d)
        x[d] -= static_cast<Scalar>(list.shifts[e][d]) * domain.period(d);
      squares.push_back(squared_distance(x, particles[list.indices[e]]));
    }
    std::sort(squares.begin(), squares.end());
    return squares;
  }

  static void expect_nearest(const std::string& name, const List& particles,
                             const PeriodicDomain<double>& periodic = {}) {
    const List targets = targets_among(particles);
    PeriodicDomain<Scalar> domain;
    domain.periodic = periodic.periodic;
    for (int d = 0; d < max_dimension; ++d) {
      domain.lower[d] = static_cast<Scalar>(periodic.lower[d]);
      domain.upper[d] = static_cast<Scalar>(periodic.upper[d]);
    }
    const PointCloud<Scalar> p(points_of(particles), "points", domain),
        t(points_of(targets), "targets", domain);
    List wrapped_particles(particles), wrapped_targets(targets);
    for (std::size_t i = 0; i < particles.size(); ++i)
      wrapped_particles[i] = p.template point<D>(i);
    for (std::size_t i = 0; i < targets.size(); ++i) wrapped_targets[i] = t.template point<D>(i);
    for (const std::size_t k : {std::size_t{1}, std::size_t{20}, std::size_t{150}}) {
      const auto expected =
          find_neighbours(p, t, Nearest{k}, domain, {.search = SearchMethod::brute_force});
      for (const InstructionSet set : available_instruction_sets()) {
        SCOPED_TRACE(name + ", k = " + std::to_string(k) + ", " + std::string(name_of(set)));
        Options options{.degree = 1, .neighbours = Nearest{k}, .solver = Solver::moment_matrix};
        options.domain = periodic;
        options.instruction_set = set;
        options.search = SearchMethod::cell_grid;
        const BasicReconstruction<Scalar> fit(points_of(particles), points_of(targets), options);
        const NeighbourList<Scalar> found = fit.neighbours();
        ASSERT_EQ(found.offsets, expected.offsets);
        ASSERT_EQ(found.support, expected.support);
        for (std::size_t i = 0; i < targets.size(); ++i) {
          ASSERT_EQ(sorted_distances(wrapped_particles, wrapped_targets, found, i, domain),
                    sorted_distances(wrapped_particles, wrapped_targets, expected, i, domain))
              << "target " << i;
          std::vector<std::pair<ParticleIndex, ImageShift>> members;
          for (std::int64_t e = found.offsets[i]; e < found.offsets[i + 1]; ++e)
            members.emplace_back(found.indices[e],
                                 found.shifts.empty() ? ImageShift{} : found.shifts[e]);
          std::sort(members.begin(), members.end());
          ASSERT_EQ(std::adjacent_find(members.begin(), members.end()), members.end())
              << "target " << i;
        }
        expect_fit_of(fit, found, particles, targets, options);
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
  }

  // The same rows and reports, to the bit, from the list that was found.
  static void expect_fit_of(const BasicReconstruction<Scalar>& fit,
                            const NeighbourList<Scalar>& list, const List& particles,
                            const List& targets, const Options& options) {
    const BasicReconstruction<Scalar> given(points_of(particles), points_of(targets),
                                            NeighbourList<Scalar>(list), options);
    const auto &values = fit.values(), &expected = given.values();
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const auto row = values.row(i), other = expected.row(i);
      ASSERT_EQ(row.size(), other.size());
      for (std::size_t e = 0; e < row.size(); ++e) {
        ASSERT_EQ(row.particle(e), other.particle(e));
        ASSERT_EQ(row.value(e), other.value(e)) << "target " << i << ", entry " << e;
      }
      ASSERT_EQ(fit.report()[i], given.report()[i]) << "target " << i;
    }
  }

  static constexpr std::size_t per_axis = D == 1 ? 900 : D == 2 ? 31 : 10;
};
TYPED_TEST_SUITE(NeighboursInside, AllCases, CaseNames);

TYPED_TEST(NeighboursInside, OfEvenClouds) {
  constexpr int N = TypeParam::D;
  using S = typename TypeParam::Scalar;
  TestFixture::expect_nearest("random", random_points<S, N>(1000, 1));
  auto lattice = regular_points<S, N>(TestFixture::per_axis);  // whole numbers / 64: ties are exact
  for (auto& x : lattice)
    for (auto& c : x) c = std::round(c * S(TestFixture::per_axis) - S(0.5)) / 64;
  TestFixture::expect_nearest("lattice", lattice);
}

TYPED_TEST(NeighboursInside, OfDenseSpots) {
  constexpr int N = TypeParam::D;
  using S = typename TypeParam::Scalar;
  TestFixture::expect_nearest("clusters of 1e-6", clustered_points<S, N>(1000, 4, 1e-6, 5));
  TestFixture::expect_nearest("coinciding", duplicated_points<S, N>(40, 25, 3));
  auto steep = random_points<S, N>(1000, 11);
  for (auto& x : steep)
    for (auto& c : x) c = c * c * c * c * c;
  TestFixture::expect_nearest("denser towards a corner", steep);
}

TYPED_TEST(NeighboursInside, FarFromTheOrigin) {
  constexpr int N = TypeParam::D;
  using S = typename TypeParam::Scalar;
  auto far = random_points<S, N>(1000, 13);
  // A spacing of 1e-3 at 1e6: of floats few different ones are left.
  for (auto& x : far)
    for (auto& c : x) c = S(1e6) + S(1e-3) * S(TestFixture::per_axis) * c;
  TestFixture::expect_nearest("far", far);
}

TYPED_TEST(NeighboursInside, InPeriodicDomains) {
  constexpr int N = TypeParam::D;
  using S = typename TypeParam::Scalar;
  PeriodicDomain<double> domain;
  for (int d = 0; d < N; ++d) {
    domain.periodic[d] = d != 1;
    domain.lower[d] = 0;
    domain.upper[d] = 1;
  }
  TestFixture::expect_nearest("random", random_points<S, N>(1000, 1), domain);
  TestFixture::expect_nearest("clusters of 1e-6", clustered_points<S, N>(1000, 4, 1e-6, 5), domain);
}

}  // namespace
}  // namespace recon::testing
