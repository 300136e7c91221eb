// Limited values: in the range of their data, no new extremum beside a step, otherwise the same
// bits; and targets too far from every particle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

template <class C>
class Limits : public ::testing::Test {};
TYPED_TEST_SUITE(Limits, AllCases, CaseNames);

template <class Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

template <class Scalar, std::size_t D>
Matrix<Scalar> step_and_wave(const std::vector<std::array<Scalar, D>>& points) {
  Matrix<Scalar> u(points.size(), 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    u(i, 0) = points[i][0] < Scalar(0.5) ? Scalar(0) : Scalar(1);
    u(i, 1) = std::sin(7 * points[i][D - 1]) + points[i][0];
  }
  return u;
}

// Against the definition: the nearer end of the range of the data with a weight.
TYPED_TEST(Limits, ValuesAreTheNearestInTheRangeOfTheirData) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    if (cloud.points.empty()) continue;
    const auto u = step_and_wave(cloud.points);
    auto targets = random_points<Scalar, D>(120, 5);  // within, beside and outside
    for (auto& x : targets)
      for (Scalar& c : x) c = Scalar(1.4) * c - Scalar(0.2);
    for (int degree = 0; degree <= 4; ++degree) {
      const BasicReconstruction<Scalar> fit(
          points_of(cloud.points), points_of(targets),
          {.degree = degree, .neighbours = Radius{0.35}, .fill_value = -7});
      LimitCount count;
      const auto plain = fit.apply(field_of(u));
      const auto limited = fit.apply(field_of(u), {.limit = Limit::range, .count = &count});
      std::size_t changed_targets = 0, changed = 0;
      for (std::size_t t = 0; t < targets.size(); ++t) {
        std::uint32_t moved = 0;
        for (int c = 0; c < 2; ++c) {
          if (fit.report()[t].status == FitStatus::no_support) {
            EXPECT_EQ(limited(t, c), Scalar(-7));
            continue;
          }
          const auto row = fit.values().row(t);
          Scalar least = std::numeric_limits<Scalar>::max(), greatest = -least;
          for (std::size_t i = 0; i < row.size(); ++i) {
            if (row.value(i) == 0) continue;
            least = std::min(least, u(row.particle(i), c));
            greatest = std::max(greatest, u(row.particle(i), c));
          }
          EXPECT_EQ(limited(t, c), std::clamp(plain(t, c), least, greatest)) << cloud.name;
          // What is not rounding is counted.
          moved += std::abs(limited(t, c) - plain(t, c)) > Scalar(0.02);
        }
        EXPECT_GE(count.components[t], moved) << cloud.name << ", degree " << degree;
        changed += count.components[t];
        changed_targets += count.components[t] > 0;
      }
      EXPECT_EQ(count.values, changed);
      EXPECT_EQ(count.targets, changed_targets);
      if (degree == 0) {
        EXPECT_EQ(count.values, 0u) << cloud.name << ": a mean never leaves";
      }
    }
  }
}

TYPED_TEST(Limits, AStepGetsNoNewExtremum) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 100 : D == 2 ? 30 : 12, 0.4, 1);
  const auto targets = random_points<Scalar, D>(500, 2);
  const auto u = step_and_wave(points);
  for (int degree = 1; degree <= 4; ++degree) {
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                          {.degree = degree});
    LimitCount count;
    const auto plain = fit.apply(field_of(u));
    const auto limited = fit.apply(field_of(u), {.limit = Limit::range, .count = &count});
    EXPECT_GE(limited.col(0).minCoeff(), 0);
    EXPECT_LE(limited.col(0).maxCoeff(), 1);
    if (degree >= 2) {
      EXPECT_GT(plain.col(0).maxCoeff(), 1.03) << "nothing was to be limited";
    }
    if (degree >= 2) {
      EXPECT_GT(count.values, 10u);
    }
  }
}

