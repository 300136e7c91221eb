// Results do not depend on where the origin is, on the unit of length, or on the choice of axes.
#include <gtest/gtest.h>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

template <class C>
class Invariance : public ::testing::Test {};
TYPED_TEST_SUITE(Invariance, AllCases, CaseNames);

// Coordinates rounded to multiples of 2^-bits, so that moving them is exact.
template <class Scalar, int D>
void quantise(PointList<Scalar, D>& points, int bits) {
  const double unit = std::ldexp(1.0, -bits);
  for (auto& x : points)
    for (Scalar& c : x) c = static_cast<Scalar>(std::round(static_cast<double>(c) / unit) * unit);
}

// Row t of the operator, one number per particle.
template <class Scalar>
std::vector<double> row(const CsrOperator<Scalar>& op, std::size_t t) {
  std::vector<double> values(op.columns(), 0.0);
  const auto entries = op.row(t);
  for (std::size_t i = 0; i < entries.size(); ++i)
    values[entries.particle(i)] += static_cast<double>(entries.value(i));
  return values;
}

// Differences that hang on directions thinner than `resolution` (relative) are no differences:
// rounding of the moved coordinates hides them. The two reconstructions give the same shape
// functions and ranks; `slack` is the relative change of the inputs, which the result may magnify
// by its own sensitivity.
template <class Scalar>
void expect_same(const BasicReconstruction<Scalar>& a, const BasicReconstruction<Scalar>& b,
                 double slack, const std::string& where, double resolution = 0) {
  ASSERT_EQ(a.values().rows(), b.values().rows());
  for (std::size_t t = 0; t < a.values().rows(); ++t) {
    const FitReport &ra = a.report()[t], &rb = b.report()[t];
    // Above degree 1 the rounding counts relative to the least extent of the particles, which is
    // about degree^2 over the amplification of the gradient; the tenth of `resolution` is the
    // fit's own margin.
    const double extent =
        1 / std::max({1.0f, ra.gradient_amplification, rb.gradient_amplification});
    const double thin = std::max(resolution, 0.1 * resolution / extent);
    if (std::min(ra.smallest_pivot, rb.smallest_pivot) < thin * thin) continue;
    ASSERT_EQ(ra.kept, rb.kept) << where << ", target " << t << ", smallest_pivot "
                                << ra.smallest_pivot << " " << rb.smallest_pivot
                                << ", amplification " << ra.amplification << " "
                                << rb.amplification;
    const auto pa = row(a.values(), t), pb = row(b.values(), t);
    const double tolerance = slack * (4 + ra.rank) * std::max(1.0f, ra.amplification) /
                             std::max(ra.smallest_pivot, 1e-3f);
    for (std::size_t p = 0; p < pa.size(); ++p)
      ASSERT_NEAR(pa[p], pb[p], tolerance)
          << where << ", target " << t << ", particle " << p << ", smallest_pivot "
          << ra.smallest_pivot << ", amplification " << ra.amplification;
  }
}

template <class Scalar, int D>
BasicReconstruction<Scalar> fit(const PointList<Scalar, D>& points,
                                const PointList<Scalar, D>& targets, int degree, double radius,
                                WeightForm form = WeightForm::radial) {
  Options options;
  options.degree = degree;
  options.form = form;
  options.solver = Solver::moment_matrix;  // with its hand-over: the way that most targets go
  options.neighbours = Radius{radius};
  return BasicReconstruction<Scalar>(points_of(points), points_of(targets), options);
}

