// The distributed grid and the reconstruction on it: against the serial one, on any number of ranks.
#include <petscdmda.h>
#include <petsclog.h>

#include <numeric>

#include "petsc/petsc_support.hpp"
#include "recon/grid/grid_moments.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/petsc/reconstruct_on_grid.hpp"

namespace recon::testing {
namespace {

using petsc::DistributedGrid;
using ::testing::HasSubstr;

constexpr double tolerance = 1e-12;

// The number in all() of node i of a part of the grid that begins at `begin`, images brought back.
std::size_t number_in_all(const DistributedGrid& grid, const StructuredGrid<double>& part,
                          const std::array<std::int64_t, 3>& begin, std::size_t i) {
  const auto index = part.index(i);
  std::size_t number = 0;
  for (int d = grid.all().dimension - 1; d >= 0; --d) {
    const auto nodes = static_cast<std::int64_t>(grid.all().counts[d]);
    const std::int64_t at = begin[d] + static_cast<std::int64_t>(index[d]);
    number = number * grid.all().counts[d] + static_cast<std::size_t>((at + nodes) % nodes);
  }
  return number;
}
std::size_t owned_number(const DistributedGrid& grid, std::size_t i) {
  return number_in_all(grid, grid.owned(), grid.owned_begin(), i);
}
std::size_t piece_number(const DistributedGrid& grid, std::size_t i) {
  return number_in_all(grid, grid.piece(), grid.piece_begin(), i);
}

template <int D>
std::vector<petsc::DistributedGridOptions> layouts() {
  std::vector<petsc::DistributedGridOptions> all{{}};
  all.push_back({.periodic = {true, D > 1, D > 2}});
  all.push_back({.periodic = {D == 1, D > 1, false}, .ghosts = 3});
  return all;
}

template <class Dimension>
class GridOnRanks : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                                    std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(GridOnRanks, Dimensions);

TYPED_TEST(GridOnRanks, EveryNodeHasOneOwner) {
  constexpr int D = TypeParam::value;
  for (const auto& layout : layouts<D>()) {
    const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>(), layout);
    std::vector<double> owners(grid.all().size(), 0);
    for (std::size_t i = 0; i < grid.owned().size(); ++i) {
      owners[owned_number(grid, i)] += 1;
      // rank_of at a node is its owner.
      std::array<double, 3> x{};
      const auto index = grid.owned().index(i);
      for (int d = 0; d < D; ++d)
        x[d] = grid.all().coordinate(index[d] + static_cast<std::size_t>(grid.owned_begin()[d]), d);
      bool below = false;  // a place may round to below its node
      for (int d = 0; d < D; ++d)
        below =
            below || std::floor(grid.place(x[d], d)) !=
                         static_cast<double>(index[d]) + static_cast<double>(grid.owned_begin()[d]);
      if (!below) {
        EXPECT_EQ(grid.rank_of(x), world().rank());
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, owners.data(), static_cast<int>(owners.size()), MPI_DOUBLE, MPI_SUM,
                  PETSC_COMM_WORLD);
    EXPECT_EQ(owners, std::vector<double>(owners.size(), 1));
  }
}

// fill() is the identity of values that are functions of the node, and sum() its transpose.
TYPED_TEST(GridOnRanks, FillGivesTheNodesValuesAndSumIsItsTranspose) {
  constexpr int D = TypeParam::value;
  for (const auto& layout : layouts<D>()) {
    const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>(), layout);
    constexpr int width = 3;
    const auto value = [](std::size_t node, int q) {
      return std::sin(1.7 * static_cast<double>(3 * node) + q);
    };
    std::vector<double> owned;
    for (std::size_t i = 0; i < grid.owned().size(); ++i)
      for (int q = 0; q < width; ++q) owned.push_back(value(owned_number(grid, i), q));
    const std::vector<double> filled = grid.fill(owned, width);
    ASSERT_EQ(filled.size(), grid.piece().size() * width);
    std::vector<double> piece;
    double forward = 0, back = 0;
    for (std::size_t i = 0; i < grid.piece().size(); ++i)
      for (int q = 0; q < width; ++q) {
        ASSERT_EQ(filled[i * width + q], value(piece_number(grid, i), q));
        piece.push_back(std::cos(0.3 * static_cast<double>(i + 7 * world().rank()) + q));
        forward += piece.back() * filled[i * width + q];
      }
    const std::vector<double> sums = grid.sum(piece, width);
    ASSERT_EQ(sums.size(), owned.size());
    back = std::inner_product(sums.begin(), sums.end(), owned.begin(), 0.0);
    std::array<double, 2> both{forward, back};
    MPI_Allreduce(MPI_IN_PLACE, both.data(), 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_NEAR(both[0], both[1],
                tolerance * static_cast<double>(grid.all().size()) * world().size());
  }
}

// The messages and bytes that traffic() foretells are those that PETSc counts. (The first exchange
// also makes the plan of it.)
TYPED_TEST(GridOnRanks, TrafficIsWhatPetscSends) {
  constexpr int D = TypeParam::value;
  for (const auto& layout : layouts<D>()) {
    const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>(), layout);
    constexpr int width = 5;
    const std::vector<double> ones(grid.piece().size() * width, 1.0);
    grid.sum(ones, width);
    const double messages = petsc_isend_ct + petsc_send_ct;
    const double bytes = petsc_isend_len + petsc_send_len;
    grid.sum(ones, width);
    EXPECT_EQ(petsc_isend_ct + petsc_send_ct - messages,
              static_cast<double>(grid.traffic(width).messages));
    EXPECT_EQ(petsc_isend_len + petsc_send_len - bytes,
              static_cast<double>(grid.traffic(width).bytes));
  }
}

TYPED_TEST(GridOnRanks, SeveralArraysInOneRound) {
  constexpr int D = TypeParam::value;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>());
  std::vector<double> a(grid.piece().size()), b(grid.piece().size() * 4);
  std::iota(a.begin(), a.end(), 1.0);
  std::iota(b.begin(), b.end(), -5.0);
  const std::vector<petsc::NodeValues> arrays{{a, 1}, {b, 4}};
  const auto sums = grid.sum(arrays);
  ASSERT_EQ(sums.size(), 2u);
  EXPECT_EQ(sums[0], grid.sum(a, 1));
  EXPECT_EQ(sums[1], grid.sum(b, 4));
}

