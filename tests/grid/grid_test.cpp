// What a reconstruction on a grid promises by itself: reproduction, additivity, the same bits for
// any number of threads, agreement of the instruction sets, and clear words about bad input.
#include <gmock/gmock.h>

#include <cstring>

#include "grid_support.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

template <class C>
class Grid : public ::testing::Test {};
TYPED_TEST_SUITE(Grid, AllCases, CaseNames);

template <class Scalar>
bool same_bits(const Matrix<Scalar>& a, const Matrix<Scalar>& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(Scalar) * static_cast<std::size_t>(a.size())) == 0;
}

// Also where the grid reaches beyond the particles, and for particles far from the origin.
TYPED_TEST(Grid, PolynomialsAreReproduced) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const double shift : {0.0, sizeof(Scalar) == 4 ? 100.0 : 1e6}) {
    auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 20 : 10, 0.5, 3);
    auto grid = uneven_grid<Scalar, D>();
    for (int d = 0; d < D; ++d) grid.origin[d] += static_cast<Scalar>(shift);
    for (auto& x : points)
      for (Scalar& c : x) c += static_cast<Scalar>(shift);
    for (int degree = 0; degree <= 2; ++degree) {
      const auto polynomial = [&](const auto& x) {
        double value = 1;
        for (int d = 0; d < D && degree > 0; ++d) {
          const double y = static_cast<double>(x[d]) - shift;
          value +=
              (d + 1) * y + (degree > 1 ? (d - 0.7) * y * (static_cast<double>(x[0]) - shift) : 0);
        }
        return static_cast<Scalar>(value);
      };
      std::vector<Scalar> u;
      for (const auto& x : points) u.push_back(polynomial(x));
      const auto fit =
          reconstruct_on_grid(points_of(points), {field_of(u)}, grid, {.degree = degree});
      for (std::size_t i = 0; i < grid.size(); ++i) {
        const FitReport& report = fit.report()[i];
        if (report.degree < degree) continue;
        std::array<Scalar, D> x;
        for (int d = 0; d < D; ++d) x[d] = grid.coordinate(grid.index(i)[d], d);
        const double noise = (1 + shift) * TypeParam::eps * 20 * report.amplification;
        EXPECT_NEAR(fit.values()(i, 0), polynomial(x), 4 * allowed<Scalar>(report) + noise)
            << "degree " << degree << ", shift " << shift << ", node " << i;
      }
      EXPECT_GT(fit.report().summary().full, grid.size() / 8);
    }
  }
}

TYPED_TEST(Grid, TheSameBitsForAnyNumberOfThreads) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(3000, 3);
  const Matrix<Scalar> u = wave(points, 4);
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) {
    grid.counts[d] = D == 1 ? 500 : D == 2 ? 70 : 34;
    grid.spacing[d] = 1 / static_cast<Scalar>(grid.counts[d] - 1);
  }
  for (const Weight weight : {Weight::cubic_b_spline, Weight::quadratic_b_spline}) {
    Options options{.weight = weight, .threads = 1};
    const GridApply with_gradients{.gradients = Derivative::diffuse};
    const auto one =
        reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, with_gradients);
    const BasicGridMoments<Scalar> moments(points_of(points), {field_of(u)}, grid, options);
    for (const int threads : {2, 3, 7}) {
      options.threads = threads;
      const auto many =
          reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, with_gradients);
      EXPECT_TRUE(same_bits<Scalar>(one.values(), many.values())) << threads;
      EXPECT_TRUE(same_bits<Scalar>(one.gradients(), many.gradients())) << threads;
      for (std::size_t i = 0; i < grid.size(); ++i) ASSERT_EQ(one.report()[i], many.report()[i]);
      const BasicGridMoments<Scalar> again(points_of(points), {field_of(u)}, grid, options);
      EXPECT_TRUE(
          std::equal(moments.values().begin(), moments.values().end(), again.values().begin()));
    }
  }
}

