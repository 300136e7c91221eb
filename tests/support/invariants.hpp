// What every reconstruction must satisfy, as one-line checks on the rows of its operator.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"

namespace recon::testing {

// The sum of phi_p xi_p^alpha over a row, with its rounding scale sum |phi_p xi_p^alpha|,
// in long double.
struct RowSum {
  long double value = 0, scale = 0;
};

template <class Scalar, int D>
RowSum row_moment(const BasicReconstruction<Scalar>& fit, const PointList<Scalar, D>& points,
                  const std::array<Scalar, D>& target, std::size_t t,
                  const std::array<std::uint8_t, D>& exponents) {
  const auto row = fit.values().row(t);
  const long double rho = fit.support(t);
  RowSum sum;
  for (std::size_t e = 0; e < row.size(); ++e) {
    long double term = row.value(e);
    for (int d = 0; d < D; ++d)
      for (int i = 0; i < exponents[d]; ++i)
        term *= (static_cast<long double>(points[row.particle(e)][d]) -
                 static_cast<long double>(target[d])) /
                rho;
    sum.value += term;
    sum.scale += std::abs(term);
  }
  return sum;
}

// All numbers of an operator, row by row in the order of the targets.
template <class Scalar>
std::vector<Scalar> numbers_of(const CsrOperator<Scalar>& op) {
  std::vector<Scalar> numbers;
  for (std::size_t t = 0; t < op.rows(); ++t) {
    const auto row = op.row(t);
    for (std::size_t i = 0; i < row.size(); ++i)
      for (int b = 0; b < op.blocks(); ++b) numbers.push_back(row.value(i, b));
  }
  return numbers;
}

// Rounding that a fit with this report may show: the precision, times terms, times the
// amplification of the fit and, for the moment matrix, 1 / smallest_pivot: a lower bound of its
// condition number, which errors do not exceed in practice.
template <class Scalar>
double rounding(const FitReport& report) {
  const double loss =
      report.solver == Solver::moment_matrix ? 1 / static_cast<double>(report.smallest_pivot) : 1;
  return 8.0 * std::numeric_limits<Scalar>::epsilon() * (4 + report.rank) *
         std::max(1.0f, report.amplification) * loss;
}

// Partition of unity and reproduction of every monomial up to the reported degree, at every
// target; the report must agree with itself; amplification must bound sum |phi|. `where` is
// printed on failure.
template <class Scalar, int D>
void expect_reproduction(const BasicReconstruction<Scalar>& fit, const PointList<Scalar, D>& points,
                         const PointList<Scalar, D>& targets, int asked, const std::string& where) {
  using Terms = Monomials<D, 4>;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const FitReport& report = fit.report()[t];
    const std::string at = where + ", target " + std::to_string(t);
    if (report.status == FitStatus::no_support) {
      EXPECT_EQ(report.rank, 0) << at;
      EXPECT_EQ(report.degree, -1) << at;
      const auto row = fit.values().row(t);
      for (std::size_t e = 0; e < row.size(); ++e) EXPECT_EQ(row.value(e), Scalar(0)) << at;
      continue;
    }
    ASSERT_GE(report.degree, 0) << at;
    ASSERT_LE(report.rank, report.neighbours) << at;
    EXPECT_EQ(report.status == FitStatus::full, report.degree == asked) << at;
    const double tolerance = rounding<Scalar>(report);
    for (int j = 0; j < Terms::begin(report.degree + 1); ++j) {
      const RowSum sum = row_moment<Scalar, D>(fit, points, targets[t], t, Terms::exponents[j]);
      EXPECT_LE(std::abs(sum.value - (j == 0 ? 1 : 0)), tolerance)
          << at << ", monomial " << j << " of degree " << int(report.degree) << ", smallest_pivot "
          << report.smallest_pivot << ", amplification " << report.amplification;
      if (j == 0) {
        EXPECT_LE(sum.scale, report.amplification * (1 + 1e-6 + tolerance) + tolerance) << at;
      }
    }
  }
}

// Targets that provoke: among the particles, on particles, beside them, and far away.
template <class Scalar, int D>
PointList<Scalar, D> hostile_targets(const PointList<Scalar, D>& points) {
  PointList<Scalar, D> targets = random_points<Scalar, D>(12, 99);
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 6) {
    targets.push_back(points[i]);
    auto beside = points[i];
    for (Scalar& c : beside) c += static_cast<Scalar>(1e-3);
    targets.push_back(beside);
    beside[D - 1] += static_cast<Scalar>(0.15);
    targets.push_back(beside);
  }
  std::array<Scalar, D> centre, corner, outside;
  centre.fill(Scalar(0.5));
  corner.fill(Scalar(0));
  outside.fill(Scalar(1.1));
  targets.insert(targets.end(), {centre, corner, outside});
  return targets;
}

}  // namespace recon::testing
