// Sources: whatever is asked of them is what is asked of the points, in every bit, also after an
// update.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "recon/operators/kernel_sum.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/operators/sparse.hpp"
#include "recon/points/generate.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

std::vector<double> numbers(std::size_t count, unsigned seed, double lower = -1, double upper = 1) {
  RandomNumbers random(seed);
  std::vector<double> values(count);
  for (double& value : values) value = random.uniform(lower, upper);
  return values;
}

template <class Scalar>
void expect_same_bits(const BasicReconstruction<Scalar>& a, const BasicReconstruction<Scalar>& b,
                      std::size_t particles, const std::string& what) {
  std::vector<Scalar> u(particles);
  RandomNumbers random(11);
  for (Scalar& value : u) value = static_cast<Scalar>(random.uniform(-1, 1));
  ASSERT_EQ(a.values().rows(), b.values().rows()) << what;
  std::vector<Scalar> f(a.values().rows());
  for (Scalar& value : f) value = static_cast<Scalar>(random.uniform(-1, 1));
  const auto same = [&](const auto& x, const auto& y) {
    for (Eigen::Index i = 0; i < x.size(); ++i)
      if (!(x.data()[i] == y.data()[i]) && !(std::isnan(x.data()[i]) && std::isnan(y.data()[i])))
        return false;
    return x.size() == y.size();
  };
  EXPECT_TRUE(same(a.apply(field_of(u)), b.apply(field_of(u)))) << what;
  EXPECT_TRUE(same(a.apply_transpose(field_of(f)), b.apply_transpose(field_of(f)))) << what;
  EXPECT_TRUE(same(a.gradient().apply(field_of(u)), b.gradient().apply(field_of(u)))) << what;
  EXPECT_TRUE(same(a.hessian().apply(field_of(u)), b.hessian().apply(field_of(u)))) << what;
  const NeighbourList<Scalar> x = a.neighbours(), y = b.neighbours();
  EXPECT_EQ(x.indices, y.indices) << what;
  EXPECT_EQ(x.offsets, y.offsets) << what;
  EXPECT_EQ(x.support, y.support) << what;
  EXPECT_TRUE(x.shifts == y.shifts) << what;
  ASSERT_EQ(a.report().size(), b.report().size()) << what;
  for (std::size_t t = 0; t < a.report().size(); ++t) {
    EXPECT_EQ(a.report()[t].status, b.report()[t].status) << what;
    EXPECT_EQ(a.report()[t].amplification, b.report()[t].amplification) << what;
  }
}

struct SourcesCase {
  std::string name;
  Options options;
};

template <int D>
std::vector<SourcesCase> cases() {
  const double h = std::pow(900.0, -1.0 / D);
  return {{"nearest", {.degree = 1}},
          {"degree 2", {.degree = 2, .solver = Solver::moment_matrix}},
          {"radius", {.degree = 1, .neighbours = Radius{2.5 * h}}},
          {"wide radius", {.degree = 1, .neighbours = Radius{9 * h}}},
          {"nearest within",
           {.degree = 1, .neighbours = NearestWithin{12, 3 * h}, .search = SearchMethod::kd_tree}},
          {"cube", {.form = WeightForm::tensor_product, .neighbours = Radius{2 * h}}},
          {"grow, nearest, too far",
           {.degree = 2,
            .neighbours = Radius{1.2 * h},
            .max_distance = 1.5,
            .grow = {.steps = 3},
            .unsupported = Unsupported::nearest}}};
}

template <int D>
void check_cases(const PeriodicDomain<double>& domain, const std::vector<double>& weights) {
  const auto points = random_points<double, D>(900, 5), moved = random_points<double, D>(900, 6);
  const auto targets = random_points<double, D>(600, 7), few = random_points<double, D>(70, 8);
  Sources sources(points_of(points), {.domain = domain, .particle_weights = weights});
  for (const SourcesCase& c : cases<D>()) {
    Options direct = c.options;
    direct.domain = domain;
    direct.particle_weights = weights;
    const std::string what = c.name + " in " + std::to_string(D) + "-D";
    Reconstruction fit = reconstruct(sources, points_of(targets), c.options);
    expect_same_bits(fit, reconstruct(points_of(points), points_of(targets), direct), 900, what);
    fit.update(points_of(few));
    expect_same_bits(fit, reconstruct(points_of(points), points_of(few), direct), 900,
                     what + ", other targets");
    sources.update(points_of(moved));
    EXPECT_THAT(message_of([&] { fit.gradient(); }), HasSubstr("update")) << what;
    fit.update(points_of(targets));
    expect_same_bits(fit, reconstruct(points_of(moved), points_of(targets), direct), 900,
                     what + ", moved");
    sources.update(points_of(points));
  }
}