TYPED_TEST(Grid, InstructionSetsAgree) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 100 : D == 2 ? 30 : 12, 0.5, 3);
  const Matrix<Scalar> u = wave(points, 5);
  const auto grid = uneven_grid<Scalar, D>();
  for (const WeightForm form : {WeightForm::tensor_product, WeightForm::radial})
    for (int degree = 0; degree <= 2; ++degree) {
      Options options{.degree = degree, .form = form, .instruction_set = InstructionSet::generic};
      const auto generic = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
      for (const InstructionSet set : available_instruction_sets()) {
        options.instruction_set = set;
        const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
        for (std::size_t i = 0; i < grid.size(); ++i) {
          const FitReport& report = fit.report()[i];
          ASSERT_EQ(report.degree, generic.report()[i].degree) << name_of(set) << ", node " << i;
          ASSERT_EQ(report.neighbours, generic.report()[i].neighbours) << name_of(set);
          if (report.status == FitStatus::no_support) continue;
          for (int c = 0; c < 5; ++c)
            EXPECT_NEAR(fit.values()(i, c), generic.values()(i, c), allowed<Scalar>(report))
                << name_of(set) << ", degree " << degree << ", node " << i;
        }
      }
    }
}

TYPED_TEST(Grid, MomentsAreAdditive) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 300 : 600, 5);
  const Matrix<Scalar> u = wave(points, 3);
  const auto grid = uneven_grid<Scalar, D>();
  for (int degree = 0; degree <= 2; ++degree) {
    const Options options{.degree = degree};
    const GridApply with_gradients{.gradients = Derivative::diffuse};
    const auto whole =
        reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, with_gradients);
    const std::size_t half = points.size() / 3;
    const PointList<Scalar, D> first(points.begin(), points.begin() + half),
        second(points.begin() + half, points.end());
    const Matrix<Scalar> u1 = wave(first, 3), u2 = wave(second, 3);
    BasicGridMoments<Scalar> moments(points_of(first), {field_of(u1)}, grid, options);
    EXPECT_EQ(moments.values().size(), grid.size() * static_cast<std::size_t>(moments.per_node()));
    moments += BasicGridMoments<Scalar>(points_of(second), {field_of(u2)}, grid, options);
    const auto fit = moments.solve(with_gradients);
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const FitReport &report = fit.report()[i], &other = whole.report()[i];
      if (report.solver != other.solver || report.degree != other.degree) {
        EXPECT_NE(other.solver, Solver::moment_matrix) << "node " << i;
        EXPECT_LT(report.degree, degree) << "node " << i;
        continue;  // without particles a lower degree must do
      }
      EXPECT_EQ(report.neighbours, other.neighbours);
      if (report.status == FitStatus::no_support) continue;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(fit.values()(i, c), whole.values()(i, c), allowed<Scalar>(other)) << i;
      for (int c = 0; c < 3 * D; ++c)
        EXPECT_NEAR(fit.gradients()(i, c), whole.gradients()(i, c), 100 * allowed<Scalar>(other))
            << i;
    }
  }
}

// A constant is kept by whatever degree is left.
TYPED_TEST(Grid, SolvedMomentsKeepConstants) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    const std::vector<Scalar> ten(cloud.points.size(), Scalar(10));
    const auto grid = uneven_grid<Scalar, D>();
    const auto fit =
        BasicGridMoments<Scalar>(points_of(cloud.points), {field_of(ten)}, grid, {.degree = 2})
            .solve();
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const FitReport& report = fit.report()[i];
      if (report.neighbours == 0) {
        EXPECT_EQ(report.status, FitStatus::no_support);
      } else {
        EXPECT_NEAR(fit.values()(i, 0), 10, 10 * allowed<Scalar>(report))
            << cloud.name << ", node " << i << ", degree " << int(report.degree);
      }
    }
  }
}

TYPED_TEST(Grid, AllParticlesInOneCellOrOnBordersOrOutside) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) {
    grid.counts[d] = 6;
    grid.spacing[d] = Scalar(0.25);
  }
  const auto check = [&](const PointList<Scalar, D>& points, const std::string& name) {
    const Matrix<Scalar> u = wave(points, 2);
    for (const Weight weight :
         {Weight::linear_b_spline, Weight::quadratic_b_spline, Weight::cubic_b_spline}) {
      const Options options{.weight = weight};
      const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
      expect_equal(fit, points, u, grid,
                   equivalent(options, grid, (static_cast<int>(weight) + 2) / 2.0),
                   name + ", " + std::string(name_of(weight)));
    }
  };
  PointList<Scalar, D> crowd = random_points<Scalar, D>(5000, 4);
  for (auto& x : crowd)
    for (Scalar& c : x) c = Scalar(0.5) + Scalar(0.24) * c;
  check(crowd, "5000 in one cell");
  PointList<Scalar, D> coincident(40);
  for (auto& x : coincident) x.fill(Scalar(0.6));
  check(coincident, "coincident");
  PointList<Scalar, D> on_borders;
  for (const auto& x : random_points<Scalar, D>(200, 6)) {
    std::array<Scalar, D> y;
    for (int d = 0; d < D; ++d) y[d] = std::round(x[d] * Scalar(10)) / Scalar(8);
    on_borders.push_back(y);
  }
  check(on_borders, "on borders of cells");
  PointList<Scalar, D> outside = random_points<Scalar, D>(50, 6);
  for (auto& x : outside) x[0] += Scalar(100);
  outside[0].fill(Scalar(-1e30));
  for (int i = 1; i < 20; ++i) outside[i][0] -= Scalar(98.7);  // just beyond the last node
  const Matrix<Scalar> u = wave(outside, 1);
  const auto fit = reconstruct_on_grid(points_of(outside), {field_of(u)}, grid);
  EXPECT_GT(fit.report().no_support(), 0u);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_LE(fit.report()[i].neighbours, 19u);
  }
}

