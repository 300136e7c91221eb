// Gradients across thin clouds: a slope that only noise resolves is reported, not invented.
#include <gtest/gtest.h>

#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/solvers.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

constexpr double data_noise = 1e-3;

// 20 x 20 particles near z = height(x, y), moved by up to `noise` along z, with u = x + noise.
struct Sheet {
  PointList<double, 3> points, targets;
  std::vector<double> u;
  template <class Height>
  Sheet(double noise, Height height) {
    RandomNumbers random(3);
    for (int i = 0; i < 20; ++i)
      for (int j = 0; j < 20; ++j) {
        const double x = (i + random.uniform(0.2, 0.8)) / 20,
                     y = (j + random.uniform(0.2, 0.8)) / 20;
        points.push_back({x, y, height(x, y) + noise * random.uniform(-1, 1)});
        u.push_back(x + data_noise * random.uniform(-1, 1));
        if (i % 6 == 4 && j % 5 == 4) targets.push_back({x + 0.01, y, height(x + 0.01, y)});
      }
  }
};

// Turned about two axes by an angle.
std::array<double, 3> turned(const std::array<double, 3>& x, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const std::array<double, 3> y{c * x[0] - s * x[2], x[1], s * x[0] + c * x[2]};
  return {y[0], c * y[1] - s * y[2], s * y[1] + c * y[2]};
}
PointList<double, 3> turned(PointList<double, 3> points, double angle) {
  for (auto& x : points) x = turned(x, angle);
  return points;
}

template <class Scalar>
PointList<Scalar, 3> rounded(const PointList<double, 3>& points) {
  PointList<Scalar, 3> out;
  for (const auto& x : points)
    out.push_back(
        {static_cast<Scalar>(x[0]), static_cast<Scalar>(x[1]), static_cast<Scalar>(x[2])});
  return out;
}

template <class Scalar>
class ThinClouds : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(ThinClouds, Scalars);

// A sheet whose thickness is noise, from next to nothing to a thousandth of the spacing, however it
// is turned: the slope in it is that of the data, and there is none across it.
TYPED_TEST(ThinClouds, NoSlopeAcrossASheet) {
  using Scalar = TypeParam;
  for (const double thickness : {0.0, 1e-12, 2e-6, 1e-5})
    for (const double angle : {0.0, 0.7}) {
      const Sheet sheet(thickness, [](double, double) { return 0.0; });
      const auto points = rounded<Scalar>(turned(sheet.points, angle));
      const auto targets = rounded<Scalar>(turned(sheet.targets, angle));
      const std::vector<Scalar> u(sheet.u.begin(), sheet.u.end());
      const auto along = turned(std::array<double, 3>{1, 0, 0}, angle);
      const auto across = turned(std::array<double, 3>{0, 0, 1}, angle);
      for (const Solver solver : all_solvers)
        for (const int degree : {1, 2}) {
          const BasicReconstruction<Scalar> fit(
              points_of(points), points_of(targets),
              {.degree = degree, .neighbours = Radius{0.2}, .solver = solver});
          for (const Derivative kind : {Derivative::exact, Derivative::diffuse}) {
            const auto g = fit.gradient(kind).apply(field_of(u));
            for (std::size_t t = 0; t < targets.size(); ++t) {
              const std::string at = "thickness " + std::to_string(thickness) + ", angle " +
                                     std::to_string(angle) + ", " + std::string(name_of(solver)) +
                                     ", degree " + std::to_string(degree);
              const FitReport& report = fit.report()[t];
              ASSERT_EQ(report.gradient_rank, 2) << at;
              EXPECT_LT(report.gradient_amplification, 200) << at;
              double in_sheet = 0, normal = 0;
              for (int d = 0; d < 3; ++d) {
                in_sheet += static_cast<double>(g(t, d)) * along[d];
                normal += static_cast<double>(g(t, d)) * across[d];
              }
              EXPECT_NEAR(in_sheet, 1, 20 * data_noise / 0.2) << at;
              // The sheet that fits the particles best is tilted a little against the true one.
              EXPECT_NEAR(normal, 0,
                          10 * thickness / 0.2 + 100 * std::numeric_limits<Scalar>::epsilon())
                  << at;
            }
          }
        }
    }
}