TEST(Sources, GiveWhatThePointsGive) {
  check_cases<1>({}, {});
  check_cases<2>({}, {});
  check_cases<3>({}, {});
  const PeriodicDomain<double> box{{0, 0, 0}, {1, 1, 1}, {true, true, false}};
  check_cases<2>(box, numbers(900, 3, 0.5, 2));
  check_cases<3>(box, numbers(900, 4, 0.5, 2));
}

TEST(Sources, SinglePrecisionAndStretch) {
  const auto points = random_points<float, 2>(700, 5);
  const auto targets = random_points<float, 2>(600, 7);
  const SourcesF sources(points_of(points), {.stretch = {1.5, 0.5, 1}});
  expect_same_bits(
      reconstruct(sources, points_of(targets), {.degree = 2}),
      reconstruct(points_of(points), points_of(targets), {.degree = 2, .stretch = {1.5, 0.5, 1}}),
      700, "stretch");
}

TEST(Sources, NumberOfParticlesMayChange) {
  const auto targets = random_points<double, 3>(600, 7);
  const auto first = random_points<double, 3>(500, 1);
  Sources sources(points_of(first));
  Reconstruction fit = reconstruct(sources, points_of(targets));
  for (const std::size_t count : {2000u, 20u, 1u, 0u, 800u}) {
    const auto points = random_points<double, 3>(count, static_cast<unsigned>(count) + 2);
    sources.update(points_of(points));
    fit.update(points_of(targets));
    expect_same_bits(fit, reconstruct(points_of(points), points_of(targets)), count,
                     std::to_string(count) + " particles");
  }
}

// Particles at one place keep the order of their numbers; all others stand where their positions
// say.
TEST(Sources, TheOrderDependsOnPositionsAlone) {
  auto points = random_points<double, 3>(5000, 9);
  points[17] = points[3];
  const auto places = [](const auto& cloud) {
    const Sources sources(points_of(cloud));
    std::vector<std::array<double, 3>> in_order;
    for (const std::uint32_t p : sources.order()) in_order.push_back(cloud[p]);
    return in_order;
  };
  const auto before = places(points);
  auto shuffled = points;
  std::reverse(shuffled.begin(), shuffled.end());
  const auto after = places(shuffled);
  EXPECT_TRUE(std::is_permutation(before.begin(), before.end(), after.begin(), after.end()));
  // In a cell of three particles the numbers decide, so each place has a particle of the same cell.
  const double edge = std::cbrt(3.0 / 5000);
  for (std::size_t i = 0; i < before.size(); ++i)
    for (int d = 0; d < 3; ++d) EXPECT_LE(std::abs(before[i][d] - after[i][d]), edge) << i;
  Sources updated(points_of(shuffled));
  updated.update(points_of(points));
  const Sources anew(points_of(points));
  EXPECT_TRUE(std::equal(updated.order().begin(), updated.order().end(), anew.order().begin(),
                         anew.order().end()));
  // Steps between followers are short: a few mean spacings.
  double sum = 0;
  for (std::size_t i = 1; i < before.size(); ++i)
    for (int d = 0; d < 3; ++d) sum += std::abs(before[i][d] - before[i - 1][d]);
  EXPECT_LT(sum / 5000, 5 * std::pow(5000.0, -1.0 / 3));
}