TEST(GridInput, BadInputIsNamed) {
  auto points = random_points<double, 2>(100, 1);
  std::vector<double> u(100, 1.0), weights(100, 1.0);
  std::vector<std::array<double, 2>> v(100, {1, 2});
  const StructuredGrid<double> grid{.dimension = 2, .spacing = {0.2, 0.2, 1}, .counts = {6, 6, 1}};
  const auto run = [&](Options options = {}) {
    options.particle_weights = weights;
    return message_of([&] {
      reconstruct_on_grid(points_of(points), {field_of(u), field_of(v)}, grid, options);
    });
  };
  EXPECT_THAT(run(), HasSubstr("no InvalidArgument"));
  v[70][1] = std::numeric_limits<double>::quiet_NaN();
  v[90][0] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(run(), HasSubstr("component 1 of field 1 at point 70"));
  v.assign(100, {1, 2});
  points[3][0] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(run(), HasSubstr("coordinate 0 of point 3"));
  points[3][0] = 0.5;
  for (const double bad : {-1.0, 0.0}) {
    weights[7] = bad;
    EXPECT_THAT(run(), HasSubstr("particle_weights of particle 7 = "));
  }
  weights[7] = 1;
  EXPECT_THAT(run({.degree = 5}), HasSubstr("degree = 5"));
  EXPECT_THAT(run({.weight = Weight::gaussian}), HasSubstr("no natural support"));
  EXPECT_THAT(run({.neighbours = Radius{-1}}), HasSubstr("radius = -1"));
  EXPECT_THAT(run({.neighbours = Radius{std::nan("")}}), HasSubstr("radius = "));
  EXPECT_THAT(run({.stretch = {0, 1, 1}}), HasSubstr("stretch along x = 0"));
  u.pop_back();
  EXPECT_THAT(run(), HasSubstr("size of the field"));
  u.push_back(1);
  weights.pop_back();
  EXPECT_THAT(run(), HasSubstr("number of particle_weights = 99"));
  weights.push_back(1);
  const auto points3 = random_points<double, 3>(100, 1);
  EXPECT_THAT(message_of([&] { reconstruct_on_grid(points_of(points3), {field_of(u)}, grid); }),
              HasSubstr("dimension of the points"));
  GridMoments moments(points_of(points), {field_of(u)}, grid);
  const GridMoments other(points_of(points), {field_of(u)}, cell_centres(grid));
  EXPECT_THAT(message_of([&] { moments += other; }), HasSubstr("grid of the moments"));
  EXPECT_THAT(message_of([&] { moments += GridMoments(points_of(points), {field_of(v)}, grid); }),
              HasSubstr("components of the moments"));
  EXPECT_THAT(message_of([&] {
                moments += GridMoments(points_of(points), {field_of(u)}, grid, {.degree = 0});
              }),
              HasSubstr("options of the moments"));
}

TEST(GridInput, NoFieldsNoParticlesAndAFillValue) {
  const PointList<double, 2> none;
  const auto grid = uneven_grid<double, 2>();
  const std::vector<double> u;
  const auto fit = reconstruct_on_grid(points_of(none), {field_of(u)}, grid, {.fill_value = -7});
  EXPECT_EQ(fit.report().no_support(), grid.size());
  EXPECT_TRUE((fit.values().array() == -7).all());
  const auto points = random_points<double, 2>(100, 1);
  const auto bare = reconstruct_on_grid(points_of(points), {}, grid);
  EXPECT_EQ(bare.values().cols(), 0);
  EXPECT_GT(bare.report().summary().full, 0u);
}

}  // namespace
}  // namespace recon::testing
