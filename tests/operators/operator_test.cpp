// The operator as a linear map: adjoint, sparse matrix, components, threads, fill, bad input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/operators/sparse.hpp"
#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/invariants.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

template <class C>
class Operator : public ::testing::Test {};
TYPED_TEST_SUITE(Operator, AllCases, CaseNames);

template <class Scalar>
Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> random_matrix(std::size_t rows, int columns,
                                                                    int seed) {
  RandomNumbers random(seed);
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i)
    m.data()[i] = static_cast<Scalar>(random.uniform(-1, 1));
  return m;
}

TYPED_TEST(Operator, TransposeIsAdjointAndEqualsTheSparseMatrix) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& cloud : hostile_clouds<Scalar, D>()) {
    if (cloud.points.empty()) continue;
    const auto targets = random_points<Scalar, D>(50, 7);
    PeriodicDomain<double> domain;
    domain.upper = {1.5, 1.5, 1.5};
    domain.periodic[0] = true;
    const BasicReconstruction<Scalar> fit(points_of(cloud.points), points_of(targets),
                                          {.neighbours = Radius{0.3}, .domain = domain});
    for (const auto& op : {fit.values(), fit.gradient(), fit.hessian()})
      for (const int components : {1, 2, 3, 4, 5, 6, 9}) {
        const auto u = random_matrix<Scalar>(cloud.points.size(), components, 1);
        const auto f = random_matrix<Scalar>(targets.size(), components * op.blocks(), 2);
        auto au = op.apply(field_of(u));
        for (const auto t : op.empty_rows()) au.row(t).setZero();
        const auto atf = op.apply_transpose(field_of(f));
        const double left =
            (au.template cast<double>().array() * f.template cast<double>().array()).sum();
        const double right =
            (u.template cast<double>().array() * atf.template cast<double>().array()).sum();
        const double scale =
            au.template cast<double>().norm() * f.template cast<double>().norm() + 1e-30;
        EXPECT_NEAR(left / scale, right / scale, 200 * TypeParam::eps) << cloud.name;

        const auto sparse = to_sparse(op);
        for (int c = 0; c < components; ++c) {
          using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
          const Column column = sparse * u.col(c);
          // Two orders of summation differ by rounding of the terms, which may cancel.
          const Column terms = sparse.cwiseAbs() * u.col(c).cwiseAbs();
          for (std::size_t t = 0; t < targets.size(); ++t)
            for (int b = 0; b < op.blocks(); ++b)
              EXPECT_NEAR(column[t * op.blocks() + b], au(t, c * op.blocks() + b),
                          20 * TypeParam::eps * terms[t * op.blocks() + b])
                  << cloud.name << ", block " << b;
        }
      }
  }
}

TYPED_TEST(Operator, SameBitsForAnyNumberOfThreads) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(3000, 1),
             targets = random_points<Scalar, D>(2500, 2);
  const auto u = random_matrix<Scalar>(points.size(), 3, 1),
             f = random_matrix<Scalar>(targets.size(), 3, 2);
  Options options{.degree = 1, .neighbours = Nearest{10}, .threads = 1};
  const BasicReconstruction<Scalar> one(points_of(points), points_of(targets), options);
  const auto v = one.apply(field_of(u));
  const auto g = one.gradient().apply(field_of(u));
  const auto t = one.apply_transpose(field_of(f));
  for (const int threads : {2, 3, 8}) {
    options.threads = threads;
    const BasicReconstruction<Scalar> many(points_of(points), points_of(targets), options);
    EXPECT_EQ(numbers_of(one.values()), numbers_of(many.values()));
    EXPECT_TRUE(std::equal(one.report().all().begin(), one.report().all().end(),
                           many.report().all().begin()));
    EXPECT_EQ(v, many.apply(field_of(u)));
    EXPECT_EQ(g, many.gradient().apply(field_of(u)));
    EXPECT_EQ(t, many.apply_transpose(field_of(f)));
  }
}