// What each rank has is what the serial moments of all particles give at its nodes.
template <int D>
void expect_serial(const Points<D>& points, const Matrix& u, std::span<const double> weights,
                   const DistributedGrid& grid, const Options& options, const std::string& where) {
  SCOPED_TRACE(where);
  // The serial grid has the images of the first and last layers beside it, where axes are periodic:
  // each particle is there with all of its images.
  StructuredGrid<double> all = grid.all();
  Points<D> images = points;
  std::vector<std::size_t> number(points.size());
  std::iota(number.begin(), number.end(), 0u);
  for (int d = 0; d < D; ++d) {
    if (!grid.periodic()[d]) continue;
    const double period = static_cast<double>(all.counts[d]) * all.spacing[d];
    const std::size_t count = images.size();
    for (const double shift : {-period, period})
      for (std::size_t p = 0; p < count; ++p) {
        images.push_back(images[p]);
        images.back()[d] += shift;
        number.push_back(number[p]);
      }
  }
  Options serial = options;
  std::vector<double> all_weights, own_weights;
  for (const std::size_t p : number)
    if (!weights.empty()) all_weights.push_back(weights[p]);
  serial.particle_weights = all_weights;
  const Matrix data = chosen(u, number);
  const GridReconstruction expected =
      GridMoments(view_of<D>(images), {field_view(data)}, all, serial)
          .solve({.gradients = Derivative::diffuse});

  const auto own =
      mine(points, world(), [&](std::size_t p) { return grid.rank_of(padded(points[p])); });
  const Points<D> own_points = chosen(points, own);
  const Matrix own_data = chosen(u, own);
  Options parallel = options;
  for (const std::size_t p : own)
    if (!weights.empty()) own_weights.push_back(weights[p]);
  parallel.particle_weights = own_weights;
  const GridReconstruction fit =
      petsc::reconstruct_on_grid(view_of<D>(own_points), {field_view(own_data)}, grid, parallel,
                                 {.gradients = Derivative::diffuse});
  ASSERT_EQ(fit.size(), grid.owned().size());
  std::size_t differ = 0;
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const std::size_t node = owned_number(grid, i);
    const FitReport &a = fit.report()[i], &b = expected.report()[node];
    EXPECT_EQ(a.neighbours, b.neighbours) << "node " << node;
    // Where a limit decides (that of rank, leverage or slopes), rounding does.
    if (a.status != b.status || a.degree != b.degree || a.rank != b.rank || a.kept != b.kept ||
        a.gradient_rank != b.gradient_rank) {
      ++differ;
      continue;
    }
    if (a.status == FitStatus::no_support) continue;
    EXPECT_FLOAT_EQ(a.amplification, b.amplification);
    EXPECT_NEAR(a.smallest_pivot, b.smallest_pivot, 1e-6);
    // Values are good to rounding times what the fit amplifies; the data are of the order of one.
    const double scale = std::max(1.0, static_cast<double>(b.amplification)) /
                         std::max(1e-8, static_cast<double>(b.smallest_pivot));
    for (Eigen::Index c = 0; c < fit.values().cols(); ++c)
      ASSERT_NEAR(fit.values()(static_cast<Eigen::Index>(i), c),
                  expected.values()(static_cast<Eigen::Index>(node), c), tolerance * scale)
          << "node " << node << " pivot " << b.smallest_pivot;
    for (Eigen::Index c = 0; c < fit.gradients().cols(); ++c)
      ASSERT_NEAR(fit.gradients()(static_cast<Eigen::Index>(i), c),
                  expected.gradients()(static_cast<Eigen::Index>(node), c),
                  tolerance * scale / all.spacing[0] * std::max(1.0f, b.gradient_amplification))
          << "node " << node;
  }
  EXPECT_LE(differ, fit.size() / 200) << "reports that differ";
}

