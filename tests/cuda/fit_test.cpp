// Fits, operators and products of the GPU against the library, with the threads in a loop on the
// processor.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "cuda/on_host.hpp"
#include "cuda/reconstruction_on.hpp"
#include "recon/operators/reconstruct.hpp"
#include "support/clouds.hpp"

namespace recon::testing {
namespace {

using cuda::Asked;
using cuda::Field;

template <int D, class T, int... degrees>
using HostFit = cuda::ReconstructionOn<cuda::Host, D, T, cuda::Degrees<degrees...>>;

template <class T>
std::vector<T> random_field(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> in(-1, 1);
  std::vector<T> field(count);
  for (T& u : field) u = static_cast<T>(in(random));
  return field;
}

// What rounding may make of results that sum to `scale` at most, with this report: 64 eps a / s.
template <class T>
double rounding_of(const FitReport& report) {
  return 64 * static_cast<double>(std::numeric_limits<T>::epsilon()) *
         std::max(1.0, static_cast<double>(report.amplification)) /
         std::max(static_cast<double>(report.smallest_pivot), 1e-300);
}

// Rows of an operator of the library, as numbers for each particle and image, compared with those
// of the GPU, target by target relative to the largest number of the row.
template <class Fit, class T>
void expect_equal_rows(Fit& fit, const typename Fit::Operator& own, const CsrOperator<T>& library,
                       const std::string& what) {
  ASSERT_EQ(own.blocks, library.blocks());
  for (std::size_t row = 0; row < fit.targets(); ++row) {
    const std::size_t t = fit.target_of()[row];
    const FitReport& report = fit.reports()[t];
    const auto expected = library.row(t);
    const auto first = static_cast<std::size_t>(fit.offsets()[row]);
    const auto count = static_cast<std::size_t>(fit.offsets()[row + 1]) - first;
    ASSERT_EQ(count, expected.size()) << what << ", target " << t;
    // Neither promises an order; images of one particle stand in the same one.
    std::vector<std::size_t> ours(count), theirs(count);
    for (std::size_t e = 0; e < count; ++e) ours[e] = theirs[e] = e;
    std::stable_sort(ours.begin(), ours.end(), [&](std::size_t a, std::size_t b) {
      return fit.columns()[first + a] < fit.columns()[first + b];
    });
    std::stable_sort(theirs.begin(), theirs.end(), [&](std::size_t a, std::size_t b) {
      return expected.particle(a) < expected.particle(b);
    });
    double largest = 0, apart = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t e = theirs[i], f = first + ours[i];
      ASSERT_EQ(fit.columns()[f], expected.particle(e)) << what << ", target " << t;
      for (int b = 0; b < own.blocks; ++b) {
        const double there = static_cast<double>(expected.value(e, b));
        const double here = static_cast<double>(
            own.values
                .data()[f * static_cast<std::size_t>(own.blocks) + static_cast<std::size_t>(b)]);
        largest = std::max(largest, std::abs(there));
        apart = std::isnan(here) ? here : std::max(apart, std::abs(here - there));
      }
    }
    EXPECT_LE(apart, rounding_of<T>(report) * largest) << what << ", target " << t;
  }
}

template <class Fit, class T>
void expect_equal_reports(Fit& fit, const BasicReconstruction<T>& library,
                          const std::string& what) {
  for (std::size_t t = 0; t < fit.targets(); ++t) {
    const FitReport &a = fit.reports()[t], &b = library.report()[t];
    EXPECT_EQ(a.status, b.status) << what << ", target " << t;
    EXPECT_EQ(a.neighbours, b.neighbours) << what << ", target " << t;
    EXPECT_EQ(a.kept, b.kept) << what << ", target " << t;
    EXPECT_EQ(a.degree, b.degree) << what << ", target " << t;
    EXPECT_EQ(a.solver, b.solver) << what << ", target " << t;
    EXPECT_EQ(a.gradient_rank, b.gradient_rank) << what << ", target " << t;
    EXPECT_EQ(a.hessian_rank, b.hessian_rank) << what << ", target " << t;
    const auto near = [](float x, float y) { return std::abs(x - y) <= 1e-3f * std::abs(y); };
    EXPECT_TRUE(near(a.amplification, b.amplification)) << what << ", target " << t;
  }
}

template <int D, class T>
std::vector<std::array<T, static_cast<std::size_t>(D)>> some_targets(std::size_t count) {
  auto targets = random_points<T, D>(count, 91);
  for (auto& x : targets)
    for (T& c : x) c = c * T(1.1) - T(0.05);
  return targets;
}

template <int D, class T, int... degrees>
void expect_the_fits_of_the_library(
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& points,
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& targets, const Options& options,
    const std::string& what, const SourcesOptions& of_sources = {}) {
  using Fit = HostFit<D, T, degrees...>;
  Fit fit(host_sources(points, of_sources), view_of(targets), options);
  fit.check();
  const PointsView<T> at = points_of(points), seen = points_of(targets);
  const BasicSources<T> sources(at, of_sources);
  const BasicReconstruction<T> library(sources, seen, options);
  expect_equal_reports(fit, library, what);
  expect_equal_rows(fit, fit.values(), library.values(), what + ", values");
  for (const Derivative kind : {Derivative::exact, Derivative::diffuse}) {
    typename Fit::Operator gradient;
    fit.derive(Asked::gradient, kind, gradient);
    expect_equal_rows(fit, gradient, library.gradient(kind), what + ", gradient");
  }
  typename Fit::Operator laplacian, hessian;
  fit.derive(Asked::laplacian, Derivative::exact, laplacian);
  fit.derive(Asked::hessian, Derivative::exact, hessian);
  expect_equal_rows(fit, hessian, library.hessian(), what + ", Hessian");
  for (std::size_t e = 0; e < static_cast<std::size_t>(fit.entries()); ++e) {
    T trace = 0;
    int i = 0;
    for (int a = 0; a < D; ++a)
      for (int b = a; b < D; ++b, ++i)
        if (a == b)
          trace += hessian.values.data()[e * static_cast<std::size_t>(hessian.blocks) +
                                         static_cast<std::size_t>(i)];
    EXPECT_EQ(laplacian.values.data()[e], trace);
  }
}

template <int D, class T>
const std::vector<std::array<T, static_cast<std::size_t>(D)>>& even_cloud() {
  static const auto points = jittered_points<T, D>(D == 2 ? 30 : 9, 0.3, 5);
  return points;
}

TEST(CudaFit, IsThatOfTheLibraryInEvenClouds) {
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
    const std::string what(name_of(solver));
    Options options{.degree = 1, .solver = solver};
    expect_the_fits_of_the_library<2, double, 1>(
        even_cloud<2, double>(), some_targets<2, double>(60), options, "2-D by " + what);
    options.neighbours = Radius{0.2};  // more than there is room for in the first pass
    options.weight = Weight::wendland_c2;
    expect_the_fits_of_the_library<2, double, 1>(
        even_cloud<2, double>(), some_targets<2, double>(60), options, "2-D, a radius, by " + what);
    options.degree = 2;
    options.weight = Weight::gaussian;
    options.neighbours = Nearest{21};
    expect_the_fits_of_the_library<3, double, 2>(
        even_cloud<3, double>(), some_targets<3, double>(60), options, "3-D by " + what);
  }
}