// Values, ranks and statuses are those of a fit that resolves every slope.
TEST(ThinClouds, ValuesStayAsTheyAre) {
  const Sheet sheet(2e-6, [](double, double) { return 0.0; });
  for (const Solver solver : all_solvers)
    for (const int degree : {1, 2}) {
      Options options{.degree = degree, .neighbours = Radius{0.2}, .solver = solver};
      const auto fit = reconstruct(points_of(sheet.points), points_of(sheet.targets), options);
      options.tolerances.gradient_extent = 0;
      const auto bold = reconstruct(points_of(sheet.points), points_of(sheet.targets), options);
      EXPECT_GT(bold.gradient().apply(field_of(sheet.u)).col(2).cwiseAbs().maxCoeff(), 10);
      for (std::size_t t = 0; t < sheet.targets.size(); ++t) {
        const FitReport &a = fit.report()[t], &b = bold.report()[t];
        EXPECT_EQ(b.gradient_rank, 3);
        EXPECT_GT(b.gradient_amplification, 1e4);
        EXPECT_EQ(a.status, b.status);
        EXPECT_EQ(a.kept, b.kept);
        EXPECT_NEAR(a.amplification, b.amplification, 1e-4 * b.amplification);
      }
      const Eigen::MatrixXd difference =
          fit.apply(field_of(sheet.u)) - bold.apply(field_of(sheet.u));
      EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-9);
    }
}

// A thin bowl: at degree 1 its curvature resolves the slope across it, at degree 2 the curved terms
// explain it, and what is left is noise. The slope in the tangent plane stays.
TEST(ThinClouds, CurvedSheet) {
  const auto height = [](double x, double y) {
    return 0.4 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5));
  };
  const Sheet sheet(1e-7, height);
  for (const Solver solver : all_solvers) {
    Options options{.degree = 1, .neighbours = Radius{0.25}, .solver = solver};
    const auto linear = reconstruct(points_of(sheet.points), points_of(sheet.targets), options);
    options.degree = 2;
    const auto quadratic = reconstruct(points_of(sheet.points), points_of(sheet.targets), options);
    const auto g = quadratic.gradient().apply(field_of(sheet.u));
    for (std::size_t t = 0; t < sheet.targets.size(); ++t) {
      EXPECT_EQ(linear.report()[t].gradient_rank, 3);
      EXPECT_LT(linear.report()[t].gradient_amplification, 200);
      EXPECT_EQ(quadratic.report()[t].gradient_rank, 2);
      const double slope_x = 0.8 * (sheet.targets[t][0] - 0.5),
                   slope_y = 0.8 * (sheet.targets[t][1] - 0.5);
      // u = x: the part of e_x in the tangent plane.
      const double norm2 = 1 + slope_x * slope_x + slope_y * slope_y;
      const std::array<double, 3> normal{-slope_x, -slope_y, 1};
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(g(t, d), (d == 0) + slope_x / norm2 * normal[d], 50 * data_noise / 0.25)
            << name_of(solver) << ", target " << t << ", axis " << d;
    }
  }
}

// Second derivatives take no part in a direction that is not resolved either.
TEST(ThinClouds, HessianStaysInTheSheet) {
  const Sheet sheet(1e-9, [](double, double) { return 0.0; });
  std::vector<double> u;
  for (std::size_t p = 0; p < sheet.u.size(); ++p)
    u.push_back(sheet.points[p][0] * sheet.points[p][0] + (sheet.u[p] - sheet.points[p][0]));
  const auto h = reconstruct(points_of(sheet.points), points_of(sheet.targets),
                             {.degree = 2, .neighbours = Radius{0.25}})
                     .hessian()
                     .apply(field_of(u));
  for (Eigen::Index t = 0; t < h.rows(); ++t) {
    EXPECT_NEAR(h(t, 0), 2, 200 * data_noise / (0.25 * 0.25));
    for (const int entry : {2, 4, 5}) EXPECT_NEAR(h(t, entry), 0, 1e-5) << entry;
  }
}