TYPED_TEST(GridOnRanks, EqualsTheSerialMoments) {
  constexpr int D = TypeParam::value;
  const std::size_t count = D == 1 ? 150 : D == 2 ? 2000 : 12000;
  for (const auto& layout : layouts<D>())
    for (const int degree : {0, 1, 2}) {
      const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>(), layout);
      const auto points = points_in<D>(grid.all(), count, 0, 5);
      Options options{.degree = degree};
      if (layout.ghosts == 3) options.stretch = {1.3, 1, 1.45};
      expect_serial<D>(
          points, waves(points, 2), {}, grid, options,
          "degree " + std::to_string(degree) + " ghosts " + std::to_string(layout.ghosts));
    }
}

TYPED_TEST(GridOnRanks, EqualsTheSerialMomentsWithOtherChoices) {
  constexpr int D = TypeParam::value;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>());
  const auto points = points_in<D>(grid.all(), D == 3 ? 6000 : 800, 0, 6);
  const Matrix u = waves(points, 1);
  const double h = grid.all().spacing[0];
  expect_serial<D>(points, u, {}, grid, {.weight = Weight::quadratic_b_spline}, "quadratic");
  expect_serial<D>(
      points, u, {}, grid,
      {.weight = Weight::gaussian, .form = WeightForm::radial, .neighbours = Radius{1.7 * h}},
      "radial Gaussian");
  std::vector<double> weights(points.size());
  for (std::size_t p = 0; p < weights.size(); ++p)
    weights[p] = 1 + 0.5 * std::sin(static_cast<double>(p));
  expect_serial<D>(points, u, weights, grid, {}, "particle weights");
}