TEST(CudaFit, IsThatOfTheLibraryInFloat) {
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt})
    expect_the_fits_of_the_library<3, float, 1>(even_cloud<3, float>(), some_targets<3, float>(60),
                                                {.degree = 1,
                                                 .weight = Weight::quadratic_b_spline,
                                                 .neighbours = Nearest{11},
                                                 .solver = solver},
                                                "float by " + std::string(name_of(solver)));
}

TEST(CudaFit, IsThatOfTheLibraryInDegenerateClouds) {
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
    for (const auto& [name, points] : hostile_clouds<double, 3>())
      if (!points.empty())
        expect_the_fits_of_the_library<3, double, 2>(points, some_targets<3, double>(15),
                                                     {.degree = 2, .solver = solver}, name);
    for (const auto& [name, points] : hostile_clouds<double, 2>())
      if (!points.empty())
        expect_the_fits_of_the_library<2, double, 1>(
            points, some_targets<2, double>(25),
            {.degree = 1, .neighbours = Radius{0.15}, .solver = solver}, name);
  }
}

TEST(CudaFit, IsThatOfTheLibraryWithPeriodsAndStretch) {
  SourcesOptions of_sources;
  of_sources.domain.periodic = {true, true, false};
  of_sources.domain.upper = {1, 0.5, 0};
  of_sources.stretch = {1, 0.5, 1};
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{9}), NeighbourRule(Radius{0.11})})
    expect_the_fits_of_the_library<2, double, 1>(
        even_cloud<2, double>(), some_targets<2, double>(60),
        {.degree = 1, .neighbours = rule, .solver = Solver::moment_matrix}, "periodic", of_sources);
}