// However thin it is and however it is turned: along the normal, and of a bowl in all directions,
// nothing of the order of noise / thickness^2 is left.
TEST(ThinClouds, HessianOfTurnedAndCurvedSheets) {
  for (const double curvature : {0.0, 0.4}) {
    const Sheet sheet(curvature > 0 ? 1e-7 : 1e-12, [&](double x, double y) {
      return curvature * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5));
    });
    const auto points = turned(sheet.points, 0.7), targets = turned(sheet.targets, 0.7);
    for (const Solver solver : all_solvers) {
      const auto h = reconstruct(points_of(points), points_of(targets),
                                 {.degree = 2, .neighbours = Radius{0.25}, .solver = solver})
                         .hessian()
                         .apply(field_of(sheet.u));
      EXPECT_LT(h.cwiseAbs().maxCoeff(), 200 * data_noise / (0.25 * 0.25)) << curvature;
    }
  }
}

// The same where the sag of the bowl is far below the extent that a slope needs, and its thickness
// far below the sag: its curvature is then unknown, which is not taken for that of the data.
TEST(ThinClouds, HessianOfAlmostFlatBowls) {
  for (const double curvature : {1e-2, 1e-3, 1e-4, 1e-6})
    for (const double thickness : {1e-5, 1e-7, 1e-9, 1e-11}) {
      const Sheet sheet(thickness * curvature, [&](double x, double y) {
        return curvature * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5));
      });
      for (const double angle : {0.0, 0.7}) {
        const auto points = turned(sheet.points, angle), targets = turned(sheet.targets, angle);
        const auto fit = reconstruct(points_of(points), points_of(targets),
                                     {.degree = 2, .neighbours = Radius{0.25}});
        const auto h = fit.hessian().apply(field_of(sheet.u));
        for (std::size_t t = 0; t < targets.size(); ++t) {
          if (fit.report()[t].kept[2] < 6) continue;  // bowls to rounding: the kept terms are known
          EXPECT_LT(h.row(t).cwiseAbs().maxCoeff(), 200 * data_noise / (0.25 * 0.25))
              << curvature << ", " << thickness << ", " << angle;
        }
      }
    }
}

