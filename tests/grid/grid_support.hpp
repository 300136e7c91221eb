// What the tests of the room share: data on clouds, grids over them, and the comparison
// with reconstruct().
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "recon/grid/grid_moments.hpp"
#include "recon/recon.hpp"
#include "support/clouds.hpp"
#include "support/typed.hpp"

namespace recon::testing {

template <class Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

// Smooth data of the order of one.
template <class Scalar, std::size_t D>
Matrix<Scalar> wave(const std::vector<std::array<Scalar, D>>& points, int components) {
  Matrix<Scalar> u(points.size(), components);
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int c = 0; c < components; ++c) {
      Scalar phase = static_cast<Scalar>(c);
      for (std::size_t d = 0; d < D; ++d)
        phase += static_cast<Scalar>(2 + d + c % 3) * points[p][d];
      u(p, c) = std::sin(phase);
    }
  return u;
}

// A grid over the unit cube with another spacing along each axis, reaching beyond it.
template <class Scalar, int D>
StructuredGrid<Scalar> uneven_grid() {
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  const std::array<Scalar, 3> spacing =
      D == 1   ? std::array<Scalar, 3>{Scalar(0.09), 1, 1}
      : D == 2 ? std::array<Scalar, 3>{Scalar(0.15), Scalar(0.2), 1}
               : std::array<Scalar, 3>{Scalar(0.25), Scalar(0.3), Scalar(0.35)};
  for (int d = 0; d < D; ++d) {
    grid.spacing[d] = spacing[d];
    grid.origin[d] = Scalar(-0.4);
    grid.counts[d] = static_cast<std::size_t>(Scalar(1.8) / spacing[d]) + 2;
  }
  return grid;
}

// The same choices for lists, spelled out: supports of so many spacings, where no rule says other
// ones, as lengths along the axes.
template <class Scalar>
Options equivalent(const Options& options, const StructuredGrid<Scalar>& grid, double spacings) {
  Options same = options;
  same.form = options.form.value_or(WeightForm::tensor_product);
  same.solver = options.solver.value_or(Solver::moment_matrix);
  same.neighbours = Radius{1};
  for (int d = 0; d < grid.dimension; ++d)
    same.stretch[d] *= options.neighbours ? std::get<Radius>(*options.neighbours).radius
                                          : spacings * static_cast<double>(grid.spacing[d]);
  return same;
}

// How far a value may be off: rounding of sums and solve, and that of the coordinates.
template <class Scalar>
double allowed(const FitReport& report) {
  const double loss =
      report.status == FitStatus::no_support ? 1 : 1 / static_cast<double>(report.smallest_pivot);
  return 1000 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) *
         std::max(1.0, static_cast<double>(report.amplification)) * std::min(loss, 1e8);
}

// Values and reports are those of reconstruct(). Particles whose weight is next to nothing may
// count as neighbours there and not here, or the other way round: what is negligible is measured by
// the largest weight at the node there, by w(0) here.
template <class Scalar, std::size_t D>
void expect_equal(const BasicGridReconstruction<Scalar>& fit,
                  const std::vector<std::array<Scalar, D>>& points, const Matrix<Scalar>& u,
                  const StructuredGrid<Scalar>& grid, const Options& same,
                  const std::string& where) {
  const BasicReconstruction<Scalar> expected(points_of(points), grid.nodes().view(), same);
  const Matrix<Scalar> values = expected.apply(field_of(u));
  ASSERT_EQ(fit.values().rows(), values.rows()) << where;
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const FitReport& report = fit.report()[i];
    const FitReport& other = expected.report()[i];
    const std::string at = where + ", node " + std::to_string(i);
    if (report.neighbours != other.neighbours) {
      std::uint32_t clear = 0, any = 0;
      for (const auto& x : points) {
        const auto index = grid.index(static_cast<std::size_t>(i));
        double w = 1, zero = 0, most = 0, square = 0, farthest = 0;
        same.weight.evaluate(&zero, &most, nullptr, 1);
        for (std::size_t d = 0; d < D; ++d) {
          const double node = static_cast<double>(grid.coordinate(index[d], static_cast<int>(d)));
          double q = std::abs((static_cast<double>(x[d]) - node) / same.stretch[d]), factor = 0;
          same.weight.evaluate(&q, &factor, nullptr, 1);
          w *= factor / most;
          square += q * q;
          farthest = std::max(farthest, q);
        }
        if (same.form == WeightForm::radial) {
          farthest = std::sqrt(square);
          same.weight.evaluate(&farthest, &w, nullptr, 1);
          w /= most;
        }
        clear +=
            w > 1e3 * std::pow(static_cast<double>(std::numeric_limits<Scalar>::epsilon()), 1.5);
        any += farthest < 1 + 1e-5;
      }
      EXPECT_GE(report.neighbours, clear) << at;
      EXPECT_LE(report.neighbours, any) << at;
      if (clear == 0) continue;  // all of them at the very border of the support
    }
    EXPECT_EQ(report.status, other.status) << at;
    EXPECT_EQ(report.degree, other.degree) << at;
    if (report.solver == other.solver) {
      EXPECT_NEAR(report.smallest_pivot, other.smallest_pivot, 1e-3 * other.smallest_pivot + 1e-3)
          << at;
      EXPECT_NEAR(report.amplification, other.amplification,
                  1e-2 * other.amplification + allowed<Scalar>(other))
          << at;
    }
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      if (report.status == FitStatus::no_support) {
        EXPECT_TRUE(std::isnan(fit.values()(i, c))) << at;
      } else {
        EXPECT_NEAR(fit.values()(i, c), values(i, c), allowed<Scalar>(report))
            << at << ", smallest_pivot " << report.smallest_pivot << ", amplification "
            << report.amplification;
      }
    }
  }
}

}  // namespace recon::testing
