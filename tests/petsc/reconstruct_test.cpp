// Scattered targets: entries, values and reports are those of the serial reconstruction.
#include <map>

#include "petsc/petsc_support.hpp"
#include "recon/petsc/reconstruct.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

// The points of this rank, if they are dealt out in blocks of the serial order, so that global ids
// are the serial numbers: by their order (each rank has some of everywhere where points are random).
template <std::size_t D>
std::vector<std::size_t> block(const std::vector<std::array<double, D>>& points) {
  const auto size = static_cast<std::size_t>(world().size());
  return mine(points, world(),
              [&](std::size_t p) { return static_cast<int>(p * size / points.size()); });
}

template <int D>
void sort_along_x(Points<D>& points) {
  std::sort(points.begin(), points.end());
}

template <int D>
void expect_serial(const Points<D>& points, const Points<D>& targets, const Options& options,
                   const std::string& where, const std::vector<double>& weights = {},
                   bool per_target = false) {
  SCOPED_TRACE(where);
  Options serial = options;
  serial.particle_weights = weights;
  std::vector<double> radii, own_radii;
  for (std::size_t t = 0; t < targets.size(); ++t)
    radii.push_back(0.3 + 0.1 * std::sin(static_cast<double>(t)));
  if (per_target) serial.neighbours = Radii{radii};
  const recon::Reconstruction expected(view_of<D>(points), view_of<D>(targets), serial);

  const auto own_p = block(points), own_t = block(targets);
  const Points<D> own_points = chosen(points, own_p), own_targets = chosen(targets, own_t);
  std::vector<double> own_weights;
  for (const std::size_t p : own_p)
    if (!weights.empty()) own_weights.push_back(weights[p]);
  for (const std::size_t t : own_t) own_radii.push_back(radii[t]);
  Options parallel = options;
  parallel.particle_weights = own_weights;
  if (per_target) parallel.neighbours = Radii{own_radii};
  const petsc::Reconstruction fit(PETSC_COMM_WORLD, view_of<D>(own_points), view_of<D>(own_targets),
                                  parallel);

  const petsc::Operator values = fit.values();
  const petsc::Operator slopes = fit.gradient();
  const CsrOperator<double> expected_slopes = expected.gradient();
  ASSERT_EQ(values.rows(), own_t.size());
  for (std::size_t i = 0; i < own_t.size(); ++i) {
    const FitReport &a = fit.report()[i], &b = expected.report()[own_t[i]];
    EXPECT_EQ(a.neighbours, b.neighbours);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.degree, b.degree);
    EXPECT_EQ(a.kept, b.kept);
    EXPECT_EQ(a.gradient_rank, b.gradient_rank);
    const double scale = std::max(1.0, static_cast<double>(b.amplification)) /
                         std::max(1e-8, static_cast<double>(b.smallest_pivot));
    const auto compare = [&](const petsc::Operator& op, const CsrOperator<double>& serial_op,
                             double unit) {
      auto row = op.row(i);
      const auto serial_row = serial_op.row(own_t[i]);
      ASSERT_EQ(row.size(), serial_row.size());
      // Images of one particle may stand in any order: all sums over one id.
      for (int c = 0; c < op.blocks(); ++c) {
        std::map<std::int64_t, double> sums, serial_sums;
        for (const auto& entry : row)
          sums[entry.particle] += entry.values[static_cast<std::size_t>(c)];
        for (std::size_t e = 0; e < serial_row.size(); ++e)
          serial_sums[serial_row.particle(e)] += serial_row.value(e, c);
        ASSERT_EQ(sums.size(), serial_sums.size());
        for (const auto& [id, value] : serial_sums) {
          ASSERT_EQ(sums.count(id), 1u);
          ASSERT_NEAR(sums[id], value, 1e-12 * scale * unit) << "target " << own_t[i];
        }
      }
    };
    compare(values, expected.values(), 1);
    compare(slopes, expected_slopes,
            10 * std::max(1.0, static_cast<double>(b.gradient_amplification)));
  }

  // Values, and the transpose.
  const Matrix u = waves(points, 2), f = waves(targets, 2);
  const Matrix own_u = chosen(u, own_p), own_f = chosen(f, own_t);
  const Matrix made = values.apply(field_view(own_u));
  const Matrix back = values.apply_transpose(field_view(own_f));
  ASSERT_EQ(made.rows(), static_cast<Eigen::Index>(own_t.size()));
  ASSERT_EQ(back.rows(), static_cast<Eigen::Index>(own_p.size()));
  std::array<double, 2> products{
      (made.array() * own_f.array()).isFinite().select(made.array() * own_f.array(), 0).sum(),
      (back.array() * own_u.array()).sum()};
  MPI_Allreduce(MPI_IN_PLACE, products.data(), 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_NEAR(products[0], products[1], 1e-11 * static_cast<double>(targets.size() + 1));
  const Matrix serial_back = expected.apply_transpose(field_view(f));
  for (std::size_t i = 0; i < own_p.size(); ++i)
    for (int c = 0; c < 2; ++c)
      EXPECT_NEAR(back(static_cast<Eigen::Index>(i), c),
                  serial_back(static_cast<Eigen::Index>(own_p[i]), c), 1e-10);
}

template <class Dimension>
class ScatteredOnRanks : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                                    std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ScatteredOnRanks, Dimensions);