// Second derivatives of a quadratic field in random clouds with hardly enough particles, of which
// some lie near a curve by chance: where the report has them they are right in all directions in
// which the gradient is resolved, else they are 0. The same for such clouds squeezed along a
// direction that is no axis. Counts targets with second derivatives in some directions, and those
// with a slope but none.
template <int D>
void expect_hessians_of_quadratics(std::size_t count, double radius, double squeeze, int seeds,
                                   std::size_t& partly, std::size_t& none) {
  constexpr int seconds = D * (D + 1) / 2;
  using Matrix = Eigen::Matrix<double, D, D>;
  for (int seed = 1; seed <= seeds; ++seed) {
    auto points = random_points<double, D>(count, seed),
         targets = random_points<double, D>(20, 1000 + seed);
    for (auto* list : {&points, &targets})
      for (auto& x : *list) {
        const double along = x[0], across = squeeze * x[D - 1];
        x[0] = 0.6 * along - 0.8 * across;
        x[D - 1] = 0.8 * along + 0.6 * across;
      }
    RandomNumbers random(seed);
    Matrix second;
    std::array<double, D> slope;
    for (int a = 0; a < D; ++a) {
      slope[a] = random.uniform(-1, 1);
      for (int b = 0; b <= a; ++b) second(a, b) = second(b, a) = random.uniform(-1, 1);
    }
    std::vector<double> u;
    for (const auto& x : points) {
      const Eigen::Map<const Eigen::Matrix<double, D, 1>> at(x.data());
      u.push_back(0.5 * at.dot(second * at));
      for (int d = 0; d < D; ++d) u.back() += slope[d] * x[d];
    }
    for (const Solver solver : all_solvers) {
      const auto fit = reconstruct(points_of(points), points_of(targets),
                                   {.degree = 2, .neighbours = Radius{radius}, .solver = solver});
      const auto gradient = fit.gradient(Derivative::diffuse), hessian = fit.hessian();
      const auto h = hessian.apply(field_of(u));
      const auto q =
          gradient.apply(field_of(points));  // the projector onto the resolved directions
      for (std::size_t t = 0; t < targets.size(); ++t) {
        const FitReport& report = fit.report()[t];
        const std::string at = std::to_string(D) + "-D, seed " + std::to_string(seed) + ", " +
                               std::string(name_of(solver)) + ", target " + std::to_string(t);
        if (report.status == FitStatus::no_support) continue;
        ASSERT_TRUE(report.hessian_rank == report.gradient_rank || report.hessian_rank == 0) << at;
        const int r = report.gradient_rank;
        if (report.kept[2] < r * (r + 1) / 2) {
          EXPECT_EQ(report.hessian_rank, 0) << at;
          continue;
        }
        if (report.hessian_rank == 0) {
          none += report.degree == 2 && report.gradient_rank > 0;
          for (int e = 0; e < seconds; ++e) EXPECT_EQ(h(t, e), 0) << at;
          continue;
        }
        if (report.degree < 2) continue;
        partly += report.gradient_rank < D;
        Matrix projector;
        const auto slopes = gradient.row(t), row = hessian.row(t);
        double of_slopes = 0;
        for (std::size_t i = 0; i < slopes.size(); ++i)
          for (int d = 0; d < D; ++d) of_slopes += std::abs(slopes.value(i, d));
        for (int a = 0; a < D; ++a)
          for (int b = 0; b < D; ++b) projector(a, b) = q(t, a * D + b);
        const Matrix expected = projector * second * projector;
        const double loss = solver == Solver::moment_matrix ? 1 / report.smallest_pivot : 1.0;
        int e = 0;
        for (int a = 0; a < D; ++a)
          for (int b = a; b < D; ++b, ++e) {
            double amplification = of_slopes * second.norm();
            for (std::size_t i = 0; i < row.size(); ++i) amplification += std::abs(row.value(i, e));
            EXPECT_NEAR(h(t, e), expected(a, b),
                        8 * std::numeric_limits<double>::epsilon() * (4 + report.rank) * loss *
                            std::max(1.0f, report.amplification) * 4 * amplification)
                << at << ", entry " << e << ", gradient_rank " << int(report.gradient_rank);
          }
      }
    }
  }
}

// Whether second derivatives of x^2 are right in all resolved directions, and hessian_rank says so:
// four particles do not tell them, nor do those on a circle or on two planes; those in one plane
// tell all that lie in it.
TEST(HessianRank, CountsTheTermsThatAreKept) {
  const auto report_of = [](const auto& points, double radius) {
    const PointList<double, std::tuple_size_v<std::decay_t<decltype(points[0])>>> target{{}};
    return reconstruct(points_of(points), points_of(target),
                       {.degree = 2, .neighbours = Radius{radius}})
        .report()[0];
  };
  const PointList<double, 2> four{{-0.3, -0.2}, {0.4, -0.1}, {0.1, 0.5}, {-0.2, 0.3}};
  const FitReport of_four = report_of(four, 1);
  EXPECT_EQ(of_four.kept[2], 1);
  EXPECT_EQ(of_four.gradient_rank, 2);
  EXPECT_EQ(of_four.hessian_rank, 0);

  PointList<double, 2> circle;
  for (int i = 0; i < 12; ++i) circle.push_back({std::cos(0.52 * i), std::sin(0.52 * i)});
  const FitReport of_circle = report_of(circle, 1.5);
  EXPECT_EQ(of_circle.kept[2], 2);
  EXPECT_EQ(of_circle.gradient_rank, 2);
  EXPECT_EQ(of_circle.hessian_rank, 0);

  PointList<double, 3> planes, plane;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) {
      const double x = 0.2 * i - 0.43, y = 0.2 * j - 0.38;
      planes.push_back({x, y, 0.1});
      planes.push_back({x, y, -0.1});
      plane.push_back({x, y, 0});
    }
  const FitReport of_planes = report_of(planes, 1);
  EXPECT_EQ(of_planes.kept[2], 5);
  EXPECT_EQ(of_planes.gradient_rank, 3);
  EXPECT_EQ(of_planes.hessian_rank, 0);
  const FitReport of_plane = report_of(plane, 1);
  EXPECT_EQ(of_plane.kept[2], 3);
  EXPECT_EQ(of_plane.gradient_rank, 2);
  EXPECT_EQ(of_plane.hessian_rank, 2);
}

