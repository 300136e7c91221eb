// How many floating-point operations the direct formulas of a fit take. A multiply-add counts as
// two, a division or square root as one.
#pragma once

namespace recon_bench {

constexpr int terms(int dimension, int degree) {
  int n = 1;
  for (int i = 1; i <= dimension; ++i) n = n * (degree + i) / i;
  return n;
}

inline constexpr int weight_flops = 12;  // of the cubic B-spline

// Coefficients of one target with k neighbours, through the moment matrix.
constexpr double construct_flops(int dimension, int degree, int k) {
  const int n = terms(dimension, degree);
  const int per_neighbour = 2 * dimension          // scaled offset
                            + 2 * dimension        // its length
                            + weight_flops         //
                            + (n - 1 - dimension)  // monomials of degree 2 and more
                            + n                    // weighted basis
                            + n * (n + 1)          // lower triangle of the moment matrix
                            + 2 * n;               // coefficient
  const double factorisation = n * n * n / 3.0 + 2.0 * n * n;  // LDLT and one solve
  return k * per_neighbour + factorisation;
}

// Moments of degree 1 of one particle at one node, tensor-product weight given per axis.
constexpr double grid_flops_per_pair(int dimension, int components) {
  const int n = terms(dimension, 1), moments = terms(dimension, 2);
  return (dimension - 1)              // weight
         + (moments - 1 - dimension)  // monomials of degree 2
         + 2 * moments                // sums of the moment matrix
         + n                          // weighted basis
         + 2 * n * components;        // right-hand sides
}

}  // namespace recon_bench
