// What sums of moments cannot give goes by neighbour lists: with the same results where both can,
// and with every option honoured where only lists can.
#include <gmock/gmock.h>

#include <cstring>

#include "grid_support.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

// As numbers; NaN equals NaN.
template <class Scalar>
bool same(const Matrix<Scalar>& a, const Matrix<Scalar>& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    if (!(a.data()[i] == b.data()[i] || (std::isnan(a.data()[i]) && std::isnan(b.data()[i]))))
      return false;
  return true;
}

template <class Scalar>
void expect_same(const BasicGridReconstruction<Scalar>& a, const BasicGridReconstruction<Scalar>& b,
                 const std::string& where) {
  EXPECT_TRUE(same<Scalar>(a.values(), b.values())) << where;
  EXPECT_TRUE(same<Scalar>(a.gradients(), b.gradients())) << where;
  EXPECT_EQ(a.limited().components, b.limited().components) << where;
  ASSERT_EQ(a.size(), b.size()) << where;
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_EQ(a.report()[i], b.report()[i]) << where << ", node " << i;
}

// A grid is the same result as one call for all of its nodes, which this is.
template <class Scalar>
BasicGridReconstruction<Scalar> at_once(const PointsView<Scalar>& points, const Matrix<Scalar>& u,
                                        const StructuredGrid<Scalar>& grid, const Options& options,
                                        const GridApply& apply) {
  const BasicReconstruction<Scalar> fit(points, grid, options);
  LimitCount count;
  Matrix<Scalar> values = fit.apply(field_of(u), {.limit = apply.limit, .count = &count});
  if (apply.limit == Limit::none) count = {};
  return {std::move(values),
          apply.gradients ? fit.gradient(*apply.gradients).apply(field_of(u)) : Matrix<Scalar>(),
          fit.report(), count};
}

template <class C>
class GridByLists : public ::testing::Test {};
TYPED_TEST_SUITE(GridByLists, AllCases, CaseNames);

// A search method is a question to lists, and changes no result.
TYPED_TEST(GridByLists, GivesWhatMomentsGive) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 18 : 9, 0.5, 3);
  const Matrix<Scalar> u = wave(points, 2);
  std::vector<double> mass;
  for (std::size_t p = 0; p < points.size(); ++p) mass.push_back(3 + static_cast<double>(p % 5));
  const auto grid = uneven_grid<Scalar, D>();
  std::size_t compared = 0;
  for (const WeightForm form : {WeightForm::tensor_product, WeightForm::radial})
    for (int degree = 0; degree <= 2; ++degree)
      for (const bool natural : {true, false}) {
        Options options{.degree = degree, .form = form, .particle_weights = mass};
        if (!natural) {
          options.weight = Weight::wendland_c2;
          options.neighbours = Radius{0.7};
          options.stretch = {0.9, 1, 1.1};
        }
        const GridApply apply{.gradients = Derivative::diffuse};
        const auto sums =
            reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, apply);
        options.search = SearchMethod::kd_tree;
        const auto lists =
            reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, apply);
        ASSERT_EQ(sums.size(), lists.size());
        for (std::size_t i = 0; i < grid.size(); ++i) {
          const FitReport &a = sums.report()[i], &b = lists.report()[i];
          const std::string where = "degree " + std::to_string(degree) + ", node " +
                                    std::to_string(i) + (natural ? "" : ", radius");
          // A particle at the very border of a support may count in one and not in the other.
          if (a.neighbours != b.neighbours && (a.neighbours < 2 || b.neighbours < 2)) continue;
          EXPECT_NEAR(a.neighbours, b.neighbours, 2) << where;
          EXPECT_EQ(a.status, b.status) << where;
          EXPECT_EQ(a.degree, b.degree) << where;
          if (b.status == FitStatus::no_support) continue;
          EXPECT_EQ(a.gradient_rank, b.gradient_rank) << where;
          EXPECT_NEAR(a.amplification, b.amplification, 1e-2 * b.amplification) << where;
          compared += a.solver == b.solver;
          for (int c = 0; c < 2; ++c) {
            EXPECT_NEAR(sums.values()(i, c), lists.values()(i, c), allowed<Scalar>(b)) << where;
            for (int d = 0; d < D; ++d)
              EXPECT_NEAR(sums.gradients()(i, c * D + d), lists.gradients()(i, c * D + d),
                          100 * allowed<Scalar>(b))
                  << where;
          }
        }
      }
  EXPECT_GT(compared, 3 * grid.size());
}