TEST(CudaFit, ParticlesOnTheBorderOfASupportHaveNoWeight) {
  // Where the memory held other numbers before.
  const auto lattice = regular_points<double, 2>(11);
  auto moved = lattice;
  for (auto& x : moved)
    for (double& c : x) c = 0.5 + 0.9 * (c - 0.5);
  const double spacing = lattice[1][0] != lattice[0][0] ? lattice[1][0] - lattice[0][0]
                                                        : lattice[1][1] - lattice[0][1];
  const Options options{.degree = 1, .neighbours = Radius{2 * spacing}};
  const auto sources = host_sources(moved);
  HostFit<2, double, 1> fit(sources, view_of(moved), options);
  fit.reserve(121 * 25, 25);
  fit.update(view_of(moved));
  sources->update(view_of(lattice));
  fit.update(view_of(lattice));
  fit.check();
  const Reconstruction library(points_of(lattice), points_of(lattice), options);
  expect_equal_reports(fit, library, "lattice");
  expect_equal_rows(fit, fit.values(), library.values(), "lattice");
  std::size_t without = 0;
  for (std::size_t row = 0; row < lattice.size(); ++row)
    without += fit.offsets()[row + 1] - fit.offsets()[row] >
               fit.reports()[fit.target_of()[row]].neighbours;
  EXPECT_GT(without, 0u);
}

TEST(CudaFit, ReproducesPolynomialsAndTheirDerivatives) {
  const auto& points = even_cloud<3, double>();
  const auto targets = some_targets<3, double>(50);
  HostFit<3, double, 2> fit(host_sources(points), view_of(targets), {.degree = 2});
  const auto u = [](const auto& x) { return 1 + x[0] - 2 * x[1] * x[2] + 3 * x[2] * x[2]; };
  std::vector<double> field, out(targets.size()), slope(3 * targets.size());
  for (const auto& x : points) field.push_back(u(x));
  fit.apply(fit.values(), {field.data(), field.size()}, {out.data(), out.size()});
  HostFit<3, double, 2>::Operator gradient, laplacian;
  fit.derive(Asked::gradient, Derivative::exact, gradient);
  fit.derive(Asked::laplacian, Derivative::exact, laplacian);
  fit.apply(gradient, {field.data(), field.size()}, {slope.data(), targets.size(), 3});
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto& x = targets[t];
    const double bound = rounding_of<double>(fit.reports()[t]) * 5;
    EXPECT_NEAR(out[t], u(x), bound);
    const double exact[3] = {1, -2 * x[2], -2 * x[1] + 6 * x[2]};
    const double h = static_cast<double>(fit.support()[0]);
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(slope[3 * t + d], exact[d], 30 * bound / h);
  }
  fit.apply(laplacian, {field.data(), field.size()}, {out.data(), out.size()});
  for (std::size_t t = 0; t < targets.size(); ++t) EXPECT_NEAR(out[t], 6, 1e-9);
}

