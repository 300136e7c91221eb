// An update of Sources and of what was made of them allocates nothing once it is warm.
#include <gtest/gtest.h>

#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"
#include "support/count_allocations.hpp"

#if RECON_COUNTS_ALLOCATIONS

namespace recon::testing {
namespace {

// The arrays of this many targets stay below the size from which memory comes from the system.
constexpr std::size_t particles = 3000, targets = 2000;

template <int D>
void check(const Options& options, const PeriodicDomain<double>& domain, const char* name) {
  const auto first = random_points<double, D>(particles, 1);
  const auto second = random_points<double, D>(particles, 2);
  const auto at = random_points<double, D>(targets, 3);
  std::vector<double> u(particles, 1.0), v(targets);
  Sources sources(points_of(first), {.domain = domain, .threads = options.threads});
  Reconstruction fit = reconstruct(sources, points_of(at), options);
  const auto step = [&](const PointList<double, D>& moved) {
    sources.update(points_of(moved));
    fit.update(points_of(at));
    fit.apply(field_of(u), field_of(v));
  };
  for (int i = 0; i < 4; ++i) {
    step(second);
    step(first);
  }
  const long before = allocations;
  step(second);
  step(first);
  EXPECT_EQ(allocations - before, 0) << name << " in " << D << "-D";
  EXPECT_NEAR(v[7], 1, 1e-12);
}

template <int D>
void check_rules(int threads) {
  const double h = std::pow(particles, -1.0 / D);
  const PeriodicDomain<double> box{{0, 0, 0}, {1, 1, 1}, {true, true, D == 3}};
  check<D>({.threads = threads}, {}, "nearest");
  check<D>({.degree = 2, .solver = Solver::moment_matrix, .threads = threads}, {}, "degree 2");
  check<D>({.neighbours = Radius{2.2 * h}, .threads = threads}, {}, "radius");
  check<D>({.degree = 0,
            .form = WeightForm::tensor_product,
            .neighbours = Radius{2 * h},
            .threads = threads},
           {}, "cube");
  if (D > 1) check<D>({.threads = threads}, box, "periodic");
}

TEST(Allocations, AnUpdateNeedsNoneOnceWarm) {
  check_rules<2>(1);
  check_rules<3>(1);
}

TEST(Allocations, ApplyIntoAnArrayOfOnesOwnNeedsNone) {
  const auto points = random_points<double, 3>(particles, 1);
  const auto fit = reconstruct(points_of(points), points_of(points));
  std::vector<double> x(particles, 1), y(particles, 2), z(particles, 3), a(particles), b(particles),
      c(particles);
  const long before = allocations;
  fit.apply(field_of(x, y, z), field_of(a, b, c), trusted);
  fit.apply(field_of(x, y, z), field_of(a, b, c));
  EXPECT_EQ(allocations - before, 0);
  EXPECT_NEAR(b[17], 2, 1e-12);
}

// 12 bytes for each entry; for each target its report, coordinates, offset, support and number; for
// each particle its coordinates and number, and a third of a cell. What only the next update would
// need is not kept, and an update makes it again.
TEST(Allocations, AReconstructionOfPointsKeepsWhatItNeedsAlone) {
  constexpr long k = 10, about_the_arrays = 32768;
  const auto points = random_points<double, 3>(particles, 1);
  const auto at = random_points<double, 3>(targets, 3),
             others = random_points<double, 3>(targets, 4);
  const Options options{.degree = 1, .neighbours = Nearest{k}, .threads = 1};
  const long before = bytes_in_use;
  Reconstruction fit = reconstruct(points_of(points), points_of(at), options);
  const long of_target = 12 * k + sizeof(FitReport) + 3 * 8 + 8 + 8 + 4,
             of_particle = 3 * 8 + 4 + 2;
  EXPECT_LT(bytes_in_use - before, static_cast<long>(targets) * of_target +
                                       static_cast<long>(particles) * of_particle +
                                       about_the_arrays);
  fit.update(points_of(others));
  std::vector<double> u(particles), v(targets), w(targets);
  for (std::size_t p = 0; p < particles; ++p) u[p] = points[p][0] * points[p][1];
  fit.apply(field_of(u), field_of(v));
  reconstruct(points_of(points), points_of(others), options).apply(field_of(u), field_of(w));
  EXPECT_EQ(v, w);
}

}  // namespace
}  // namespace recon::testing
#endif