TEST(Reconstruct, ViewsOfAnyLayoutGiveTheSameBits) {
  struct Grain {
    int id;
    std::array<double, 3> position;
    float unused;
    Eigen::Vector3d velocity;
  };
  const auto points = random_points<double, 3>(500, 1), targets = random_points<double, 3>(40, 2);
  std::vector<Grain> grains;
  std::vector<double> x, y, z, flat;
  Eigen::MatrixXd matrix(500, 3), velocity(500, 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d v(points[i][0] + points[i][1], std::sin(points[i][2]), double(i % 7));
    grains.push_back({int(i), points[i], 0, v});
    x.push_back(points[i][0]);
    y.push_back(points[i][1]);
    z.push_back(points[i][2]);
    flat.insert(flat.end(), points[i].begin(), points[i].end());
    matrix.row(i) << points[i][0], points[i][1], points[i][2];
    velocity.row(i) = v;
  }
  const Options options{.degree = 1, .neighbours = Radius{0.3}};
  const auto apply = [&](const auto& view) {
    return reconstruct(view, points_of(targets), options).apply(field_of(velocity));
  };
  const Eigen::MatrixXd expected = apply(points_of(points));
  EXPECT_EQ(expected, apply(points_of(grains, &Grain::position)));
  EXPECT_EQ(expected, apply(points_of(x, y, z)));
  EXPECT_EQ(expected, apply(points_of(matrix)));
  EXPECT_EQ(expected, apply(points_of_flat(flat, 3)));
  const auto fit = reconstruct(points_of(points), points_of(targets), options);
  EXPECT_EQ(expected, fit.apply(field_of(grains, &Grain::velocity)));
  std::vector<std::array<double, 3>> out(targets.size());
  fit.apply(field_of(std::as_const(grains), &Grain::velocity), field_of(out));
  for (std::size_t t = 0; t < out.size(); ++t)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(out[t][c], expected(t, c));
}

TEST(Reconstruct, OwnsWhatItNeeds) {
  auto points = random_points<double, 2>(300, 1);
  auto targets = random_points<double, 2>(20, 2);
  const auto fit = reconstruct(points_of(points), points_of(targets), {.neighbours = Radius{0.2}});
  const auto before = fit.gradient();
  points.assign(points.size(), {7, 7});
  targets.clear();
  targets.shrink_to_fit();
  const auto op = fit.gradient();
  EXPECT_EQ(numbers_of(before), numbers_of(op));
}

TEST(Reconstruct, NoSupportIsFilledOrNearest) {
  const PointList<double, 2> points{{0, 0}, {0.1, 0}, {0, 0.1}, {0.1, 0.1}};
  const PointList<double, 2> targets{{0.05, 0.05}, {3, 0.1}};
  const std::vector<double> u{1, 2, 3, 4};
  Options options{.degree = 1, .neighbours = Radius{0.2}};
  auto fit = reconstruct(points_of(points), points_of(targets), options);
  EXPECT_EQ(fit.report()[1].status, FitStatus::no_support);
  EXPECT_EQ(fit.report().with_status(FitStatus::no_support), std::vector<std::size_t>{1});
  EXPECT_NEAR(fit.apply(field_of(u))(0, 0), 2.5, 1e-14);
  EXPECT_TRUE(std::isnan(fit.apply(field_of(u))(1, 0)));
  EXPECT_TRUE(std::isnan(fit.gradient().apply(field_of(u))(1, 1)));
  options.fill_value = 0;
  EXPECT_EQ(reconstruct(points_of(points), points_of(targets), options).apply(field_of(u))(1, 0),
            0);
  options.unsupported = Unsupported::nearest;
  fit = reconstruct(points_of(points), points_of(targets), options);
  EXPECT_EQ(fit.report()[1].status, FitStatus::nearest);
  EXPECT_EQ(fit.apply(field_of(u))(1, 0), 4);
  EXPECT_NEAR(fit.apply(field_of(u))(0, 0), 2.5, 1e-14);
  EXPECT_EQ(fit.gradient().apply(field_of(u))(1, 0), 0);
  options.visible = [](std::size_t target, std::size_t particle) {
    return !(target == 1 && particle == 3);
  };
  EXPECT_EQ(reconstruct(points_of(points), points_of(targets), options).apply(field_of(u))(1, 0),
            2);
}

TEST(Reconstruct, SupportsGrowUntilTheDegreeIsReached) {
  const auto points = random_points<double, 2>(400, 1), targets = random_points<double, 2>(100, 2);
  for (const NeighbourRule& rule : {NeighbourRule(Radius{0.03}), NeighbourRule(Nearest{3}),
                                    NeighbourRule(NearestWithin{4, 0.05})}) {
    Options options{.degree = 2, .neighbours = rule};
    const auto small = reconstruct(points_of(points), points_of(targets), options);
    EXPECT_LT(small.report().summary().full, 100u);
    options.grow = {.steps = 20, .factor = 1.2};
    const auto grown = reconstruct(points_of(points), points_of(targets), options);
    EXPECT_EQ(grown.report().summary().full, 100u);
    for (std::size_t t = 0; t < 100; ++t)  // targets that were full keep their support
      if (small.report()[t].status == FitStatus::full) {
        EXPECT_EQ(small.neighbours().support[t], grown.neighbours().support[t]);
        EXPECT_EQ(small.report()[t], grown.report()[t]);
      }
  }
  // Hopeless: on a line the degree is never reached, and the first support stays.
  const auto line = diagonal_points<double, 2>(200, 3);
  Options options{.degree = 1, .neighbours = Radius{0.2}};
  const auto first = reconstruct(points_of(line), points_of(targets), options);
  options.grow.steps = 5;
  const auto last = reconstruct(points_of(line), points_of(targets), options);
  EXPECT_EQ(numbers_of(first.values()), numbers_of(last.values()));
}

