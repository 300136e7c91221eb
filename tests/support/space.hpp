// Random numbers and deformations, and types for tests in all dimensions.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <type_traits>

#include "recon/transfer/cartesian_grid.hpp"

namespace recon::test {

inline double uniform(std::mt19937& random, double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(random);
}

template <int D>
SpaceVector<D> random_point(std::mt19937& random, double lower = 0, double upper = 1) {
  SpaceVector<D> x;
  for (int d = 0; d < D; ++d) x[d] = uniform(random, lower, upper);
  return x;
}

template <int D>
SpaceMatrix<D> random_deformation(std::mt19937& random, double size) {
  SpaceMatrix<D> F = SpaceMatrix<D>::Identity();
  for (int i = 0; i < D; ++i)
    for (int j = 0; j < D; ++j) F(i, j) += uniform(random, -size, size);
  return F;
}

// A grid over the unit box.
template <int D>
CartesianGrid<D> unit_grid(int cells) {
  return CartesianGrid<D>(SpaceVector<D>::Zero(), SpaceVector<D>::Ones(), 1.0 / cells);
}

// Types int<1>, int<2>, int<3> for typed tests.
template <int D>
using Dimension = std::integral_constant<int, D>;
using AllDimensions = ::testing::Types<Dimension<1>, Dimension<2>, Dimension<3>>;

}  // namespace recon::test