// Moved by 1e6 in double (128 in float, where 1e6 would leave no digits), on coordinates that can
// be moved exactly.
TYPED_TEST(Invariance, Translation) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const bool single = sizeof(Scalar) == 4;
  const double shift = single ? 128 : 1e6;
  for (auto cloud : hostile_clouds<Scalar, D>()) {
    // Fine structure needs a fine unit, which float does not have; on it a sphere is one up to
    // rounding only. At 1e6 the rounding of a coordinate is 1e-4 of such a cluster: curvature
    // across it is not resolved.
    const int highest = cloud.name == "clustered at 1e-6" ? 1 : 3;
    const bool fine = cloud.name == "clustered at 1e-6" || cloud.name == "almost flat";
    if (fine && single) continue;
    auto targets = hostile_targets<Scalar, D>(cloud.points);
    const int bits = fine ? 33 : single ? 14 : 20;
    quantise<Scalar, D>(cloud.points, bits);
    quantise<Scalar, D>(targets, bits);
    auto moved = cloud.points, moved_targets = targets;
    for (auto* list : {&moved, &moved_targets})
      for (auto& x : *list)
        for (Scalar& c : x) c += static_cast<Scalar>(shift);
    for (int degree = 0; degree <= highest; ++degree) {
      expect_same(fit<Scalar, D>(cloud.points, targets, degree, 0.47),
                  fit<Scalar, D>(moved, moved_targets, degree, 0.47), 20 * TypeParam::eps,
                  cloud.name + ", degree " + std::to_string(degree),
                  100 * TypeParam::eps * shift / 0.47);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(Invariance, Scaling) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const auto targets = hostile_targets<Scalar, D>(cloud.points);
    for (const double scale : {std::ldexp(1.0, 20), std::ldexp(1.0, -20), 1e6, 1e-6}) {
      auto scaled = cloud.points, scaled_targets = targets;
      for (auto* list : {&scaled, &scaled_targets})
        for (auto& x : *list)
          for (Scalar& c : x) c = static_cast<Scalar>(static_cast<double>(c) * scale);
      // Powers of two scale without rounding: the clusters of 1e-6 survive only these unchanged.
      const bool exact = scale != 1e6 && scale != 1e-6;
      if (!exact && cloud.name == "clustered at 1e-6") continue;
      for (int degree = 0; degree <= 3; ++degree) {
        expect_same(
            fit<Scalar, D>(cloud.points, targets, degree, 0.47),
            fit<Scalar, D>(scaled, scaled_targets, degree, 0.47 * scale),
            (exact ? 20 : 2000) * TypeParam::eps,
            cloud.name + ", degree " + std::to_string(degree) + ", scale " + std::to_string(scale));
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
  }
}

// A rotation leaves radial reconstructions alone even where directions are dropped: what is kept on
// a line or a sphere is a property of the particles, not of the axes.
TYPED_TEST(Invariance, Rotation) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  if constexpr (D >= 2) {
    for (const auto& cloud : hostile_clouds<Scalar, D>()) {
      if (cloud.name == "clustered at 1e-6")
        continue;  // rounding of the rotated coordinates is 1e-10 of a cluster
      const auto targets = hostile_targets<Scalar, D>(cloud.points);
      for (const double angle : {std::acos(-1.0) / 4, 1.0, std::acos(-1.0) / 2}) {
        const auto rotate = [angle](PointList<Scalar, D> points) {
          for (auto& x : points)
            for (int d = 0; d + 1 < D; ++d) {
              const double a = x[d], b = x[d + 1];
              x[d] = static_cast<Scalar>(std::cos(angle) * a - std::sin(angle) * b);
              x[d + 1] = static_cast<Scalar>(std::sin(angle) * a + std::cos(angle) * b);
            }
          return points;
        };
        for (int degree = 0; degree <= 3; ++degree) {
          expect_same(fit<Scalar, D>(cloud.points, targets, degree, 0.47),
                      fit<Scalar, D>(rotate(cloud.points), rotate(targets), degree, 0.47),
                      2000 * TypeParam::eps,
                      cloud.name + ", degree " + std::to_string(degree) + ", angle " +
                          std::to_string(angle));
          if (::testing::Test::HasFatalFailure()) return;
        }
      }
    }
  }
}

// Stretching space along the axes and the support with it changes nothing.
TYPED_TEST(Invariance, AnisotropicSupport) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 1), targets = random_points<Scalar, D>(30, 2);
  const std::array<double, 3> stretch{4, 0.5, 2};  // powers of two: exact
  auto wide = points, wide_targets = targets;
  for (auto* list : {&wide, &wide_targets})
    for (auto& x : *list)
      for (int d = 0; d < D; ++d) x[d] *= static_cast<Scalar>(stretch[d]);
  Options options{.degree = 2, .neighbours = Radius{0.4}};
  const BasicReconstruction<Scalar> round(points_of(points), points_of(targets), options);
  options.stretch = stretch;
  const BasicReconstruction<Scalar> stretched(points_of(wide), points_of(wide_targets), options);
  expect_same(round, stretched, TypeParam::eps, "stretched");
  const auto g = numbers_of(round.gradient()), gs = numbers_of(stretched.gradient());
  for (std::size_t i = 0; i < g.size(); ++i)
    EXPECT_NEAR(g[i] / stretch[i % D], gs[i], 1e-3 * TypeParam::eps * 1e4);
}

}  // namespace
}  // namespace recon::testing