TEST(CudaFit, ProductsAreThoseOfTheLibraryAndAdjoint) {
  const auto& points = even_cloud<2, double>();
  const auto targets = some_targets<2, double>(80);
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{9}), NeighbourRule(Radius{0.08})}) {
    HostFit<2, double, 1> fit(host_sources(points), view_of(targets),
                              {.degree = 1, .neighbours = rule});
    HostFit<2, double, 1>::Operator gradient;
    fit.derive(Asked::gradient, Derivative::exact, gradient);
    for (const auto* op : {&fit.values(), const_cast<const decltype(gradient)*>(&gradient)}) {
      // Components in arrays of their own, and others side by side with a gap.
      const std::size_t n = points.size(), m = targets.size();
      const int components = 3, blocks = op->blocks, all = components * blocks;
      const auto u = random_field<double>(3 * n, 1);
      std::vector<double> au(m * static_cast<std::size_t>(all + 1), 7), atf(3 * n);
      fit.apply(*op, {u.data(), n, components, 1, static_cast<std::ptrdiff_t>(n)},
                {au.data(), m, all, all + 1, 1});
      auto f = random_field<double>(m * static_cast<std::size_t>(all), 2);
      fit.apply_transpose(*op, {f.data(), m, all}, {atf.data(), n, components});
      double forward = 0, backward = 0, scale = 0;
      for (std::size_t t = 0; t < m; ++t)
        for (int i = 0; i < all; ++i) {
          const double term =
              au[t * static_cast<std::size_t>(all + 1) + static_cast<std::size_t>(i)] *
              f[t * static_cast<std::size_t>(all) + static_cast<std::size_t>(i)];
          forward += term;
          scale += std::abs(term);
        }
      for (std::size_t p = 0; p < n; ++p)
        for (std::size_t c = 0; c < 3; ++c) backward += u[c * n + p] * atf[p * 3 + c];
      EXPECT_NEAR(forward, backward, 1e-13 * scale);
      for (std::size_t t = 0; t < m; ++t)
        EXPECT_EQ(au[t * static_cast<std::size_t>(all + 1) + static_cast<std::size_t>(all)], 7);
    }
  }
}

TEST(CudaFit, AnUpdateEqualsAFitAnewAndAllocatesNothing) {
  auto points = even_cloud<2, double>();
  auto targets = some_targets<2, double>(80);
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{9}), NeighbourRule(Radius{0.08})}) {
    const Options options{.degree = 1, .neighbours = rule};
    const auto sources = host_sources(points);
    HostFit<2, double, 1> fit(sources, view_of(targets), options);
    const auto f = random_field<double>(targets.size(), 4);
    std::vector<double> back(points.size()), anew(points.size());
    fit.apply_transpose(fit.values(), {f.data(), f.size()}, {back.data(), back.size()});
    const int before = sources->executor()->allocations();
    for (auto& x : points) x[0] += 0.01 * std::sin(9 * x[1]);
    sources->update(view_of(points));
    EXPECT_THROW(
        fit.apply_transpose(fit.values(), {f.data(), f.size()}, {back.data(), back.size()}),
        InvalidArgument);
    fit.update(view_of(targets));
    fit.check();
    fit.apply_transpose(fit.values(), {f.data(), f.size()}, {back.data(), back.size()});
    EXPECT_EQ(sources->executor()->allocations(), before);
    HostFit<2, double, 1> again(host_sources(points), view_of(targets), options);
    again.apply_transpose(again.values(), {f.data(), f.size()}, {anew.data(), anew.size()});
    EXPECT_EQ(back, anew);
  }
}