TYPED_TEST(GridByLists, DegreesThreeAndFourReproduceTheirPolynomials) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 24 : 14, 0.5, 3);
  const auto grid = uneven_grid<Scalar, D>();
  for (int degree = 3; degree <= 4; ++degree) {
    const auto polynomial = [&](const auto& x, int derivative_along) {
      double s = 0.3;
      for (int d = 0; d < D; ++d) s += (0.8 - 0.3 * d) * static_cast<double>(x[d]);
      return derivative_along < 0
                 ? std::pow(s, degree)
                 : degree * std::pow(s, degree - 1) * (0.8 - 0.3 * derivative_along);
    };
    std::vector<Scalar> u;
    for (const auto& x : points) u.push_back(static_cast<Scalar>(polynomial(x, -1)));
    for (const Derivative kind : {Derivative::diffuse, Derivative::exact}) {
      const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid,
                                           {.degree = degree}, {.gradients = kind});
      std::size_t full = 0;
      for (std::size_t i = 0; i < grid.size(); ++i) {
        const FitReport& report = fit.report()[i];
        if (report.status != FitStatus::full) continue;
        ++full;
        std::array<double, D> x;
        for (int d = 0; d < D; ++d)
          x[d] = static_cast<double>(grid.coordinate(grid.index(i)[d], d));
        EXPECT_NEAR(fit.values()(i, 0), polynomial(x, -1), allowed<Scalar>(report)) << i;
        for (int d = 0; d < D; ++d)
          EXPECT_NEAR(fit.gradients()(i, d), polynomial(x, d), 1000 * allowed<Scalar>(report)) << i;
      }
      EXPECT_GT(full, grid.size() / 8) << "degree " << degree;
    }
  }
}

// The particles and their images, copied by hand, are what a periodic domain is.
TYPED_TEST(GridByLists, APeriodicDomainIsItsImages) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 40 : D == 2 ? 160 : 500, 5);
  const Matrix<Scalar> u = wave(points, 2);
  PointList<Scalar, D> copies;
  Matrix<Scalar> copied(points.size() * (D == 1 ? 3 : D == 2 ? 9 : 27), 2);
  for (int image = 0; image < (D == 1 ? 3 : D == 2 ? 9 : 27); ++image)
    for (std::size_t p = 0; p < points.size(); ++p) {
      auto x = points[p];
      for (int d = 0, rest = image; d < D; ++d, rest /= 3)
        x[d] += static_cast<Scalar>(rest % 3 - 1);
      copied.row(copies.size()) = u.row(p);
      copies.push_back(x);
    }
  PeriodicDomain<double> box;
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  const std::size_t cells = D == 3 ? 4 : 8;
  for (int d = 0; d < D; ++d) {
    box.periodic[d] = true;
    box.upper[d] = 1;
    grid.spacing[d] = 1 / static_cast<Scalar>(cells);
    grid.counts[d] = cells + 1;
  }
  for (const WeightForm form : {WeightForm::tensor_product, WeightForm::radial})
    for (int degree = 0; degree <= 2; ++degree) {
      const GridApply apply{.gradients = Derivative::diffuse};
      const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid,
                                           {.degree = degree, .form = form, .domain = box}, apply);
      const auto expected = reconstruct_on_grid(points_of(copies), {field_of(copied)}, grid,
                                                {.degree = degree, .form = form}, apply);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        const FitReport& report = fit.report()[i];
        EXPECT_EQ(report.status, expected.report()[i].status);
        for (int c = 0; c < 2; ++c) {
          EXPECT_NEAR(fit.values()(i, c), expected.values()(i, c), allowed<Scalar>(report)) << i;
          for (int d = 0; d < D; ++d)
            EXPECT_NEAR(fit.gradients()(i, c * D + d), expected.gradients()(i, c * D + d),
                        300 * allowed<Scalar>(report))
                << i;
        }
        // A node on the upper border is the one on the lower.
        std::size_t image = i;
        const auto index = grid.index(i);
        for (int d = 0, stride = 1; d < D; ++d, stride *= static_cast<int>(cells) + 1)
          if (index[d] == cells) image -= cells * static_cast<std::size_t>(stride);
        EXPECT_EQ(fit.report()[image], report);
        EXPECT_EQ(fit.values().row(image), fit.values().row(i));
        EXPECT_EQ(fit.gradients().row(image), fit.gradients().row(i));
      }
    }
}

