// Orders of convergence in Gong (2015), figures 5.3, 5.4, and Tran et al. (2019), figures 4, 5.
//
// An order is the slope of log(error) over log(h), by least squares over all meshes. The error is
// the root mean square over nodes (Tran's eq. 47; Gong's sqrt(h sum) is the same times sqrt(1 + h)
// on the unit interval), on random points over those of 20 clouds. It is taken over sets of nodes:
//     all            every node
//     but the ends   without the two end nodes
//     full support   without the nodes whose support leaves the domain
// A support of radius 2 h leaves the domain at two nodes on each side: leaving out
// one is not enough.
//
// Numbers in the comments are measured. On equally spaced points they differ from the limits 1.5, 2
// and 4 by up to 0.04 because of the coarsest meshes. On random points slopes of single clouds
// scatter by 0.1 at degree 0 and 0.05 at degree 1, those of 20 clouds by about a fourth of that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "recon/points/generate.hpp"
#include "recon/recon.hpp"

namespace recon {
namespace {

using Cloud = std::vector<double>;  // on [0, 1]

Cloud equally_spaced(int cells, int per_cell) {
  Cloud points;
  for (const auto& x : regular_points<double, 1>(static_cast<std::size_t>(cells) * per_cell))
    points.push_back(x[0]);
  return points;
}

// Four random points in each cell.
Cloud random_in_cells(int cells, std::uint64_t seed) {
  RandomNumbers random(seed);
  Cloud points;
  for (int c = 0; c < cells; ++c)
    for (int j = 0; j < 4; ++j) points.push_back((c + random.uniform()) / cells);
  return points;
}

// As many random points anywhere: some cells remain empty.
Cloud random_anywhere(int cells, std::uint64_t seed) {
  Cloud points;
  for (const auto& x : random_points<double, 1>(4 * static_cast<std::size_t>(cells), seed))
    points.push_back(x[0]);
  return points;
}

struct Study {
  std::function<Cloud(int cells, std::uint64_t seed)> cloud{};
  int clouds = 1;
  Options options{};
  int reach = 2;  // the support radius in cells
  std::function<double(double)> u{};
  double lower = 0, upper = 1;
  int coarsest = 10, meshes = 7;  // 11, 21, ..., 641 nodes
};

// Errors of each mesh over the three sets of nodes, and over targets with a full fit that
// amplifies errors in the data by less than 5.
struct Errors {
  std::vector<double> h, all, but_ends, full_support, well_posed;
  std::size_t reduced = 0, no_support = 0;
};

struct MeanSquare {
  double sum = 0;
  int count = 0;
  void add(double error) {
    sum += error * error;
    ++count;
  }
  double root() const { return std::sqrt(sum / count); }
};

Errors measure(const Study& study) {
  Errors errors;
  for (int mesh = 0, cells = study.coarsest; mesh < study.meshes; ++mesh, cells *= 2) {
    const double length = study.upper - study.lower, h = length / cells;
    std::vector<double> nodes;
    for (int i = 0; i <= cells; ++i) nodes.push_back(study.lower + length * i / cells);
    Options options = study.options;
    options.neighbours = Radius{study.reach * h};
    MeanSquare all, but_ends, full_support, well_posed;
    for (int seed = 1; seed <= study.clouds; ++seed) {
      Cloud points = study.cloud(cells, static_cast<std::uint64_t>(seed));
      std::vector<double> data;
      for (double& x : points) data.push_back(study.u(x = study.lower + length * x));
      const auto fit = reconstruct(points_of(points), points_of(nodes), options);
      const Eigen::VectorXd fitted = fit.apply(field_of(data));
      errors.reduced += fit.report().reduced();
      errors.no_support += fit.report().no_support();
      for (int i = 0; i <= cells; ++i) {
        const double error = fitted[i] - study.u(nodes[i]);
        const FitReport& report = fit.report()[i];
        const int border = std::min(i, cells - i);
        all.add(error);
        if (border >= 1) but_ends.add(error);
        if (border >= study.reach) full_support.add(error);
        if (report.status == FitStatus::full && report.amplification < 5) well_posed.add(error);
      }
    }
    errors.h.push_back(h);
    errors.all.push_back(all.root());
    errors.but_ends.push_back(but_ends.root());
    errors.full_support.push_back(full_support.root());
    errors.well_posed.push_back(well_posed.root());
  }
  return errors;
}

double slope(const std::vector<double>& h, const std::vector<double>& errors) {
  const auto n = static_cast<double>(h.size());
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    mean_x += std::log(h[i]) / n;
    mean_y += std::log(errors[i]) / n;
  }
  for (std::size_t i = 0; i < h.size(); ++i) {
    xx += std::pow(std::log(h[i]) - mean_x, 2);
    xy += (std::log(h[i]) - mean_x) * (std::log(errors[i]) - mean_y);
  }
  return xy / xx;
}

struct Orders {
  double all, but_ends, full_support;
};
Orders orders(const Errors& errors) {
  return {slope(errors.h, errors.all), slope(errors.h, errors.but_ends),
          slope(errors.h, errors.full_support)};
}

// ---- Gong: u = sin(pi x) on [0, 1], four points per cell ----------------------------------------

struct SplineOfReach {
  Weight weight;
  int reach;
};
// The weight is not stated. Section 4.3.1 has the hat function of radius h, section 5.3 the
// cubic of radius 2 h.
constexpr SplineOfReach hat{Weight::linear_b_spline, 1}, cubic{Weight::cubic_b_spline, 2};

Study sine(int degree, SplineOfReach spline) {
  return {.cloud = [](int cells, std::uint64_t) { return equally_spaced(cells, 4); },
          .options = {.degree = degree, .weight = spline.weight},
          .reach = spline.reach,
          .u = [](double x) { return std::sin(std::numbers::pi * x); }};
}
Study sine_on_random_points(int degree, SplineOfReach spline) {
  Study study = sine(degree, spline);
  study.cloud = random_in_cells;
  study.clouds = 20;
  return study;
}

// The figure says h^2. It is h^1.5 as soon as the end nodes count: there the error is of order
// h, at two nodes.
TEST(Gong2015Figure53, DegreeZeroOnEquallySpacedPoints) {
  const Orders by_hat = orders(measure(sine(0, hat)));  // 1.491, 2.010, 2.010
  EXPECT_NEAR(by_hat.all, 1.5, 0.03);
  EXPECT_NEAR(by_hat.but_ends, 2, 0.03);
  EXPECT_NEAR(by_hat.full_support, 2, 0.03);
  const Orders by_cubic = orders(measure(sine(0, cubic)));  // 1.491, 1.634, 2.032
  EXPECT_NEAR(by_cubic.all, 1.5, 0.03);
  EXPECT_NEAR(by_cubic.but_ends, 1.63,
              0.03);  // the next nodes are cut off, too: 1.5 on fine meshes
  EXPECT_NEAR(by_cubic.full_support, 2, 0.05);
}

// The figure says h^1, and so it is where the points are random on both sides. With the ends in the
// norm their h^1.5 is the larger part on coarse meshes and the slope lies between.
TEST(Gong2015Figure53, DegreeZeroOnRandomPoints) {
  for (const SplineOfReach spline : {hat, cubic}) {
    const Errors errors = measure(sine_on_random_points(0, spline));
    EXPECT_EQ(errors.no_support, 0);
    const Orders order = orders(errors);
    EXPECT_NEAR(order.all, 1.34, 0.1);           // hat 1.318, cubic 1.355
    EXPECT_NEAR(order.full_support, 1.03, 0.1);  // hat 1.037, cubic 1.052
  }
}

// h^2 over every set of nodes, equally spaced or not: the figure holds.
TEST(Gong2015Figure54, DegreeOneIsSecondOrderEverywhere) {
  for (const SplineOfReach spline : {hat, cubic})
    for (const Study& study : {sine(1, spline), sine_on_random_points(1, spline)}) {
      const Errors errors = measure(study);
      EXPECT_EQ(errors.reduced + errors.no_support, 0);
      const Orders order = orders(errors);  // 1.988 to 2.033
      EXPECT_NEAR(order.all, 2, 0.03);
      EXPECT_NEAR(order.but_ends, 2, 0.03);
      EXPECT_NEAR(order.full_support, 2, 0.05);
    }
}

// Points anywhere, without four in each cell, leave a few nodes with one particle, or with all of
// them far to one side. Those are reported, and are all that is wrong; larger supports where needed
// bring h^2 back.
TEST(Gong2015Figure54, HolesInTheCloudAreReportedAndCanBeFilled) {
  Study study = sine_on_random_points(1, cubic);
  study.cloud = random_anywhere;
  const Errors plain = measure(study);
  EXPECT_EQ(plain.reduced, 3);  // of 25,540 targets
  EXPECT_EQ(plain.no_support, 0);
  EXPECT_NEAR(slope(plain.h, plain.well_posed), 2, 0.03);  // 1.988

  study.options.grow = {.steps = 6, .factor = 1.25};
  const Errors grown = measure(study);
  EXPECT_EQ(grown.reduced + grown.no_support, 0);
  EXPECT_NEAR(slope(grown.h, grown.all), 2, 0.03);  // 1.989

  // On three of the seven meshes these targets raise the error 3.3, 2.4 and 6.2 times.
  int spoilt = 0;
  for (std::size_t mesh = 0; mesh < plain.h.size(); ++mesh) {
    spoilt += plain.all[mesh] > 2 * plain.well_posed[mesh];
    EXPECT_NEAR(grown.all[mesh] / plain.well_posed[mesh], 1, 0.02);
  }
  EXPECT_EQ(spoilt, 3);
}

// ---- Tran et al.: f = sin x on [1, 4], 20 cells and finer, two points per cell ------------------

Study sine_on_one_to_four(int degree, SplineOfReach spline, Solver solver = Solver::gram_schmidt) {
  return {.cloud = [](int cells, std::uint64_t) { return equally_spaced(cells, 2); },
          .options = {.degree = degree, .weight = spline.weight, .solver = solver},
          .reach = spline.reach,
          .u = [](double x) { return std::sin(x); },
          .lower = 1,
          .upper = 4,
          .coarsest = 20,
          .meshes = 6};
}

TEST(Tran2019Figure4, TwentyCellsAreNotExact) {
  const Errors quadratic = measure(sine_on_one_to_four(2, cubic));
  EXPECT_NEAR(quadratic.all[0], 3.167e-5, 0.01e-5);
  const Errors mpm = measure(sine_on_one_to_four(0, hat));
  EXPECT_NEAR(mpm.all[0], 1.053e-2, 0.01e-2);
}

TEST(Tran2019Figure5, OrdersOfConvergence) {
  const Orders quadratic = orders(measure(sine_on_one_to_four(2, cubic)));  // 3.498, 3.521, 3.993
  EXPECT_NEAR(quadratic.all, 3.5, 0.02);
  EXPECT_NEAR(quadratic.but_ends, 3.52, 0.05);
  EXPECT_NEAR(quadratic.full_support, 4, 0.02);
  const Orders linear = orders(measure(sine_on_one_to_four(1, cubic)));  // 1.993, 1.992, 1.993
  EXPECT_NEAR(linear.all, 2, 0.03);
  EXPECT_NEAR(linear.full_support, 2, 0.03);
  const Orders mpm = orders(measure(sine_on_one_to_four(0, hat)));  // 1.497, 1.998, 1.998
  EXPECT_NEAR(mpm.all, 1.5, 0.02);
  EXPECT_NEAR(mpm.full_support, 2, 0.03);
}

// "IMLS maintains the high convergence rate": it is the same fit, to rounding, by whatever solver.
TEST(Tran2019Figure5, ImprovedMlsIsMls) {
  for (int cells = 20; cells <= 640; cells *= 2) {
    Cloud points = equally_spaced(cells, 2), nodes, data;
    for (double& x : points) data.push_back(std::sin(x = 1 + 3 * x));
    for (int i = 0; i <= cells; ++i) nodes.push_back(1 + 3.0 * i / cells);
    const auto fit = [&](Solver solver) {
      return reconstruct(points_of(points), points_of(nodes),
                         {.degree = 2, .neighbours = Radius{6.0 / cells}, .solver = solver});
    };
    const auto imls = fit(Solver::gram_schmidt);
    const Eigen::VectorXd expected = imls.apply(field_of(data));
    for (const Solver solver : {Solver::moment_matrix, Solver::qr, Solver::svd}) {
      const auto mls = fit(solver);
      EXPECT_EQ(mls.report().summary().handed_over, 0);
      const Eigen::VectorXd difference = mls.apply(field_of(data)) - expected;
      // Measured: 6e-15 with the moment matrix (smallest pivot 0.04), 1e-15 with the others.
      EXPECT_LT(difference.cwiseAbs().maxCoeff(), solver == Solver::moment_matrix ? 2e-14 : 4e-15)
          << name_of(solver) << ", " << cells << " cells";
    }
  }
}

}  // namespace
}  // namespace recon