// Few particles, holes, and particles beyond the grid: nodes without support and reduced degrees.
TYPED_TEST(GridOnRanks, EqualsTheSerialMomentsOfSparseClouds) {
  constexpr int D = TypeParam::value;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>());
  // None lies on a node, and so on the border of the support of another one that sees nothing else:
  // whether such a node has a value is up to rounding.
  for (const std::size_t count : {0u, 1u, 9u, 60u}) {
    const auto points = points_in<D>(grid.all(), count, 0.2, 7, 0);
    expect_serial<D>(points, waves(points, 2), {}, grid, {.degree = 1},
                     std::to_string(count) + " particles");
  }
}

TYPED_TEST(GridOnRanks, CellCentresEqualTheSerialMoments) {
  constexpr int D = TypeParam::value;
  for (const bool periodic : {false, true}) {
    const DistributedGrid nodes(PETSC_COMM_WORLD, unit_grid<D>(),
                                {.periodic = {periodic, periodic && D > 1, false}});
    const DistributedGrid cells = nodes.cells();
    if (!periodic) {
      EXPECT_EQ(cells.all().counts, cell_centres(nodes.all()).counts);
      EXPECT_EQ(cells.all().origin, cell_centres(nodes.all()).origin);
    }
    // The rank of a cell is that of the node at its lower corner.
    EXPECT_EQ(cells.owned_begin(), nodes.owned_begin());
    // Some lie on centres: a particle on a node would lie on the very border of supports, where
    // rounding says whether it counts.
    const auto points = points_in<D>(cells.all(), D == 3 ? 5000 : 700, 0, 8);
    // The particles are where those of the nodes are: half a cell more is within the ghosts.
    const Matrix u = waves(points, 1);
    const auto own =
        mine(points, world(), [&](std::size_t p) { return nodes.rank_of(padded(points[p])); });
    const Points<D> own_points = chosen(points, own);
    const Matrix own_u = chosen(u, own);
    const GridReconstruction of_nodes_ranks = petsc::reconstruct_on_grid(
        view_of<D>(own_points), {field_view(own_u)}, cells, {.weight = Weight::quadratic_b_spline});
    EXPECT_EQ(of_nodes_ranks.size(), cells.owned().size());
    expect_serial<D>(points, u, {}, cells, {.weight = Weight::quadratic_b_spline}, "cells");
  }
}

// Linear fields are exact with degree 1, quadratic ones with degree 2, whoever has the particles.
TYPED_TEST(GridOnRanks, PolynomialsAreReproduced) {
  constexpr int D = TypeParam::value;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>());
  const auto points = points_in<D>(grid.all(), D == 3 ? 30000 : 3000, 0, 9);
  const auto own =
      mine(points, world(), [&](std::size_t p) { return grid.rank_of(padded(points[p])); });
  const Points<D> own_points = chosen(points, own);
  for (const int degree : {1, 2}) {
    const auto field = [&](const auto& x) {
      double sum = 1;
      for (int d = 0; d < D; ++d) sum += (d + 1) * x[d];
      return degree == 1 ? sum : sum * sum;
    };
    Matrix u(own.size(), 1);
    for (std::size_t p = 0; p < own.size(); ++p)
      u(static_cast<Eigen::Index>(p), 0) = field(own_points[p]);
    const GridReconstruction fit = petsc::reconstruct_on_grid(
        view_of<D>(own_points), {field_view(u)}, grid, {.degree = degree});
    std::size_t reached = 0;
    for (std::size_t i = 0; i < fit.size(); ++i) {
      if (fit.report()[i].degree < degree) continue;
      ++reached;
      std::array<double, 3> x{};
      for (int d = 0; d < D; ++d) x[d] = grid.owned().coordinate(grid.owned().index(i)[d], d);
      EXPECT_NEAR(fit.values()(static_cast<Eigen::Index>(i), 0), field(x), 1e-10);
    }
    EXPECT_GT(reached, fit.size() * 9 / 10);
  }
}