// Where the nodes move, values change as exact gradients say.
TYPED_TEST(GridByLists, ExactGradientsAreThoseOfTheValues) {
  using Scalar = typename TypeParam::Scalar;
  if constexpr (sizeof(Scalar) == 8) {
    constexpr int D = TypeParam::D;
    const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 18 : 9, 0.5, 3);
    const Matrix<Scalar> u = wave(points, 2);
    const auto grid = uneven_grid<Scalar, D>();
    for (const bool natural : {true, false})
      for (int degree = 0; degree <= 2; ++degree) {
        Options options{.degree = degree, .weight = Weight::quartic_b_spline};
        if (!natural) {
          options.form = WeightForm::radial;
          options.neighbours = Radius{0.6};
          options.stretch = {1, 1.2, 1.4};
        }
        const auto at = [&](const StructuredGrid<Scalar>& nodes, const GridApply& apply) {
          return reconstruct_on_grid(points_of(points), {field_of(u)}, nodes, options, apply);
        };
        const auto fit = at(grid, {.gradients = Derivative::exact});
        for (int d = 0; d < D; ++d) {
          const double step = 1e-5;
          auto before = grid, after = grid;
          before.origin[d] -= step;
          after.origin[d] += step;
          const auto a = at(before, {}), b = at(after, {});
          std::size_t compared = 0;
          for (std::size_t i = 0; i < grid.size(); ++i) {
            const FitReport& report = fit.report()[i];
            if (report.status != FitStatus::full || report.amplification > 5 ||
                report.neighbours < 8 * D ||  // few particles at the border bend the field much
                report.gradient_rank < (degree > 0 ? D : 0) ||
                a.report()[i].solver != b.report()[i].solver)
              continue;
            ++compared;
            for (int c = 0; c < 2; ++c)
              EXPECT_NEAR(fit.gradients()(i, c * D + d),
                          (b.values()(i, c) - a.values()(i, c)) / (2 * step), 1e-5)
                  << "degree " << degree << ", node " << i << ", amplification "
                  << report.amplification;
          }
          EXPECT_GT(compared, grid.size() / 20);
        }
      }
  }
}

// The operator of a grid: its values are those of reconstruct_on_grid(), and its transposes are the
// adjoints of values and gradients.
TYPED_TEST(GridByLists, OperatorsOfAGridAndTheirTransposes) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 250 : 500, 5);
  const Matrix<Scalar> u = wave(points, 2);
  auto grid = uneven_grid<Scalar, D>();
  for (int d = 1; d < D; ++d) grid.spacing[d] = grid.spacing[0];
  const BasicSources<Scalar> sources(points_of(points));
  for (int degree = 0; degree <= 4; ++degree) {
    const Options options{.degree = degree, .fill_value = 0};
    const auto fit = reconstruct(sources, grid, options);
    const auto on_grid = reconstruct_on_grid(sources, {field_of(u)}, grid, options);
    const Matrix<Scalar> values = fit.apply(field_of(u));
    for (std::size_t i = 0; i < grid.size(); ++i)
      for (int c = 0; c < 2; ++c)
        EXPECT_NEAR(values(i, c), on_grid.values()(i, c), allowed<Scalar>(fit.report()[i])) << i;
    const auto expect_adjoint = [&](const CsrOperator<Scalar>& op, const char* what) {
      const Matrix<Scalar> out = op.apply(field_of(u));
      Matrix<Scalar> force(out.rows(), out.cols());
      for (Eigen::Index i = 0; i < force.size(); ++i)
        force.data()[i] = static_cast<Scalar>(std::cos(0.7 * static_cast<double>(i)));
      const Matrix<Scalar> back = op.apply_transpose(field_of(force));
      const auto product = [](const Matrix<Scalar>& a, const Matrix<Scalar>& b) {
        return a.template cast<double>().cwiseProduct(b.template cast<double>());
      };
      const double scale = product(out, force).cwiseAbs().sum() + product(u, back).cwiseAbs().sum();
      EXPECT_NEAR(product(out, force).sum(), product(u, back).sum(), 20 * TypeParam::eps * scale)
          << what << ", degree " << degree;
    };
    expect_adjoint(fit.values(), "values");
    expect_adjoint(fit.gradient(Derivative::exact), "exact gradients");
    expect_adjoint(fit.gradient(Derivative::diffuse), "diffuse gradients");
  }
}