TEST(Reconstruct, MaskKeepsTwoBodiesApart) {
  const auto points = random_points<double, 2>(600, 1), targets = random_points<double, 2>(100, 2);
  std::vector<double> u;  // a jump at x = 1/2
  for (const auto& x : points) u.push_back(x[0] < 0.5 ? x[1] : 10 + x[0]);
  for (const NeighbourRule& rule : {NeighbourRule(Radius{0.2}), NeighbourRule(Nearest{12})}) {
    const auto fit =
        reconstruct(points_of(points), points_of(targets),
                    {.degree = 1, .neighbours = rule, .visible = [&](std::size_t t, std::size_t p) {
                       return (targets[t][0] < 0.5) == (points[p][0] < 0.5);
                     }});
    const auto v = fit.apply(field_of(u));
    for (std::size_t t = 0; t < targets.size(); ++t)
      EXPECT_NEAR(v(t, 0), targets[t][0] < 0.5 ? targets[t][1] : 10 + targets[t][0], 1e-11);
  }
}

TEST(Reconstruct, PeriodicDomainSeesImages) {
  const auto points = jittered_points<double, 2>(20, 0.3, 1);
  PointList<double, 2> targets = random_points<double, 2>(100, 2);
  targets.push_back({0, 0});
  targets.push_back({1, 1});
  targets.push_back({-0.3, 2.6});
  PeriodicDomain<double> domain{{0, 0}, {1, 1}, {true, true}};
  const double pi = std::acos(-1.0);
  std::vector<double> u;
  for (const auto& x : points) u.push_back(std::sin(2 * pi * x[0]) * std::cos(2 * pi * x[1]));
  const auto fit = reconstruct(points_of(points), points_of(targets),
                               {.degree = 2, .neighbours = Radius{0.15}, .domain = domain});
  const auto v = fit.apply(field_of(u));
  EXPECT_EQ(fit.report().summary().full, targets.size());
  for (std::size_t t = 0; t < targets.size(); ++t)
    EXPECT_NEAR(v(t, 0), std::sin(2 * pi * targets[t][0]) * std::cos(2 * pi * targets[t][1]), 0.03);
  EXPECT_NEAR(v(100, 0), v(101, 0), 1e-12);  // the corners are one point
}

// With as many points, they are sorted in space unless the list is given: that must not show.
TEST(Reconstruct, OwnNeighbourList) {
  const auto points = random_points<double, 2>(2000, 1), targets = random_points<double, 2>(900, 2);
  const Options options{.degree = 1, .neighbours = Radius{0.2}};
  const auto expected = reconstruct(points_of(points), points_of(targets), options);
  NeighbourList<double> list = expected.neighbours();
  const auto fit = reconstruct(points_of(points), points_of(targets), list, options);
  // Up to rounding: targets in another order share vector registers with others.
  const auto differ = [](const auto& a, const auto& b) {
    double worst = a.size() == b.size() ? 0 : 1, largest = 0;
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
      worst = std::max<double>(worst, std::abs(a[i] - b[i]));
      largest = std::max<double>(largest, std::abs(b[i]));
    }
    return worst / largest;
  };
  EXPECT_LT(differ(numbers_of(fit.values()), numbers_of(expected.values())), 1e-13);
  EXPECT_LT(differ(numbers_of(fit.gradient()), numbers_of(expected.gradient())), 1e-12);
  std::vector<double> u, f;
  for (const auto& x : points) u.push_back(std::sin(9 * x[0]) + x[1]);
  for (const auto& x : targets) f.push_back(x[0] * x[1]);
  EXPECT_LT((fit.apply(field_of(u)) - expected.apply(field_of(u))).norm(),
            1e-13 * fit.apply(field_of(u)).norm());
  EXPECT_LT((fit.apply_transpose(field_of(f)) - expected.apply_transpose(field_of(f))).norm(),
            1e-13 * fit.apply_transpose(field_of(f)).norm());
  for (std::size_t t = 0; t < targets.size(); ++t) {
    EXPECT_EQ(fit.report()[t].status, expected.report()[t].status);
    EXPECT_EQ(fit.report()[t].neighbours, expected.report()[t].neighbours);
    EXPECT_EQ(fit.support(t), expected.support(t));
    const auto row = expected.values().row(t);
    ASSERT_EQ(row.size(), list.of(t).size());
    for (std::size_t i = 0; i < row.size(); ++i) EXPECT_EQ(row.particle(i), list.of(t)[i]);
  }
  // Options have a default here too: degree 1.
  EXPECT_EQ(numbers_of(reconstruct(points_of(points), points_of(targets), list).values()),
            numbers_of(reconstruct(points_of(points), points_of(targets), list, {}).values()));
  list.shifts.assign(list.indices.size(), {});
  EXPECT_EQ(numbers_of(reconstruct(points_of(points), points_of(targets), list, options).values()),
            numbers_of(fit.values()));
  list.shifts[7] = {0, 1, 0};
  EXPECT_THAT(
      message_of([&] { reconstruct(points_of(points), points_of(targets), list, options); }),
      HasSubstr("shift of entry 7 along y = 1: must be 0 where the domain is not periodic"));
  list.shifts.clear();
  list.indices[5] = 2000;
  EXPECT_THAT(
      message_of([&] { reconstruct(points_of(points), points_of(targets), list, options); }),
      HasSubstr("2000"));
  list.indices[5] = 3;
  list.support[4] = -1;
  EXPECT_THAT(
      message_of([&] { reconstruct(points_of(points), points_of(targets), list, options); }),
      HasSubstr("-1"));
}