TEST(Sources, WhatWasMadeBeforeAnUpdateIsRefused) {
  const auto points = random_points<double, 2>(600, 1), moved = random_points<double, 2>(600, 2);
  const auto u = numbers(600, 3);
  Sources sources(points_of(points));
  const Sources copy = sources;  // the same cloud
  Reconstruction fit = reconstruct(copy, points_of(points));
  const CsrOperator<double> gradient = fit.gradient(), values = fit.values();
  CsrOperator<double> sum = values;
  const VectorOperator<double> divergence = std::get<0>(fit.operators(Functional::divergence));
  const std::vector<std::array<double, 2>> v(600);
  const CsrOperator<double> kernels =
      kernel_operator(copy, points_of(points), {.support = Radius{0.2}});
  const Reconstruction kept = fit;
  sources.update(points_of(moved));
  for (const auto& use : std::vector<std::function<void()>>{
           [&] { fit.apply(field_of(u)); }, [&] { fit.apply_transpose(field_of(u)); },
           [&] { fit.hessian(); }, [&] { gradient.apply(field_of(u)); },
           [&] { values.apply_transpose(field_of(u)); }, [&] { kept.apply(field_of(u)); },
           [&] { fit.report(); }, [&] { fit.neighbours(); }, [&] { fit.support(3); },
           [&] { values.row(3); }, [&] { values.empty_rows(); }, [&] { to_sparse(gradient); },
           [&] { sum += values; }, [&] { sum -= values; }, [&] { sum *= 2; },
           [&] { divergence.apply(field_of(v)); }, [&] { divergence.apply_transpose(field_of(u)); },
           [&] { fit.operators(Functional::value); }})
    EXPECT_THAT(message_of(use), HasSubstr("update() of the reconstruction"));
  // A kernel operator has no update().
  for (const auto& use : std::vector<std::function<void()>>{
           [&] { kernels.apply(field_of(u)); }, [&] { kernels.row(0); }, [&] { kernels * 2.0; }})
    EXPECT_EQ(message_of(use),
              "positions = those before an update of the Sources: must be the present ones: make "
              "the kernel operator anew");
  fit.update(points_of(moved));
  EXPECT_EQ(message_of([&] { fit.apply(field_of(u)); }), "no InvalidArgument was thrown");
  EXPECT_THAT(message_of([&] { kept.apply(field_of(u)); }), HasSubstr("update()"));
  EXPECT_THAT(message_of([&] { gradient.apply(field_of(u)); }), HasSubstr("update()"));
}

TEST(Sources, CopiesOfAReconstructionKeepWhatTheyHave) {
  const auto points = random_points<double, 2>(600, 1), others = random_points<double, 2>(650, 2);
  const Sources sources(points_of(points));
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{11}), NeighbourRule(Radius{0.15})}) {
    Reconstruction fit = reconstruct(sources, points_of(points), {.neighbours = rule});
    const Reconstruction kept = fit;
    const CsrOperator<double> values = fit.values();
    fit.update(points_of(others));
    const Options same{.neighbours = rule};
    expect_same_bits(kept, reconstruct(sources, points_of(points), same), 600, "the copy");
    expect_same_bits(fit, reconstruct(sources, points_of(others), same), 600, "the updated one");
    EXPECT_EQ(values.rows(), 600u);
    const auto u = numbers(600, 3);
    EXPECT_EQ(values.apply(field_of(u)), kept.apply(field_of(u)));
    // A rule that came with an update holds for the copies made after it.
    fit.update(points_of(points), Radius{0.2});
    const Reconstruction another = fit;
    fit.update(points_of(others));
    expect_same_bits(fit, reconstruct(sources, points_of(others), {.neighbours = Radius{0.2}}), 600,
                     "with the later rule");
    expect_same_bits(another, reconstruct(sources, points_of(points), {.neighbours = Radius{0.2}}),
                     600, "its copy");
  }
}