TEST(RandomClouds, HessiansOfQuadraticsAreRightOrNone) {
  std::size_t partly = 0, none = 0;
  expect_hessians_of_quadratics<2>(40, 0.3, 1, 150, partly, none);
  expect_hessians_of_quadratics<2>(40, 0.22, 1, 50, partly, none);
  EXPECT_GT(none, 50u);  // there are such targets
  none = 0;
  expect_hessians_of_quadratics<3>(150, 0.4, 1, 40, partly, none);
  expect_hessians_of_quadratics<3>(150, 0.33, 1, 40, partly, none);
  EXPECT_GT(none, 20u);
}

TEST(RandomClouds, HessiansOfQuadraticsInSqueezedClouds) {
  for (const double squeeze : {1e-2, 1e-4, 1e-6, 1e-8}) {
    std::size_t partly = 0, none = 0;
    expect_hessians_of_quadratics<2>(60, 0.3, squeeze, 20, partly, none);
    expect_hessians_of_quadratics<3>(200, 0.3, squeeze, 10, partly, none);
    if (squeeze < 1e-3) {
      EXPECT_GT(partly, 1000u);
    }
  }
}

template <class C>
class GradientReport : public ::testing::Test {};
TYPED_TEST_SUITE(GradientReport, AllCases, CaseNames);

// On clouds that fill space all directions are resolved, and the check changes no bit.
TYPED_TEST(GradientReport, AllDirectionsOfEvenClouds) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const std::size_t n = D == 1 ? 60 : D == 2 ? 16 : 8;
  for (const auto& points : {regular_points<Scalar, D>(n), jittered_points<Scalar, D>(n, 0.4, 1),
                             random_points<Scalar, D>(500, 2)})
    for (int degree = 0; degree <= 3; ++degree)
      for (const Solver solver : all_solvers) {
        const auto targets = random_points<Scalar, D>(20, 3);
        Options options{.degree = degree, .solver = solver};
        const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
        options.tolerances.gradient_extent = 0;
        const BasicReconstruction<Scalar> bold(points_of(points), points_of(targets), options);
        const auto g = fit.gradient(), expected = bold.gradient();
        const auto diffuse = fit.gradient(Derivative::diffuse);
        for (std::size_t t = 0; t < targets.size(); ++t) {
          const FitReport& report = fit.report()[t];
          if (report.status != FitStatus::full) continue;
          EXPECT_EQ(report, bold.report()[t]);
          EXPECT_EQ(report.gradient_rank, degree == 0 ? 0 : D);
          const auto row = g.row(t), other = expected.row(t), slope = diffuse.row(t);
          for (int d = 0; d < D; ++d) {
            double sum = 0;
            for (std::size_t i = 0; i < row.size(); ++i) {
              EXPECT_EQ(row.value(i, d), other.value(i, d));
              sum += std::abs(static_cast<double>(slope.value(i, d)));
            }
            // gradient_amplification bounds what errors of the data can do.
            EXPECT_LE(sum * static_cast<double>(fit.support(t)),
                      report.gradient_amplification * (1 + 100 * rounding<Scalar>(report)) + 1e-6);
          }
        }
      }
}

// With fewer directions kept, both kinds of gradients stay within these.
TEST(ThinClouds, ExactGradientOfALineIsAlongIt) {
  const auto points = diagonal_points<double, 3>(40, 3);
  std::vector<double> u;
  for (const auto& x : points) u.push_back(2 + std::sin(3 * x[0]));
  const PointList<double, 3> targets{{0.6, 0.5, 0.5}};
  for (const Solver solver : all_solvers) {
    const auto fit = reconstruct(points_of(points), points_of(targets),
                                 {.degree = 1, .neighbours = Radius{0.5}, .solver = solver});
    EXPECT_EQ(fit.report()[0].gradient_rank, 1);
    const auto g = fit.gradient().apply(field_of(u));
    EXPECT_NEAR(g(0, 0), g(0, 1), 1e-12);
    EXPECT_NEAR(g(0, 0), g(0, 2), 1e-12);
    EXPECT_GT(std::abs(g(0, 0)), 1e-3);
  }
}