// Wherever the target lies in the convex hull of the particles in its support, which it does well
// inside a dense cloud: not one of them is limited.
TYPED_TEST(Limits, LinearFieldsAreNotLimitedInside) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 25 : 10, 0.2, 1);
  auto targets = random_points<Scalar, D>(400, 2);
  for (auto& x : targets)
    for (Scalar& c : x) c = Scalar(0.25) + c / 2;
  Matrix<Scalar> u(points.size(), 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    u(i, 0) = 3 * points[i][0] - 2 * points[i][D - 1] + 5;
    u(i, 1) = Scalar(0.1);  // a constant is its own range: rounding is not counted
  }
  for (int degree = 1; degree <= 3; ++degree) {
    const double spacing = D == 1 ? 1.0 / 60 : D == 2 ? 0.04 : 0.1;
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                          {.degree = degree, .neighbours = Radius{3 * spacing}});
    LimitCount count;
    const auto limited = fit.apply(field_of(u), {.limit = Limit::range, .count = &count});
    EXPECT_EQ(count.values, 0u);
    const auto plain = fit.apply(field_of(u));
    EXPECT_EQ(limited.col(0), plain.col(0));
    EXPECT_LE((limited.col(1) - plain.col(1)).cwiseAbs().maxCoeff(), 100 * TypeParam::eps);
  }
}

TYPED_TEST(Limits, SameBitsForAnyNumberOfThreads) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(3000, 1),
             targets = random_points<Scalar, D>(2500, 2);
  const auto u = step_and_wave(points);
  const auto limited = [&](int threads, LimitCount& count) {
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                          {.degree = 2,
                                           .max_distance = 0.7,
                                           .unsupported = Unsupported::nearest,
                                           .threads = threads});
    return fit.apply(field_of(u), {.limit = Limit::range, .count = &count});
  };
  LimitCount one, many;
  const auto expected = limited(1, one);
  EXPECT_GT(one.values, 0u);
  for (const int threads : {2, 5}) {
    const auto got = limited(threads, many);
    EXPECT_TRUE(std::equal(got.data(), got.data() + got.size(), expected.data(),
                           [](Scalar a, Scalar b) { return a == b || (a != a && b != b); }));
    EXPECT_EQ(one.components, many.components);
  }
}

// With the bounds of all data a part of them is limited as all are: here those that targets see.
TYPED_TEST(Limits, APartOfTheDataWithTheBoundsOfAll) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  auto points = random_points<Scalar, D>(600, 1);
  auto targets = random_points<Scalar, D>(300, 2);
  for (auto& x : targets)
    for (Scalar& c : x) c = Scalar(1.6) * c - Scalar(0.3);
  const auto part = points;
  const Options options{.degree = 2, .neighbours = Radius{0.4}};
  points.insert(points.begin(), 2, points[0]);  // far away, and lowest and highest
  points[0][0] = 50, points[1][0] = 60;
  auto u = step_and_wave(points);
  u.row(0).setConstant(-20), u.row(1).setConstant(30);
  const Matrix<Scalar> u_part = u.bottomRows(static_cast<Eigen::Index>(part.size()));
  const BasicReconstruction<Scalar> all(points_of(points), points_of(targets), options),
      some(points_of(part), points_of(targets), options);
  const std::vector<DataBounds> bounds{{-20, 30}, {-20, 30}};
  LimitCount counts[3];
  const Matrix<Scalar> expected =
      all.apply(field_of(u), {.limit = Limit::relaxed, .count = &counts[0]});
  const Matrix<Scalar> got = some.apply(
      field_of(u_part), {.limit = Limit::relaxed, .count = &counts[1], .bounds = bounds});
  const Matrix<Scalar> without =
      some.apply(field_of(u_part), {.limit = Limit::relaxed, .count = &counts[2]});
  EXPECT_EQ(counts[0].components, counts[1].components);
  EXPECT_GT(counts[2].values, counts[0].values);
  double apart = 0;
  for (Eigen::Index t = 0; t < expected.rows(); ++t)
    for (int c = 0; c < 2; ++c) {
      const FitReport& report = all.report()[static_cast<std::size_t>(t)];
      if (report.status == FitStatus::no_support) continue;
      // What rounding may do: the far particles change how coordinates are rounded.
      const double rounding = 64 * std::numeric_limits<Scalar>::epsilon() *
                              std::max(1.0, double(report.amplification)) / report.smallest_pivot;
      EXPECT_NEAR(got(t, c), expected(t, c), rounding * (1 + std::abs(expected(t, c))));
      apart = std::max(apart, std::abs(double(without(t, c)) - double(expected(t, c))));
    }
  EXPECT_GT(apart, 0.1);
  const auto refused = [&](std::vector<DataBounds> wrong) {
    return message_of(
        [&] { some.apply(field_of(u_part), {.limit = Limit::relaxed, .bounds = wrong}); });
  };
  EXPECT_THAT(refused({{0, 1}}), HasSubstr("number of bounds = 1"));
  EXPECT_THAT(refused({{0, 1}, {1, 0}}), HasSubstr("least value of the bounds = 1"));
  EXPECT_THAT(refused({{0, 1}, {std::nan(""), 0}}), HasSubstr("least value of the bounds = nan"));
}