TEST(Sources, RefusedInputChangesNothing) {
  const auto points = random_points<double, 2>(600, 1);
  auto bad = points;
  bad[5][1] = NAN;
  const auto weights = numbers(600, 3, 1, 2);
  Sources sources(points_of(points), {.particle_weights = weights});
  Reconstruction fit = reconstruct(sources, points_of(points));
  EXPECT_THAT(message_of([&] { sources.update(points_of(bad)); }),
              HasSubstr("coordinate y of point 5 of the points = nan"));
  EXPECT_THAT(message_of([&] { sources.update(points_of(points), numbers(599, 1, 1, 2)); }),
              HasSubstr("number of particle_weights = 599"));
  const auto fewer = random_points<double, 2>(9, 1);
  const auto of_3d = random_points<double, 3>(600, 1);
  EXPECT_THAT(message_of([&] { sources.update(points_of(fewer)); }),
              HasSubstr("number of particle_weights = 600"));
  EXPECT_THAT(message_of([&] { sources.update(points_of(of_3d)); }), HasSubstr("dimension"));
  EXPECT_THAT(message_of([&] { fit.update(points_of(bad)); }), HasSubstr("targets = nan"));
  EXPECT_THAT(message_of([&] { fit.update(points_of(points), Radius{-1}); }), HasSubstr("radius"));
  expect_same_bits(fit,
                   reconstruct(points_of(points), points_of(points), {.particle_weights = weights}),
                   600, "after all these");
  for (const auto& [options, what] : std::vector<std::pair<Options, std::string>>{
           {{.particle_weights = weights}, "particle_weights = 600"},
           {{.stretch = {1, 2, 1}}, "stretch = {1, 2, 1}"},
           {{.domain = {{0, 0}, {1, 1}, {true, true, false}}}, "domain = periodic along x, y"}})
    EXPECT_THAT(message_of([&, &o = options] { reconstruct(sources, points_of(points), o); }),
                HasSubstr(what + ": belongs to the Sources"));
}

// What fails in the middle leaves a reconstruction of no targets, which an update mends.
TEST(Sources, AFailedFitHasNoTargets) {
  const auto points = random_points<double, 2>(300, 1), targets = random_points<double, 2>(600, 2);
  const PeriodicDomain<double> box{{0, 0}, {1, 1}, {true, true}};
  const Sources sources(points_of(points), {.domain = box});
  const auto u = numbers(300, 3);
  Reconstruction fit = reconstruct(sources, points_of(targets));
  EXPECT_THAT(message_of([&] { fit.update(points_of(targets), Radius{200}); }),
              HasSubstr("must be from -127 to 127"));
  EXPECT_EQ(fit.apply(field_of(u)).rows(), 0);
  EXPECT_EQ(fit.gradient().rows(), 0u);
  EXPECT_EQ(fit.report().size(), 0u);
  EXPECT_EQ(fit.neighbours().targets(), 0u);
  EXPECT_EQ(std::get<1>(fit.operators(Functional::hessian, Functional::divergence)).rows(), 0u);
  fit.update(points_of(targets));  // with the rule of before
  expect_same_bits(fit, reconstruct(sources, points_of(targets)), 300, "mended");
}

TEST(Sources, NeighboursAndOwnLists) {
  const auto points = random_points<double, 2>(900, 1);
  const auto targets = random_points<double, 2>(600, 2);
  const Sources sources(points_of(points));
  const NeighbourList<double> list = find_neighbours(sources, points_of(targets), Nearest{9});
  const NeighbourList<double> reference = find_neighbours(
      PointCloud<double>(points_of(points)), PointCloud<double>(points_of(targets)), Nearest{9});
  EXPECT_EQ(list.indices, reference.indices);
  EXPECT_EQ(list.support, reference.support);
  Reconstruction fit = reconstruct(sources, points_of(targets), list, {});
  expect_same_bits(fit, reconstruct(points_of(points), points_of(targets), list, {}), 900,
                   "own list");
  EXPECT_THAT(message_of([&] { fit.update(points_of(targets)); }), HasSubstr("neighbours"));
  fit.update(points_of(targets), Nearest{12});
  expect_same_bits(fit,
                   reconstruct(points_of(points), points_of(targets), {.neighbours = Nearest{12}}),
                   900, "a rule instead");
}