TEST(Reconstruct, BadInputIsNamed) {
  auto points = random_points<double, 2>(50, 1);
  auto targets = random_points<double, 2>(5, 2);
  const auto error = [&](const Options& options) {
    return message_of([&] { reconstruct(points_of(points), points_of(targets), options); });
  };
  EXPECT_THAT(error({.degree = 5}), HasSubstr("degree = 5: must be 0 to 4"));
  EXPECT_THAT(error({.degree = -1}), HasSubstr("degree = -1"));
  EXPECT_THAT(error({.neighbours = Radius{-0.5}}), HasSubstr("-0.5"));
  EXPECT_THAT(error({.neighbours = Radius{std::nan("")}}), HasSubstr("nan"));
  EXPECT_THAT(error({.neighbours = Nearest{5, 0.9}}), HasSubstr("0.9"));
  EXPECT_THAT(error({.stretch = {1, 0, 1}}), HasSubstr("stretch along y = 0"));
  EXPECT_THAT(error({.grow = {.steps = 3, .factor = 1}}), HasSubstr("grow.factor"));
  EXPECT_THAT(error({.threads = -2}), HasSubstr("threads = -2"));
  EXPECT_THAT(error({.domain = {{0, 0}, {0, 1}, {true, false}}}), HasSubstr("period"));
  EXPECT_THAT(error({.domain = {{0, 0}, {1, 1}, {false, false, true}}}),
              HasSubstr("periodic axis = 2"));
  points[17][1] = std::nan("");
  EXPECT_THAT(error({}), HasSubstr("coordinate y of point 17 of the points = nan: must be finite"));
  points[17][1] = 0;
  targets[3][0] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(error({}), HasSubstr("coordinate x of point 3 of the targets = inf"));
  targets[3][0] = 0;
  const auto other = random_points<double, 3>(5, 1);
  EXPECT_THAT(message_of([&] { reconstruct(points_of(points), points_of(other), {}); }),
              HasSubstr("dimension of the targets = 3"));

  const auto fit = reconstruct(points_of(points), points_of(targets), {});
  std::vector<double> u(49, 1.0);
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u)); }), HasSubstr("size of the field = 49"));
  u.resize(50, 1.0);
  const ParticleIndex needed = fit.values().row(0).particle(0);
  u[needed] = std::nan("");
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u)); }),
              HasSubstr("component 0 of the field at point " + std::to_string(needed) + " = nan"));
  u[needed] = 1;
  std::vector<double> out(6);
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u), field_of(out)); }),
              HasSubstr("size of the output = 6"));
  EXPECT_THAT(message_of([&] { fit.gradient().apply_transpose(field_of(targets)).eval(); }),
              HasSubstr("no InvalidArgument"));
  Eigen::MatrixXd three(5, 3);
  three.setZero();
  EXPECT_THAT(message_of([&] { fit.gradient().apply_transpose(field_of(three)); }),
              HasSubstr("multiple of the operator's blocks"));
  EXPECT_THAT(message_of([&] { weight_named("cubik"); }), HasSubstr("did you mean 'cubic'"));
}

TEST(Reconstruct, EmptyInputsWork) {
  const PointList<double, 2> none;
  const auto some = random_points<double, 2>(5, 1);
  const auto no_particles = reconstruct(points_of(none), points_of(some), {});
  EXPECT_EQ(no_particles.report().no_support(), 5u);
  const Eigen::MatrixXd no_values(0, 1), ones = Eigen::MatrixXd::Ones(5, 2);
  EXPECT_TRUE(no_particles.apply(field_of(no_values)).array().isNaN().all());
  const auto no_targets = reconstruct(points_of(some), points_of(none), {});
  EXPECT_EQ(no_targets.apply(field_of(ones)).rows(), 0);
  EXPECT_EQ(no_targets.apply_transpose(field_of(no_values)).rows(), 5);
}

}  // namespace
}  // namespace recon::testing