TEST(CudaFit, AnUpdateWithoutRoomIsRefusedAndEmpty) {
  const auto points = random_points<double, 2>(400, 12);
  const auto targets = some_targets<2, double>(50);
  const auto sources = host_sources(points);
  HostFit<2, double, 1> fit(sources, view_of(targets), {.degree = 1, .neighbours = Radius{0.1}});
  auto crowded = points;
  for (auto& x : crowded)
    for (double& c : x) c = 0.4 + 0.2 * c;
  sources->update(view_of(crowded));
  fit.update(view_of(targets));
  EXPECT_THROW(fit.check(), InvalidArgument);
  EXPECT_EQ(fit.entries(), 0);
  std::vector<double> u(points.size(), 1.0), out(targets.size());
  fit.apply(fit.values(), {u.data(), u.size()}, {out.data(), out.size()});
  for (const double value : out) EXPECT_TRUE(std::isnan(value));
  fit.reserve(50 * 400, 400);
  fit.update(view_of(targets));
  EXPECT_NO_THROW(fit.check());
  EXPECT_GT(fit.entries(), 0);
}

TEST(CudaFit, SaysWhatThereIsNotOnAGpu) {
  const auto points = random_points<double, 2>(50, 12);
  const auto sources = host_sources(points);
  const auto argument = [&](const Options& options) -> std::string {
    try {
      HostFit<2, double, 1> fit(sources, view_of(points), options);
    } catch (const InvalidArgument& error) {
      return error.argument();
    }
    return "";
  };
  EXPECT_EQ(argument({}), "");
  EXPECT_EQ(argument({.degree = 3}), "degree");
  EXPECT_EQ(argument({.weight = Wendland<2>{}}), "weight");
  EXPECT_EQ(argument({.form = WeightForm::tensor_product}), "form");
  EXPECT_EQ(argument({.solver = Solver::qr}), "solver");
  EXPECT_EQ(argument({.neighbours = NearestWithin{3, 0.1}}), "neighbours");
  EXPECT_EQ(argument({.neighbours = Radius{-1}}), "radius");
  EXPECT_EQ(argument({.neighbours = Nearest{0}}), "k");
  EXPECT_EQ(argument({.max_distance = 2}), "max_distance");
  EXPECT_EQ(argument({.grow = {.steps = 1}}), "grow.steps");
  EXPECT_EQ(argument({.unsupported = Unsupported::nearest}), "unsupported");
  EXPECT_EQ(argument({.stretch = {2, 1, 1}}), "stretch");
  HostFit<2, double, 1> fit(sources, view_of(points), {});
  std::vector<double> u(50), out(50);
  EXPECT_THROW(fit.apply(fit.values(), {u.data(), 49}, {out.data(), 50}), InvalidArgument);
  EXPECT_THROW(fit.apply(fit.values(), {u.data(), 50, 1}, {out.data(), 50, 2}), InvalidArgument);
}

TEST(CudaFit, BadTargetsAreNamedAndHaveNoValue) {
  const auto points = random_points<double, 2>(50, 12);
  auto targets = some_targets<2, double>(20);
  targets[7][0] = std::numeric_limits<double>::quiet_NaN();
  HostFit<2, double, 1> fit(host_sources(points), view_of(targets), {});
  try {
    fit.check();
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_EQ(error.argument(), "coordinate x of point 7 of the targets");
  }
  EXPECT_EQ(fit.reports()[7].status, FitStatus::no_support);
  EXPECT_EQ(fit.reports()[8].status, FitStatus::full);
}

TEST(CudaFit, NoParticlesAndNoTargets) {
  const std::vector<std::array<double, 2>> none;
  const auto targets = some_targets<2, double>(5);
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{9}), NeighbourRule(Radius{0.08})}) {
    HostFit<2, double, 1> empty(host_sources(none), view_of(targets), {.neighbours = rule});
    empty.check();
    EXPECT_EQ(empty.reports()[4].status, FitStatus::no_support);
    EXPECT_EQ(empty.entries(), 0);
    HostFit<2, double, 1> no_targets(host_sources(targets), view_of(none), {.neighbours = rule});
    no_targets.check();
    EXPECT_EQ(no_targets.entries(), 0);
    std::vector<double> back(5, 3.0);
    no_targets.apply_transpose(no_targets.values(), {nullptr, 0}, {back.data(), 5});
    EXPECT_EQ(back, std::vector<double>(5, 0.0));
  }
}

}  // namespace
}  // namespace recon::testing