TYPED_TEST(ScatteredOnRanks, EqualsTheSerialOperators) {
  constexpr int D = TypeParam::value;
  const auto box = unit_grid<D>();
  const std::size_t count = D == 1 ? 120 : D == 2 ? 500 : 800;
  for (const bool sorted : {true, false}) {
    auto points = points_in<D>(box, count, 0, 11, 0), targets = points_in<D>(box, 90, 0.1, 12, 0);
    if (sorted) {
      sort_along_x<D>(points);
      sort_along_x<D>(targets);
    }
    expect_serial<D>(points, targets, {}, "nearest");
    expect_serial<D>(points, targets, {.degree = 2, .neighbours = Nearest{14, 1.3}}, "14 nearest");
    expect_serial<D>(points, targets, {.neighbours = Radius{0.25}}, "radius");
    expect_serial<D>(
        points, targets,
        {.form = WeightForm::tensor_product, .neighbours = Radius{0.2}, .stretch = {1.1, 1, 1.4}},
        "cube, stretched");
    expect_serial<D>(points, targets,
                     {.form = WeightForm::tensor_product, .neighbours = Nearest{11}},
                     "cube of the nearest");
    expect_serial<D>(points, targets, {.neighbours = NearestWithin{6, 0.3}}, "nearest within");
    expect_serial<D>(points, targets, {}, "radii", {}, true);
    std::vector<double> weights(points.size());
    for (std::size_t p = 0; p < weights.size(); ++p)
      weights[p] = 2 + std::cos(static_cast<double>(p));
    expect_serial<D>(points, targets, {.neighbours = Radius{0.25}}, "weights", weights);
    expect_serial<D>(points, targets,
                     {.degree = 2, .neighbours = Radius{0.1}, .grow = {.steps = 4}}, "growing");
    Options periodic{.neighbours = Radius{0.3}};
    for (int d = 0; d < D; ++d) {
      periodic.domain.periodic[d] = d != 1;
      periodic.domain.upper[d] = 1;
    }
    expect_serial<D>(points, targets, periodic, "periodic");
    periodic.neighbours = Nearest{9};
    expect_serial<D>(points, targets, periodic, "periodic nearest");
  }
}

TYPED_TEST(ScatteredOnRanks, FewParticlesFarAway) {
  constexpr int D = TypeParam::value;
  const auto box = unit_grid<D>();
  const auto targets = points_in<D>(box, 20, 0, 13, 0);
  auto points = points_in<D>(box, 5, 0, 14, 0);
  expect_serial<D>(points, targets, {.neighbours = Nearest{5}}, "five of five");
  expect_serial<D>(points, targets, {.neighbours = Nearest{8}}, "eight of five");
  for (auto& x : points) x[0] += 1000;
  expect_serial<D>(points, targets, {.degree = 0, .neighbours = Nearest{2}}, "far away");
  expect_serial<D>(points, targets, {.neighbours = Radius{0.5}}, "none in reach");
  expect_serial<D>(points, Points<D>{}, {.neighbours = Radius{0.5}}, "no targets");
}

TEST(Scattered, WhatNeedsMoreThanAHaloIsRefused) {
  const Points<2> points{{0, 0}, {1, 0}, {0, 1}};
  const auto make = [&](const Options& options) {
    return refusal([&] {
      petsc::Reconstruction(PETSC_COMM_WORLD, view_of<2>(points), view_of<2>(points), options);
    });
  };
  EXPECT_EQ(make({.neighbours = Radius{2}}), "");
  const std::vector<double> radii(3, 1.0);
  EXPECT_THAT(make({.neighbours = PairRadii{radii}}),
              HasSubstr("must be Radius, Radii, Nearest or NearestWithin"));
  EXPECT_THAT(make({.visible = [](std::size_t, std::size_t) { return true; }}),
              HasSubstr("visible = a function"));
  EXPECT_THAT(make({.max_distance = 2}), HasSubstr("max_distance = 2"));
  EXPECT_THAT(make({.unsupported = Unsupported::nearest}), HasSubstr("unsupported = nearest"));
  EXPECT_THAT(make({.neighbours = Radius{-1}}), HasSubstr("-1"));
  if (world().size() == 1) return;
  EXPECT_THAT(make({.degree = world().rank() == 1 ? 2 : 1, .neighbours = Radius{2}}),
              HasSubstr("different on some ranks"));
}

TEST(Scattered, BadDataOfOneRankIsToldByAll) {
  const int last = world().size() - 1;
  Points<2> points{{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  const std::string rank = "rank " + std::to_string(last) + ": ";
  const auto make = [&] {
    return petsc::Reconstruction(PETSC_COMM_WORLD, view_of<2>(points), view_of<2>(points),
                                 {.neighbours = Radius{2}});
  };
  const petsc::Operator op = make().values();
  Matrix u = Matrix::Ones(4, 1);
  if (world().rank() == last) u(2, 0) = std::nan("");
  EXPECT_THAT(refusal([&] { op.apply(field_view(u)); }),
              HasSubstr(rank + "component 0 of particle 2 = nan: must be finite"));
  EXPECT_THAT(refusal([&] { op.apply_transpose(field_view(u)); }), HasSubstr(rank));
  const Matrix shorter = Matrix::Ones(world().rank() == last ? 3 : 4, 1);
  EXPECT_THAT(refusal([&] { op.apply(field_view(shorter)); }),
              HasSubstr(rank + "values of the field = 3"));
  if (world().rank() == last) points[3][0] = std::nan("");
  EXPECT_THAT(refusal(make), HasSubstr(rank + "coordinate x of point 3"));
}

}  // namespace
}  // namespace recon::testing