// Several thousand nodes, so that they are treated in parts.
TYPED_TEST(GridByLists, EveryOptionIsHonouredInEveryPart) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 150 : 300, 5);
  const Matrix<Scalar> u = wave(points, 2);
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) {
    grid.counts[d] = D == 1 ? 9000 : D == 2 ? 72 : 17;
    grid.origin[d] = Scalar(-0.3);
    grid.spacing[d] = Scalar(1.6) / static_cast<Scalar>(grid.counts[d]);
  }
  const double radius = D == 1 ? 0.05 : D == 2 ? 0.15 : 0.25;
  std::vector<double> radii;
  for (std::size_t i = 0; i < grid.size(); ++i)
    radii.push_back(radius * (1 + 0.3 * static_cast<double>(i % 7)));
  std::vector<double> mass;
  for (std::size_t p = 0; p < points.size(); ++p) mass.push_back(1 + static_cast<double>(p % 5));
  const Options base{.neighbours = Radius{radius}, .search = SearchMethod::cell_grid};
  const auto compare = [&](const char* what, const auto& change, const GridApply& apply = {}) {
    Options options = base;
    change(options);
    const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, apply);
    expect_same(fit, at_once<Scalar>(points_of(points), u, grid, options, apply), what);
    options.threads = 3;
    expect_same(fit, reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options, apply),
                what);
    return fit;
  };
  const auto plain = compare("plain", [](Options&) {});
  EXPECT_GT(plain.report().no_support(), 0u);
  const auto differs = [&](const BasicGridReconstruction<Scalar>& fit) {
    return !same<Scalar>(fit.values(), plain.values());
  };
  EXPECT_TRUE(differs(compare("Radii", [&](Options& o) { o.neighbours = Radii{radii}; })));
  EXPECT_TRUE(differs(compare("Nearest", [&](Options& o) { o.neighbours = Nearest{9}; })));
  EXPECT_TRUE(differs(compare("NearestWithin", [&](Options& o) {
    o.neighbours = NearestWithin{5, radius};
  })));
  EXPECT_TRUE(differs(compare("visible", [](Options& o) {
    o.visible = [](std::size_t t, std::size_t p) { return (t / 1000 + p) % 3 != 0; };
  })));
  const auto grown = compare("grow", [](Options& o) { o.grow = {3, 1.5}; });
  EXPECT_GT(grown.report().summary().full, plain.report().summary().full);
  const auto far = compare("max_distance", [](Options& o) { o.max_distance = 0.5; });
  EXPECT_GT(far.report().too_far(), 0u);
  const auto nearest = compare("nearest", [](Options& o) { o.unsupported = Unsupported::nearest; });
  EXPECT_EQ(nearest.report().no_support(), 0u);
  EXPECT_TRUE(differs(compare("fill_value", [](Options& o) { o.fill_value = 7; })));
  EXPECT_TRUE(differs(compare("stretch", [](Options& o) { o.stretch = {1.2, 0.9, 1}; })));
  EXPECT_TRUE(differs(compare("weights", [&](Options& o) { o.particle_weights = mass; })));
  EXPECT_TRUE(differs(compare("degree 3", [](Options& o) { o.degree = 3; })));
  EXPECT_EQ(differs(compare("form", [](Options& o) { o.form = WeightForm::radial; })), D > 1);
  EXPECT_TRUE(differs(compare("leverage", [](Options& o) { o.tolerances.leverage = 1.5; })));
  for (const Solver solver : {Solver::gram_schmidt, Solver::qr, Solver::svd}) {
    const auto fit = compare("solver", [&](Options& o) { o.solver = solver; });
    std::size_t solved = 0;
    for (std::size_t i = 0; i < grid.size(); ++i) solved += fit.report()[i].solver == solver;
    EXPECT_GT(solved, grid.size() / 10);
  }
  const auto limited = compare("limit", [](Options& o) { o.degree = 2; }, {.limit = Limit::range});
  EXPECT_GT(limited.limited().values, 0u);
  compare("exact gradients", [](Options&) {},
          {.gradients = Derivative::exact, .limit = Limit::relaxed});
}

