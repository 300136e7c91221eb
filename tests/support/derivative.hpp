// A smooth field on points, and the check that a gradient is the derivative of the values.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "support/clouds.hpp"

namespace recon::testing {

// prod_d sin(3 x_d + d + 0.5)
template <class Scalar, int D>
std::vector<Scalar> smooth_field(const PointList<Scalar, D>& points) {
  std::vector<Scalar> values;
  for (const auto& x : points) {
    double v = 1;
    for (int d = 0; d < D; ++d) v *= std::sin(3.0 * x[d] + d + 0.5);
    values.push_back(static_cast<Scalar>(v));
  }
  return values;
}

// Column d of `gradient` is the central difference along axis d of evaluate(targets), which gives a
// row for each target, to `tolerance` (1 + |gradient|).
template <int D, class Evaluate>
void expect_derivative(const Eigen::MatrixXd& gradient, const PointList<double, D>& targets,
                       const Evaluate& evaluate, double tolerance, const std::string& where) {
  const double step = 1e-6;
  for (int d = 0; d < D; ++d) {
    auto before = targets, after = targets;
    for (auto& x : before) x[d] -= step;
    for (auto& x : after) x[d] += step;
    const Eigen::MatrixXd difference = (evaluate(after) - evaluate(before)) / (2 * step);
    for (std::size_t t = 0; t < targets.size(); ++t)
      EXPECT_NEAR(gradient(t, d), difference(t, 0), tolerance * (1 + std::abs(gradient(t, d))))
          << where << ", axis " << d << ", target " << t;
  }
}

}  // namespace recon::testing