// Three particles close together, values 0, 1, 0: far from them the plane through them is far away.
TEST(Limit, ThreeParticlesCloseTogether) {
  const PointList<double, 2> points{{0, 0}, {0.3, 0}, {0, 0.3}};
  const std::vector<double> u{0, 1, 0};
  const PointList<double, 2> targets{{2, 0}, {0.1, 0.1}, {0, 2}};
  const auto fit =
      reconstruct(points_of(points), points_of(targets), {.degree = 1, .neighbours = Radius{3}});
  EXPECT_GT(fit.apply(field_of(u))(0, 0), 6);
  LimitCount count;
  const Eigen::MatrixXd v = fit.apply(field_of(u), {.limit = Limit::range, .count = &count});
  EXPECT_EQ(v(0, 0), 1);
  EXPECT_NEAR(v(1, 0), 1.0 / 3, 1e-14);
  EXPECT_NEAR(v(2, 0), 0, 1e-14);
  EXPECT_EQ(count.components, (std::vector<std::uint32_t>{1, 0, 0}));
  // Operators, their transposes and gradients are the fit's own.
  EXPECT_GT(fit.values().apply(field_of(u))(0, 0), 6);
  EXPECT_NEAR(fit.gradient(Derivative::diffuse).apply(field_of(u))(0, 0), 1 / 0.3, 1e-12);
  fit.apply(field_of(u), {.count = &count});
  EXPECT_EQ(count.components, (std::vector<std::uint32_t>{0, 0, 0}));
}

// ---- Targets that are too far -------------------------------------------------------------------

template <class C>
class TooFar : public ::testing::Test {};
TYPED_TEST_SUITE(TooFar, AllCases, CaseNames);

// The distance from a target to the nearest particle in local spacings there, by its definition.
template <class Scalar, int D>
double distance_in_spacings(const PointList<Scalar, D>& points, const std::array<Scalar, D>& x,
                            const std::array<double, 3>& period) {
  const auto distances = [&](const std::array<Scalar, D>& from) {
    std::vector<std::pair<double, std::size_t>> all;
    for (std::size_t p = 0; p < points.size(); ++p)
      for (int image = -2; image <= 2; ++image) {
        if (image != 0 && period[0] == 0) continue;
        double square = 0;
        for (int d = 0; d < D; ++d) {
          const double offset = static_cast<double>(points[p][d]) - static_cast<double>(from[d]) +
                                (d == 0 ? image * period[0] : 0);
          square += offset * offset;
        }
        all.push_back({std::sqrt(square), p});
      }
    std::sort(all.begin(), all.end());
    return all;
  };
  const auto near = distances(x).front();
  const auto around = distances(points[near.second]);
  return near.first / around[std::min<std::size_t>(2 * D + 3, around.size() - 1)].first;
}