// From Sources the same numbers as from points, by either way.
TYPED_TEST(GridByLists, SourcesGiveTheSameBitsAsPoints) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 250 : 500, 5);
  const Matrix<Scalar> u = wave(points, 2);
  const auto grid = uneven_grid<Scalar, D>();
  std::vector<double> mass;
  for (std::size_t p = 0; p < points.size(); ++p) mass.push_back(1 + static_cast<double>(p % 5));
  const BasicSources<Scalar> sources(points_of(points), {.particle_weights = mass});
  const GridApply apply{.gradients = Derivative::diffuse};
  for (const int degree : {0, 2, 3}) {
    const auto fit = reconstruct_on_grid(sources, {field_of(u)}, grid, {.degree = degree}, apply);
    expect_same(fit,
                reconstruct_on_grid(points_of(points), {field_of(u)}, grid,
                                    {.degree = degree, .particle_weights = mass}, apply),
                "degree " + std::to_string(degree));
  }
  PeriodicDomain<double> box;
  box.periodic[0] = true;
  box.upper[0] = 1;
  const BasicSources<Scalar> periodic(points_of(points), {.domain = box, .stretch = {2, 1, 0.5}});
  const Options options{.neighbours = Radius{0.2}};
  Options said = options;
  said.domain = box;
  said.stretch = {2, 1, 0.5};
  expect_same(reconstruct_on_grid(periodic, {field_of(u)}, grid, options, apply),
              reconstruct_on_grid(points_of(points), {field_of(u)}, grid, said, apply), "periodic");
  EXPECT_THAT(message_of([&] { reconstruct_on_grid(periodic, {field_of(u)}, grid, said); }),
              HasSubstr("belongs to the Sources"));
}

// Moments name what they cannot give, and never leave it out.
TEST(GridMomentsRefuse, WhatGoesByLists) {
  const auto points = random_points<double, 2>(100, 1);
  const std::vector<double> u(100, 1.0), radii(36, 0.5);
  const StructuredGrid<double> grid{.dimension = 2, .spacing = {0.2, 0.2, 1}, .counts = {6, 6, 1}};
  const auto run = [&](const Options& options) {
    // What moments refuse works by lists.
    EXPECT_EQ(reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options).size(), 36u);
    return message_of([&] { GridMoments(points_of(points), {field_of(u)}, grid, options); });
  };
  EXPECT_THAT(run({}), HasSubstr("no InvalidArgument"));
  EXPECT_THAT(run({.degree = 3}), HasSubstr("degree = 3: must be 0, 1 or 2 for sums of moments"));
  EXPECT_THAT(run({.domain = {{0, 0, 0}, {1, 1, 1}, {true, false, false}}}),
              HasSubstr("domain = periodic"));
  EXPECT_THAT(run({.visible = [](std::size_t, std::size_t) { return true; }}),
              HasSubstr("visible"));
  EXPECT_THAT(run({.grow = {2, 1.5}}), HasSubstr("grow.steps = 2"));
  EXPECT_THAT(run({.max_distance = 3}), HasSubstr("max_distance = 3"));
  EXPECT_THAT(run({.unsupported = Unsupported::nearest}), HasSubstr("unsupported = nearest"));
  EXPECT_THAT(run({.search = SearchMethod::kd_tree}), HasSubstr("search"));
  EXPECT_THAT(run({.solver = Solver::gram_schmidt}), HasSubstr("solver = gram_schmidt"));
  EXPECT_THAT(run({.neighbours = Nearest{7}}), HasSubstr("neighbours"));
  EXPECT_THAT(run({.neighbours = Radii{radii}}), HasSubstr("neighbours"));
  EXPECT_THAT(run({.weight = Weight::gaussian, .neighbours = Nearest{7}}), HasSubstr("neighbours"));
  EXPECT_THAT(run({.neighbours = Radius{1.7}}), HasSubstr("at most 8"));
  EXPECT_THAT(run({.solver = Solver::moment_matrix}), HasSubstr("no InvalidArgument"));
  const GridMoments moments(points_of(points), {field_of(u)}, grid);
  EXPECT_THAT(message_of([&] { moments.solve({.gradients = Derivative::exact}); }),
              HasSubstr("gradients = exact"));
  const std::vector<float> narrow(100, 1.0f);
  const auto narrow_points = random_points<float, 2>(100, 1);
  std::vector<double> tiny(100, 1e-60);
  EXPECT_THAT(message_of([&] {
                GridMomentsF(points_of(narrow_points), {field_of(narrow)},
                             {.dimension = 2, .spacing = {0.2f, 0.2f, 1}, .counts = {6, 6, 1}},
                             {.particle_weights = tiny});
              }),
              HasSubstr("range of the precision"));
}

