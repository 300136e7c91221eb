// Moments at the nodes of grids, and what is solved from them, against the library.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "cuda/grid_moments_on.hpp"
#include "cuda/on_host.hpp"
#include "recon/grid/grid_moments.hpp"

namespace recon::testing {
namespace {

template <int D, class T, int... degrees>
using HostMoments = cuda::GridMomentsOn<cuda::Host, D, T, cuda::Degrees<degrees...>>;

template <int D, class T>
std::vector<std::array<T, 4>> some_field(
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& points) {
  std::vector<std::array<T, 4>> field;
  for (const auto& x : points)
    field.push_back({T(1), x[0], x[1] * x[D - 1], std::sin(T(9) * x[0] * x[D - 1])});
  return field;
}

template <int D, class T, int degree>
void expect_the_moments_of_the_library(
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& points,
    const StructuredGrid<T>& grid, const Options& options, const std::string& what) {
  const auto field = some_field<D, T>(points);
  HostMoments<D, T, degree> moments(host_sources(points), grid, 4, options);
  moments.sum({points.empty() ? nullptr : field[0].data(), field.size(), 4});
  const PointsView<T> at = points_of(points);
  BasicGridMoments<T> library(at, {field_of(field)}, grid, options);
  ASSERT_EQ(moments.per_node(), library.per_node());
  const auto per_node = static_cast<std::size_t>(library.per_node());
  const double eps = static_cast<double>(std::numeric_limits<T>::epsilon());
  for (std::size_t node = 0; node < grid.size(); ++node) {
    const T* const own = moments.values() + node * per_node;
    const T* const expected = library.values().data() + node * per_node;
    EXPECT_EQ(own[0], expected[0]) << what << ", neighbours of node " << node;
    // All sums are of terms of at most w: rounding is that of the sum of the weights, and of the
    // offsets of particles in the grid.
    const double scale = std::max(1.0, static_cast<double>(expected[1]));
    for (std::size_t i = 1; i < per_node; ++i)
      EXPECT_NEAR(own[i], expected[i], 64 * eps * scale) << what << ", node " << node << ", " << i;
  }
  // The same sums for both, so that what is compared is what is solved from them.
  std::copy_n(moments.values(), grid.size() * per_node, library.values().begin());
  const auto solved = library.solve({.gradients = Derivative::diffuse});
  std::vector<T> values(4 * grid.size()), gradients(4 * D * grid.size());
  moments.solve({values.data(), grid.size(), 4}, {gradients.data(), grid.size(), 4 * D});
  for (std::size_t node = 0; node < grid.size(); ++node) {
    const FitReport &a = moments.reports()[node], &b = solved.report()[node];
    EXPECT_EQ(a.status, b.status) << what << ", node " << node;
    EXPECT_EQ(a.degree, b.degree) << what << ", node " << node;
    EXPECT_EQ(a.kept, b.kept) << what << ", node " << node;
    EXPECT_EQ(a.neighbours, b.neighbours) << what << ", node " << node;
    EXPECT_EQ(a.gradient_rank, b.gradient_rank) << what << ", node " << node;
    const auto row = static_cast<Eigen::Index>(node);
    const double bound = 64 * eps * std::max(1.0, static_cast<double>(b.amplification)) /
                         std::max(1e-300, static_cast<double>(b.smallest_pivot));
    for (int c = 0; c < 4; ++c) {
      const T own = values[node * 4 + static_cast<std::size_t>(c)];
      const T expected = solved.values()(row, c);
      EXPECT_EQ(std::isnan(own), std::isnan(expected));
      if (std::isnan(own)) continue;
      EXPECT_NEAR(own, expected, bound) << what << ", node " << node;
      for (int d = 0; d < D; ++d)
        EXPECT_NEAR(
            gradients[(node * 4 + static_cast<std::size_t>(c)) * D + static_cast<std::size_t>(d)],
            solved.gradients()(row, c * D + d),
            bound * std::max(1.0, static_cast<double>(b.gradient_amplification)) /
                static_cast<double>(grid.spacing[static_cast<std::size_t>(d)]))
            << what << ", node " << node;
    }
  }
}

StructuredGrid<double> grid_2d() {
  return {2, {-0.3, -0.1, 0}, {0.11, 0.083, 1}, {15, 14, 1}};
}

TEST(CudaGrid, MomentsAreThoseOfTheLibrary) {
  expect_the_moments_of_the_library<2, double, 1>(random_points<double, 2>(600, 5), grid_2d(),
                                                  {.degree = 1}, "cubic splines");
  expect_the_moments_of_the_library<2, double, 1>(random_points<double, 2>(600, 5), grid_2d(),
                                                  {.degree = 1,
                                                   .weight = Weight::wendland_c2,
                                                   .form = WeightForm::radial,
                                                   .neighbours = Radius{0.2}},
                                                  "a radius");
  const StructuredGrid<double> grid{3, {0, 0, 0.05}, {0.2, 0.2, 0.18}, {6, 6, 5}};
  expect_the_moments_of_the_library<3, double, 2>(
      random_points<double, 3>(800, 6), grid, {.degree = 2, .weight = Weight::quadratic_b_spline},
      "degree 2");
}

TEST(CudaGrid, ParticlesOfNegligibleWeightDoNotCount) {
  const auto grid = grid_2d();
  std::vector<std::array<double, 2>> points;
  for (const double off : {0.0, 1e-13, 1e-12, 1e-9, 1e-3})
    points.push_back(
        {grid.origin[0] + (7 - off) * grid.spacing[0], grid.origin[1] + 6 * grid.spacing[1]});
  expect_the_moments_of_the_library<2, double, 1>(points, grid, {.degree = 1}, "a border");
}

TEST(CudaGrid, GradientsAcrossSheetsAreNone) {
  // Nodes lie within a sheet that is thick enough for a fit and too thin for a slope.
  const auto grid = grid_2d();
  auto points = random_points<double, 2>(200, 10);
  for (auto& x : points) x[1] = grid.origin[1] + 6 * grid.spacing[1] + 5e-5 * std::sin(900 * x[0]);
  expect_the_moments_of_the_library<2, double, 1>(points, grid, {.degree = 1}, "a sheet");
  HostMoments<2, double, 1> moments(host_sources(points), grid, 1, {.degree = 1});
  std::vector<double> u(points.size(), 1.0), values(grid.size());
  moments.sum({u.data(), u.size()});
  moments.solve({values.data(), values.size()}, {});
  int unresolved = 0;
  for (std::size_t node = 0; node < grid.size(); ++node)
    unresolved += moments.reports()[node].degree == 1 && moments.reports()[node].gradient_rank == 1;
  EXPECT_GT(unresolved, 5);
}

TEST(CudaGrid, FewAndFlatParticlesLowerTheDegree) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{40}})
    expect_the_moments_of_the_library<2, double, 1>(random_points<double, 2>(count, 7), grid_2d(),
                                                    {.degree = 1}, std::to_string(count));
  expect_the_moments_of_the_library<2, double, 1>(flat_points<double, 2>(100, 1, 0, 8), grid_2d(),
                                                  {.degree = 1}, "a line");
  expect_the_moments_of_the_library<2, double, 1>(flat_points<double, 2>(100, 1, 1e-4, 8),
                                                  grid_2d(), {.degree = 1}, "a thin sheet");
}