// Rows of a reconstruction have an order of their own: that of places, whoever searched them.
TEST(Sources, RowsHoldTheNeighboursInOneOrder) {
  PeriodicDomain<double> box{{0, 0, 0}, {1, 1, 1}, {true, false, true}};
  auto points = random_points<double, 3>(4000, 1);
  for (std::size_t i = 0; i < 1000; ++i)  // exact ties, and some beyond what floats resolve
    for (double& c : points[i]) c = std::round(c * 16) / 16 + (i % 2 ? 1e-12 : 0);
  const auto targets = random_points<double, 3>(1500, 2);
  for (const PeriodicDomain<double>& domain : {PeriodicDomain<double>{}, box})
    for (const NeighbourRule& rule :
         {NeighbourRule(Nearest{17}), NeighbourRule(NearestWithin{9, 0.1}),
          NeighbourRule(Radius{0.11})}) {
      const Sources sources(points_of(points), {.domain = domain});
      const auto expected =
          find_neighbours(sources, points_of(targets), rule, {.search = SearchMethod::brute_force});
      for (const int threads : {1, 2, 3}) {
        const Reconstruction fit = reconstruct(
            sources, points_of(targets), {.degree = 0, .neighbours = rule, .threads = threads});
        const NeighbourList<double> list = fit.neighbours();
        ASSERT_EQ(list.offsets, expected.offsets);
        ASSERT_EQ(list.support, expected.support);
        std::vector<std::uint32_t> place(points.size());
        for (std::size_t i = 0; i < place.size(); ++i) place[sources.order()[i]] = std::uint32_t(i);
        for (std::size_t t = 0; t < targets.size(); ++t) {
          std::vector<std::pair<std::uint32_t, ImageShift>> row, wanted;
          for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
            row.emplace_back(place[list.indices[e]],
                             list.shifts.empty() ? ImageShift{} : list.shifts[e]);
            wanted.emplace_back(place[expected.indices[e]],
                                expected.shifts.empty() ? ImageShift{} : expected.shifts[e]);
          }
          std::sort(wanted.begin(), wanted.end());
          ASSERT_EQ(row, wanted) << "target " << t << ", rule " << rule.index();
        }
      }
    }
}

TEST(Sources, NodesOfAGridAreTargets) {
  const auto points = random_points<double, 2>(500, 1);
  const Sources sources(points_of(points));
  StructuredGrid<double> grid{2, {0.1, 0.2}, {0.05, 0.05}, {15, 12}};
  const auto check = [&](const Options& options, const Options& said) {
    const auto nodes = grid.nodes();
    const Reconstruction by_hand = reconstruct(sources, nodes.view(), said);
    expect_same_bits(reconstruct(sources, grid, options), by_hand, 500, "Sources");
    expect_same_bits(reconstruct(points_of(points), grid, options), by_hand, 500, "points");
  };
  // What is left empty is what grids need; what is said is what it is for points.
  check({.degree = 2}, {.degree = 2,
                        .form = WeightForm::tensor_product,
                        .neighbours = Radius{0.1},
                        .solver = Solver::moment_matrix});
  const Options said{.degree = 3,
                     .form = WeightForm::radial,
                     .neighbours = Nearest{25},
                     .solver = Solver::gram_schmidt};
  check(said, said);
  // Supports of two spacings along each axis.
  grid.spacing[1] = 0.02;
  const auto nodes = grid.nodes();
  const Reconstruction fit = reconstruct(points_of(points), grid, {.degree = 0});
  for (std::size_t t = 0; t < grid.size(); ++t) {
    std::size_t inside = 0;
    for (const auto& p : points)
      inside +=
          std::abs(p[0] - nodes.view()(t, 0)) < 0.1 && std::abs(p[1] - nodes.view()(t, 1)) < 0.04;
    EXPECT_EQ(fit.report()[t].neighbours, inside) << t;
  }
  EXPECT_THAT(message_of([&] { reconstruct(sources, grid); }),
              HasSubstr("neighbours = empty: must be said for Sources on a grid whose spacings"));
}

TEST(Reconstruction, IsOfNothingByDefault) {
  Reconstruction fit;
  EXPECT_EQ(fit.report().size(), 0u);
  EXPECT_EQ(fit.values().rows(), 0u);
  EXPECT_EQ(fit.neighbours().targets(), 0u);
  const std::vector<double> none;
  EXPECT_EQ(fit.apply(field_of(none)).size(), 0);
  EXPECT_EQ(fit.apply_transpose(field_of(none)).size(), 0);
  EXPECT_EQ(fit.gradient().rows(), 0u);
  const auto points = random_points<double, 2>(500, 1);
  fit = reconstruct(points_of(points), points_of(points));
  EXPECT_EQ(fit.report().size(), 500u);
}