// Most of the weight in a dense cluster on one side, a lone particle on the other: the fit between
// them is an interpolation that amplifies nothing, though sqrt(sum w e^T M^-1 e) is 30 and more.
TEST(DenseCluster, DoesNotLowerTheDegree) {
  PointList<double, 1> points;
  RandomNumbers random(7);
  for (int i = 0; i < 8000; ++i) points.push_back({0.5 + 1e-4 * random.uniform(-1, 1)});
  points.push_back({-0.5});
  const PointList<double, 1> targets{{0.0}};
  std::vector<double> u;
  for (const auto& x : points) u.push_back(3 + 2 * x[0]);
  for (const Solver solver : all_solvers) {
    const auto fit = reconstruct(points_of(points), points_of(targets),
                                 {.degree = 1, .neighbours = Radius{1}, .solver = solver});
    const FitReport& report = fit.report()[0];
    EXPECT_EQ(report.status, FitStatus::full) << name_of(solver);
    EXPECT_NEAR(fit.apply(field_of(u))(0, 0), 3, 1e-10);
    double sum = 0;
    const auto row = fit.values().row(0);
    for (std::size_t i = 0; i < row.size(); ++i) sum += std::abs(row.value(i));
    EXPECT_LT(sum, 1.1);
    EXPECT_NEAR(report.amplification, sum, 1e-5);
  }
}

// Where it does extrapolate, the direction is dropped as before.
TEST(DenseCluster, ExtrapolationIsStillDropped) {
  PointList<double, 1> points;
  RandomNumbers random(7);
  for (int i = 0; i < 8000; ++i) points.push_back({0.5 + 1e-4 * random.uniform(-1, 1)});
  const PointList<double, 1> targets{{0.0}};
  const auto fit =
      reconstruct(points_of(points), points_of(targets), {.degree = 1, .neighbours = Radius{1}});
  EXPECT_EQ(fit.report()[0].status, FitStatus::reduced);
  EXPECT_EQ(fit.report()[0].gradient_rank, 0);
}

template <class Scalar>
class Underflow : public ::testing::Test {};
TYPED_TEST_SUITE(Underflow, Scalars);

// Lengths whose squares underflow are refused, as those whose squares overflow are; down to that,
// units do not matter.
TYPED_TEST(Underflow, TinyLengthsAreRefused) {
  using Scalar = TypeParam;
  const double least = std::sqrt(static_cast<double>(std::numeric_limits<Scalar>::min()));
  const auto points = random_points<Scalar, 2>(100, 1), targets = random_points<Scalar, 2>(5, 2);
  const auto scaled = [](PointList<Scalar, 2> list, double unit) {
    for (auto& x : list)
      for (Scalar& c : x) c = static_cast<Scalar>(static_cast<double>(c) * unit);
    return list;
  };
  std::vector<Scalar> u;
  for (const auto& x : points) u.push_back(1 + x[0]);
  const auto fit = [&](double unit, const NeighbourRule& rule) {
    const auto p = scaled(points, unit), t = scaled(targets, unit);
    return BasicReconstruction<Scalar>(points_of(p), points_of(t), {.neighbours = rule})
        .apply(field_of(u));
  };
  const auto expected = fit(1, Nearest{8});
  for (const double unit : {1e3 * least, 1e6 * least})
    for (const NeighbourRule& rule : {NeighbourRule(Nearest{8}), NeighbourRule(Radius{0.3 * unit})})
      for (Eigen::Index t = 0; t < expected.rows(); ++t)
        EXPECT_NEAR(fit(unit, rule)(t, 0), 1 + targets[t][0], 1e-5) << unit;
  for (const double unit : {1e-2 * least, 1e-10 * least}) {
    EXPECT_THROW(fit(unit, Nearest{8}), InvalidArgument);
    EXPECT_THROW(fit(unit, Radius{0.3 * unit}), InvalidArgument);
  }
  EXPECT_THROW(fit(1, Radius{0.1 * least}), InvalidArgument);
}

}  // namespace
}  // namespace recon::testing