TEST(CudaGrid, SaysWhatItCannotDo) {
  const auto points = random_points<double, 2>(20, 9);
  const auto argument = [&](const Options& options, const SourcesOptions& of_sources = {}) {
    try {
      HostMoments<2, double, 1> moments(host_sources(points, of_sources), grid_2d(), 1, options);
    } catch (const InvalidArgument& error) {
      return error.argument();
    }
    return std::string();
  };
  EXPECT_EQ(argument({}), "");
  EXPECT_EQ(argument({.degree = 2}), "degree");
  EXPECT_EQ(argument({.neighbours = Nearest{5}}), "neighbours");
  EXPECT_EQ(argument({}, {.stretch = {1, 2, 1}}), "stretch of the Sources");
  SourcesOptions periodic;
  periodic.domain = {{0, 0, 0}, {1, 1, 0}, {true, false, false}};
  EXPECT_EQ(argument({}, periodic), "domain of the Sources");
  HostMoments<2, double, 1> moments(host_sources(points), grid_2d(), 1, {});
  std::vector<double> u(20);
  EXPECT_THROW(moments.sum({u.data(), 19}), InvalidArgument);
  EXPECT_THROW(moments.sum({u.data(), 10, 2}), InvalidArgument);
}

}  // namespace
}  // namespace recon::testing