// What moments are not enough for: the particles may be with any rank, here dealt out in turns.
template <int D>
void expect_serial_by_halos(const Points<D>& points, const Matrix& u, const DistributedGrid& grid,
                            const Options& options, const GridApply& apply, bool radii,
                            const std::string& where) {
  SCOPED_TRACE(where);
  const auto radius = [&](std::size_t node) {
    return grid.all().spacing[0] * (2.5 + 0.4 * std::sin(static_cast<double>(node)));
  };
  Options serial = options, parallel = options;
  std::vector<double> all_radii, own_radii;
  for (std::size_t i = 0; i < grid.all().size(); ++i) all_radii.push_back(radius(i));
  for (std::size_t i = 0; i < grid.owned().size(); ++i)
    own_radii.push_back(radius(owned_number(grid, i)));
  serial.domain = grid.domain();
  if (radii) {
    serial.neighbours = Radii{all_radii};
    parallel.neighbours = Radii{own_radii};
  }
  const GridReconstruction expected =
      reconstruct_on_grid(view_of<D>(points), {field_view(u)}, grid.all(), serial, apply);
  const auto own = mine(points, world(), [](std::size_t p) {
    return static_cast<int>(p % static_cast<std::size_t>(world().size()));
  });
  const Points<D> own_points = chosen(points, own);
  const Matrix own_u = chosen(u, own), first = own_u.leftCols(1),
               rest = own_u.rightCols(own_u.cols() - 1);
  const GridReconstruction fit = petsc::reconstruct_on_grid(
      view_of<D>(own_points), {field_view(first), field_view(rest)}, grid, parallel, apply);
  ASSERT_EQ(fit.size(), grid.owned().size());
  ASSERT_EQ(fit.limited().components.size(), apply.limit == Limit::none ? 0 : fit.size());
  if (apply.limit != Limit::none) {
    EXPECT_GT(expected.limited().targets, 0u) << "the test needs overshoots";
  }
  ASSERT_EQ(fit.gradients().cols(), expected.gradients().cols());
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const std::size_t node = owned_number(grid, i);
    const FitReport &a = fit.report()[i], &b = expected.report()[node];
    ASSERT_EQ(a.neighbours, b.neighbours) << "node " << node;
    ASSERT_EQ(a.status, b.status) << "node " << node;
    ASSERT_EQ(a.kept, b.kept) << "node " << node;
    ASSERT_EQ(a.gradient_rank, b.gradient_rank) << "node " << node;
    if (apply.limit != Limit::none) {
      ASSERT_EQ(fit.limited().components[i], expected.limited().components[node]);
    }
    if (a.status == FitStatus::no_support) continue;
    const double scale = std::max(1.0, static_cast<double>(b.amplification)) /
                         std::max(1e-8, static_cast<double>(b.smallest_pivot));
    const auto row = static_cast<Eigen::Index>(i), serial_row = static_cast<Eigen::Index>(node);
    for (Eigen::Index c = 0; c < fit.values().cols(); ++c)
      ASSERT_NEAR(fit.values()(row, c), expected.values()(serial_row, c), tolerance * scale);
    for (Eigen::Index c = 0; c < fit.gradients().cols(); ++c)
      ASSERT_NEAR(
          fit.gradients()(row, c), expected.gradients()(serial_row, c),
          tolerance * scale / grid.all().spacing[0] * std::max(1.0f, b.gradient_amplification));
  }
}