TYPED_TEST(TooFar, ByTheDistanceToTheNearestParticle) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 12 : 6, 0.3, 1);
  auto targets = random_points<Scalar, D>(300, 2);
  for (auto& x : targets)
    for (int d = 0; d < D; ++d)  // the first axis is periodic in [0, 1] below
      x[d] = d == 0 && D > 1 ? x[d] : 4 * x[d] - Scalar(1.5);
  const std::vector<Scalar> u(points.size(), Scalar(2));
  const double spacing = D == 1 ? 1.0 / 60 : D == 2 ? 1.0 / 12 : 1.0 / 6;
  for (const bool periodic : {false, D > 1})
    for (const WeightForm form : {WeightForm::radial, WeightForm::tensor_product})
      for (const NeighbourRule& rule :
           {NeighbourRule(Nearest{7}), NeighbourRule(Radius{2.2 * spacing}),
            NeighbourRule(Radius{20 * spacing}), NeighbourRule(NearestWithin{5, 4 * spacing})}) {
        Options options{.degree = 1,
                        .form = form,
                        .neighbours = rule,
                        .max_distance = 1.7,
                        .grow = {.steps = 3},
                        .unsupported = Unsupported::nearest,
                        .fill_value = -3};
        options.domain.periodic[0] = periodic;
        options.domain.upper[0] = 1;
        const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
        const auto values = fit.apply(field_of(u));
        const auto gradient = fit.gradient().apply(field_of(u));
        std::size_t far = 0;
        for (std::size_t t = 0; t < targets.size(); ++t) {
          const double distance =
              distance_in_spacings<Scalar, D>(points, targets[t], {periodic ? 1.0 : 0.0, 0, 0});
          if (std::abs(distance - 1.7) < 1e-4) continue;
          EXPECT_EQ(fit.report()[t].status == FitStatus::too_far, distance > 1.7) << distance;
          EXPECT_NEAR(values(t, 0), distance > 1.7 ? -3 : 2, 1e-4);
          if (distance > 1.7) {
            EXPECT_EQ(gradient(t, D - 1), Scalar(-3));
          }
          if (distance > 1.7) {
            EXPECT_EQ(fit.values().row(t).size(), 0u);
          }
          far += distance > 1.7;
        }
        EXPECT_EQ(fit.report().too_far(), far);
        EXPECT_GT(far, 20u);
      }
}

// A multiple of 2 takes nothing from clouds that are dense in their box.
TYPED_TEST(TooFar, DenseParticlesHaveNone) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  constexpr std::size_t n = D == 1 ? 2000 : D == 2 ? 60 : 16;
  const auto targets = random_points<Scalar, D>(20000, 9);
  std::size_t count = 1;
  for (int d = 0; d < D; ++d) count *= n;
  std::vector<NamedCloud<Scalar, D>> clouds{{"regular", regular_points<Scalar, D>(n)},
                                            {"jittered", jittered_points<Scalar, D>(n, 0.5, 1)},
                                            {"copies", jittered_points<Scalar, D>(n, 0.5, 3)}};
  for (int copy = 0; copy < 3; ++copy)
    clouds[2].points.insert(clouds[2].points.end(), clouds[1].points.begin(),
                            clouds[1].points.end());
  if (D > 1) clouds.push_back({"random", random_points<Scalar, D>(count, 2)});
  if (D > 1) clouds.push_back({"random, twice", duplicated_points<Scalar, D>(count / 2, 2, 2)});
  for (const auto& cloud : clouds)
    EXPECT_EQ(BasicReconstruction<Scalar>(points_of(cloud.points), points_of(targets),
                                          {.max_distance = 2.0})
                  .report()
                  .too_far(),
              0u)
        << cloud.name;
}

// One place has no spacing, and a list of one's own is judged as those that are searched.
TEST(TooFarTargets, OnePlaceAndOwnLists) {
  const PointList<double, 2> once{{0.5, 0.5}, {0.5, 0.5}}, targets{{0.5, 0.5}, {90, 0}, {4, 0}};
  EXPECT_EQ(
      reconstruct(points_of(once), points_of(targets), {.max_distance = 1.0}).report().too_far(),
      0u);
  const PointList<double, 2> points{{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  NeighbourList<double> list;
  list.offsets.assign({0, 4, 8, 12});
  list.indices.assign({0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3});
  list.support.assign({200, 200, 200});
  const auto fit = reconstruct(points_of(points), points_of(targets), list, {.max_distance = 3.0});
  EXPECT_EQ(fit.report().with_status(FitStatus::too_far), std::vector<std::size_t>{1});
  for (const double wrong : {0.0, -1.0, std::nan("")})
    EXPECT_THAT(message_of([&] {
                  reconstruct(points_of(points), points_of(targets), {.max_distance = wrong});
                }),
                HasSubstr("max_distance"));
}

}  // namespace
}  // namespace recon::testing
