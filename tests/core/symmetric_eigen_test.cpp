// Eigenvalues and directions of small symmetric matrices.
#include "core/symmetric_eigen.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace recon::testing {
namespace {

// A d = lambda d for directions of length one at right angles, in ascending order, to a few
// roundings of the matrix's norm: also of multiples of the identity, of rank one and in other units.
TEST(SymmetricEigen, GivesDirectionsThatTheMatrixStretches) {
  constexpr double few = 16 * 2.220446049250313e-16;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int D = 1; D <= 3; ++D)
    for (int n = 0; n < 300; ++n) {
      const double unit = std::pow(10.0, n % 13 - 6);
      double along[3] = {normal(random), normal(random), normal(random)}, a[9] = {}, norm = 0;
      for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) {
          const double entry = n % 3 == 0   ? normal(random)
                               : n % 3 == 1 ? (i == j)
                                            : along[i] * along[j];
          a[i * D + j] = a[j * D + i] = unit * entry;
        }
      for (int k = 0; k < D * D; ++k) norm += a[k] * a[k];
      norm = std::sqrt(norm);
      const detail::SymmetricEigen found = detail::symmetric_eigen(D, a);
      for (int d = 0; d < D; ++d) {
        if (d > 0) {
          EXPECT_LE(found.values[d - 1], found.values[d]);
        }
        for (int e = 0; e <= d; ++e) {
          double product = 0;
          for (int i = 0; i < D; ++i) product += found.direction[d][i] * found.direction[e][i];
          EXPECT_NEAR(product, d == e, few);
        }
        for (int i = 0; i < D; ++i) {
          double row = -found.values[d] * found.direction[d][i];
          for (int j = 0; j < D; ++j) row += a[i * D + j] * found.direction[d][j];
          EXPECT_NEAR(row, 0, few * norm);
        }
      }
    }
}

}  // namespace
}  // namespace recon::testing