TYPED_TEST(GridOnRanks, EqualsTheSerialGridWhereMomentsAreNotEnough) {
  constexpr int D = TypeParam::value;
  for (const bool periodic : {false, true}) {
    const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>(),
                               {.periodic = {periodic, false, periodic && D > 2}});
    const auto points = points_in<D>(grid.all(), D == 1 ? 100 : D == 2 ? 1500 : 6000, 0, 21, 0);
    // Steps, which fits overshoot.
    Matrix u = waves(points, 3);
    for (std::size_t p = 0; p < points.size(); ++p)
      u(static_cast<Eigen::Index>(p), 1) = std::sin(20 * points[p][0]) < 0 ? 1 : 0;
    const double h = grid.all().spacing[0];
    const auto expect = [&](const Options& options, const GridApply& apply, const char* where,
                            bool radii = false) {
      expect_serial_by_halos<D>(points, u, grid, options, apply, radii, where);
    };
    expect({.solver = Solver::gram_schmidt}, {.gradients = Derivative::diffuse}, "IMLS");
    expect({}, {.gradients = Derivative::exact}, "exact gradients");
    expect({.degree = 2}, {.limit = Limit::range}, "limited to the range");
    expect({.degree = 2}, {.limit = Limit::relaxed}, "limited near the range");
    expect({.neighbours = Radius{2 * h}, .grow = {.steps = 3}}, {}, "growing");
    expect({}, {}, "radii", true);
    if (D == 3) continue;
    expect({.degree = 3, .neighbours = Radius{4 * h}}, {}, "degree 3");
    expect({.neighbours = Nearest{9}}, {}, "nine nearest");
  }
}

TEST(GridErrors, AParticleBeyondThePieceIsNamedOnAllRanks) {
  if (world().size() == 1) return;  // a piece is all
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<1>());
  Points<1> points;
  if (world().rank() == 0) points = {{0.01}};
  if (world().rank() == 1) {
    const double middle = grid.owned().coordinate(grid.owned().counts[0] / 2, 0);
    points = {{middle}, {0.0}};
  }
  const Matrix u = Matrix::Ones(static_cast<Eigen::Index>(points.size()), 1);
  const std::string said =
      refusal([&] { petsc::reconstruct_on_grid(view_of<1>(points), {field_view(u)}, grid); });
  EXPECT_THAT(said, HasSubstr("rank 1: coordinate x of point 1 of the particles = 0"));
  EXPECT_THAT(said, HasSubstr("must see no nodes beyond this rank's piece"));
  EXPECT_THAT(said, HasSubstr("but sees 0 to 1"));
}

TEST(GridErrors, TooFewGhostsForTheSupport) {
  if (world().size() == 1) return;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<2>(), {.ghosts = 1});
  const auto points = points_in<2>(grid.all(), 4000, 0, 3);
  const auto own =
      mine(points, world(), [&](std::size_t p) { return grid.rank_of(padded(points[p])); });
  const Points<2> own_points = chosen(points, own);
  const Matrix u = Matrix::Ones(static_cast<Eigen::Index>(own.size()), 1);
  const auto fit = [&](const Options& options) {
    return refusal([&] {
      petsc::reconstruct_on_grid(view_of<2>(own_points), {field_view(u)}, grid, options);
    });
  };
  EXPECT_THAT(fit({}), HasSubstr("must see no nodes beyond this rank's piece"));
  EXPECT_EQ(fit({.weight = Weight::linear_b_spline}), "");
}

TEST(GridErrors, BadDataOfOneRankIsToldByAll) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<2>());
  const int last = world().size() - 1;
  Points<2> points;
  if (world().rank() == last)
    for (int i = 0; i < 3; ++i)
      points.push_back({grid.owned().coordinate(2, 0), grid.owned().coordinate(2, 1)});
  Matrix u = Matrix::Ones(static_cast<Eigen::Index>(points.size()), 1);
  const auto fit = [&](const Options& options = {}, const GridApply& apply = {}) {
    return refusal([&] {
      petsc::reconstruct_on_grid(view_of<2>(points), {field_view(u)}, grid, options, apply);
    });
  };
  EXPECT_EQ(fit(), "");
  const std::string rank = "rank " + std::to_string(last) + ": ";
  if (world().rank() == last) u(1, 0) = std::nan("");
  EXPECT_THAT(fit(), HasSubstr(rank));
  EXPECT_THAT(fit(), HasSubstr("component 0 of field 0 at point 1 = nan"));
  if (world().rank() == last) {
    u(1, 0) = 1;
    points[2][1] = std::nan("");
  }
  EXPECT_THAT(fit(), HasSubstr(rank + "coordinate y of point 2 of the particles = nan"));
  if (world().rank() == last) points[2][1] = points[1][1];
  EXPECT_EQ(fit(), "");
  EXPECT_THAT(fit({.degree = 17}), HasSubstr("degree = 17"));
  EXPECT_THAT(fit({.domain = {{0, 0}, {1, 1}, {true, false}}}), HasSubstr("domain = periodic"));
  EXPECT_THAT(fit({.unsupported = Unsupported::nearest}), HasSubstr("unsupported = nearest"));
  EXPECT_THAT(fit({.max_distance = 3}), HasSubstr("max_distance = 3"));
  if (world().rank() == last) u(1, 0) = std::nan("");
  EXPECT_THAT(fit({.degree = 3}), HasSubstr(rank + "component 0 of particle 1 = nan"));
  if (world().rank() == last) u(1, 0) = 1;
  if (world().size() > 1) {
    EXPECT_THAT(fit({.degree = world().rank() == 0 ? 0 : 1}),
                HasSubstr("whether moments are enough = different on some ranks"));
    EXPECT_THAT(fit({}, {.limit = world().rank() == 0 ? Limit::none : Limit::range}),
                HasSubstr("whether moments are enough = different on some ranks"));
  }
}