TEST(GridByListsInput, MessagesNameFieldAndNode) {
  const auto points = regular_points<double, 1>(100);
  const StructuredGrid<double> grid{
      .dimension = 1, .spacing = {1.01 / 5000, 1, 1}, .counts = {5000, 1, 1}};
  const std::vector<double> one(100, 1.0);
  std::vector<double> huge(100, 1.0);
  huge[98] = -1e308;
  huge[99] = 1.7e308;
  EXPECT_THAT(message_of([&] {
                reconstruct_on_grid(points_of(points), {field_of(one), field_of(huge)}, grid,
                                    {.neighbours = Radius{0.03}, .solver = Solver::qr});
              }),
              HasSubstr("(field 1, target 0 is node 4096 of the grid)"));
  std::vector<double> radii(5000, 0.1);
  radii[4500] = -1;
  EXPECT_THAT(message_of([&] {
                reconstruct_on_grid(points_of(points), {field_of(one)}, grid,
                                    {.neighbours = Radii{radii}});
              }),
              HasSubstr("radius of target 4500"));
  huge[42] = std::nan("");
  EXPECT_THAT(message_of([&] {
                reconstruct_on_grid(points_of(points), {field_of(one), field_of(huge)}, grid,
                                    {.degree = 3});
              }),
              HasSubstr("component 0 of field 1 at point 42"));
}

TEST(GridReconstruction, IsEmptyByDefault) {
  const GridReconstruction none;
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(none.values().size(), 0);
  EXPECT_EQ(none.gradients().size(), 0);
  EXPECT_EQ(none.report().size(), 0u);
  EXPECT_EQ(none.report().summary().targets, 0u);
  EXPECT_TRUE(none.limited().components.empty());
}

TEST(OptionsOfGrids, AreSaidByForGrid) {
  StructuredGrid<double> grid;
  grid.dimension = 3;
  grid.spacing = {0.1, 0.1, 0.1};
  const Options even = Options{.degree = 2, .weight = Weight::quadratic_b_spline}.for_grid(grid);
  EXPECT_EQ(even.form, WeightForm::tensor_product);
  EXPECT_EQ(even.solver, Solver::moment_matrix);
  EXPECT_DOUBLE_EQ(std::get<Radius>(*even.neighbours).radius, 0.15);
  EXPECT_EQ(even.stretch, (std::array<double, 3>{1, 1, 1}));
  EXPECT_EQ(Options{.degree = 3}.for_grid(grid).solver, Solver::gram_schmidt);
  grid.spacing = {0.1, 0.2, 0.05};
  const Options uneven = Options{.stretch = {1, 1, 3}}.for_grid(grid);
  EXPECT_DOUBLE_EQ(std::get<Radius>(*uneven.neighbours).radius, 0.2);
  EXPECT_EQ(uneven.stretch, (std::array<double, 3>{1, 2, 1.5}));
  const Options points = Options{.degree = 2}.for_points(3);
  EXPECT_EQ(points.form, WeightForm::radial);
  EXPECT_EQ(points.solver, Solver::gram_schmidt);
  EXPECT_EQ(std::get<Nearest>(*points.neighbours).k, 21u);
}

}  // namespace
}  // namespace recon::testing