TEST(Sources, AnyIntegerCountsNeighbours) {
  const auto points = random_points<double, 2>(500, 1);
  const int k = 9;
  const Sources sources(points_of(points));
  EXPECT_EQ(find_neighbours(sources, points_of(points), Nearest{k}).indices,
            find_neighbours(sources, points_of(points), Nearest{9u}).indices);
  EXPECT_THAT(
      message_of([&] { reconstruct(sources, points_of(points), {.neighbours = Nearest{-3}}); }),
      HasSubstr("k = -3: must be from 1"));
}

// What is stale says so, whatever the field given to it.
TEST(Sources, StaleUseIsNamedBeforeSizes) {
  const auto before = random_points<double, 2>(500, 1), after = random_points<double, 2>(450, 2);
  Sources sources(points_of(before));
  const Reconstruction fit = reconstruct(sources, points_of(before));
  const auto slopes = fit.gradient();
  sources.update(points_of(after));
  const auto u = numbers(450, 3);
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u)); }), HasSubstr("update()"));
  EXPECT_THAT(message_of([&] { slopes.apply(field_of(u)); }), HasSubstr("update()"));
  EXPECT_THAT(message_of([&] { fit.apply_transpose(field_of(u)); }), HasSubstr("update()"));
}

TEST(Reconstruction, TargetsAndEnumeratorsOutsideTheirRangeAreNamed) {
  const auto points = random_points<double, 2>(100, 1);
  const Reconstruction fit = reconstruct(points_of(points), points_of(points));
  EXPECT_THAT(message_of([&] { fit.values().row(100); }), HasSubstr("target = 100"));
  EXPECT_THAT(message_of([&] { fit.support(99999); }), HasSubstr("target = 99999"));
  EXPECT_THAT(message_of([&] { Reconstruction().support(0); }), HasSubstr("target = 0"));
  Options options;
  options.unsupported = static_cast<Unsupported>(9);
  EXPECT_THAT(message_of([&] { reconstruct(points_of(points), points_of(points), options); }),
              HasSubstr("unsupported = 9"));
  options = {};
  options.search = static_cast<SearchMethod>(9);
  EXPECT_THAT(message_of([&] { reconstruct(points_of(points), points_of(points), options); }),
              HasSubstr("search = 9"));
  const std::vector<double> u(points.size(), 1);
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u), {.limit = static_cast<Limit>(9)}); }),
              HasSubstr("limit = 9"));
  EXPECT_THAT(message_of([&] { fit.apply(field_of(u), {.data = static_cast<Data>(9)}); }),
              HasSubstr("data = 9"));
  const auto kind = static_cast<Derivative>(9);
  EXPECT_THAT(message_of([&] { fit.gradient(kind); }), HasSubstr("derivative = 9"));
  EXPECT_THAT(message_of([&] { fit.operators(Functional::divergence.with(kind)); }),
              HasSubstr("derivative = 9"));
  EXPECT_THAT(message_of([&] {
                kernel_operator(Sources(points_of(points)), points_of(points),
                                {.form = static_cast<WeightForm>(9)});
              }),
              HasSubstr("form = 9"));
}

// The supports stay those of the first grid: an update asks for other targets, not for another rule.
TEST(Reconstruction, UpdatesToAnotherGrid) {
  const auto points = random_points<double, 2>(400, 1);
  const auto coarse = covering_grid<double>({{0, 0, 0}, {1, 1, 0}, 2}, 0.25);
  const auto fine = covering_grid<double>({{0, 0, 0}, {1, 1, 0}, 2}, 0.125);
  Reconstruction fit = reconstruct(points_of(points), coarse, {.degree = 1});
  const double support = fit.support(0);
  fit.update(fine);
  Options options{.degree = 1, .neighbours = Radius{support}};
  const Reconstruction anew = reconstruct(points_of(points), fine, options);
  std::vector<double> u;
  for (const auto& x : points) u.push_back(std::sin(3 * x[0]) * x[1]);
  EXPECT_EQ(fit.apply(field_of(u)), anew.apply(field_of(u)));
  StructuredGrid<double> broken = fine;
  broken.spacing[1] = -1;
  EXPECT_THAT(message_of([&] { fit.update(broken); }), HasSubstr("spacing"));
}

}  // namespace
}  // namespace recon::testing