TEST(GridErrors, BadGridsAreRefusedOnAll) {
  const auto made = [](StructuredGrid<double> grid, const petsc::DistributedGridOptions& options) {
    return refusal([&] { DistributedGrid(PETSC_COMM_WORLD, grid, options); });
  };
  EXPECT_THAT(made(unit_grid<2>(), {.ghosts = -1}), HasSubstr("ghosts = -1"));
  EXPECT_THAT(made(unit_grid<1>(), {.periodic = {false, true}}), HasSubstr("periodic axis = 1"));
  EXPECT_THAT(made(unit_grid<2>(), {.ranks = {world().size() + 1, 1}}),
              HasSubstr("must be the number of ranks"));
  EXPECT_THAT(made(unit_grid<2>(), {.ranks = {world().size(), 0}}),
              HasSubstr("must be the number of ranks"));
  EXPECT_THAT(made(unit_grid<2>(), {.ranks = {-1, 1}}), HasSubstr("must not be negative"));
  EXPECT_THAT(made(unit_grid<1>({3, 1, 1}), {.periodic = {true}, .ghosts = 4}),
              HasSubstr("number of ranks"));
  StructuredGrid<double> bad = unit_grid<2>();
  if (world().rank() == 0) bad.spacing[1] = -1;
  EXPECT_THAT(made(bad, {}), HasSubstr("rank 0: "));
  if (world().size() > 1) {
    EXPECT_THAT(made(unit_grid<1>({9, 1, 1}), {.ghosts = 8}), HasSubstr("number of ranks"));
    EXPECT_THAT(made(unit_grid<1>({9, 1, 1}), {.ghosts = 8, .ranks = {world().size()}}),
                HasSubstr("nodes of one rank along axis x"));
    EXPECT_THAT(made(unit_grid<2>(world().rank() == 0 ? std::array<std::size_t, 3>{22, 18, 1}
                                                      : std::array<std::size_t, 3>{23, 18, 1}),
                     {}),
                HasSubstr("grid, periodic axes, ghosts or ranks along the axes = different"));
  }
}

TEST(GridErrors, SizesThatDoNotFitAreRefusedOnAll) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<2>());
  const std::size_t wrong = world().rank() == 0 ? 1 : 0;
  EXPECT_THAT(refusal([&] { grid.sum(std::vector<double>(grid.piece().size() * 2 + wrong), 2); }),
              HasSubstr("rank 0: numbers of this rank's piece"));
  EXPECT_THAT(refusal([&] { grid.fill(std::vector<double>(grid.owned().size() * 2 + wrong), 2); }),
              HasSubstr("rank 0: numbers of this rank's nodes"));
  EXPECT_THAT(refusal([&] { grid.dm(0); }), HasSubstr("numbers at a node = 0"));
  EXPECT_THAT(refusal([&] { grid.dm(2000000000); }), HasSubstr("PETSc's integers"));
}

}  // namespace
}  // namespace recon::testing
