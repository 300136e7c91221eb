#include "recon/basis/monomials.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace recon {
namespace {

template <int D, int R>
void check_monomials() {
  using M = Monomials<D, R>;
  EXPECT_EQ(M::size, monomial_count(D, R));
  EXPECT_EQ(M::begin(0), 0);
  EXPECT_EQ(M::begin(R + 1), M::size);
  const std::array<double, 3> point{0.7, -1.3, 0.4};
  std::array<double, D> xi;
  for (int d = 0; d < D; ++d) xi[d] = point[d];
  std::array<double, M::size> values, zero;
  M::evaluate(xi, values.data());
  M::evaluate(std::array<double, D>{}, zero.data());
  for (int j = 0; j < M::size; ++j) {
    const auto& e = M::exponents[j];
    const int degree = std::accumulate(e.begin(), e.end(), 0);
    EXPECT_GE(j, M::begin(degree));  // graded
    EXPECT_LT(j, M::begin(degree + 1));
    EXPECT_EQ(M::find(e), j);  // no monomial twice
    double expected = 1;
    for (int d = 0; d < D; ++d) expected *= std::pow(xi[d], e[d]);
    EXPECT_NEAR(values[j], expected, 1e-13 * std::abs(expected));
    EXPECT_EQ(zero[j], j == 0 ? 1 : 0);
    EXPECT_EQ(zero[j], M::origin(j, 0));
  }
}

TEST(Monomials, EveryDimensionAndDegree) {
  check_monomials<1, 0>();
  check_monomials<1, 6>();
  check_monomials<2, 1>();
  check_monomials<2, 4>();
  check_monomials<2, 7>();
  check_monomials<3, 0>();
  check_monomials<3, 4>();
  check_monomials<3, 8>();
}

// The order that the Taylor coefficients of local fits rely on: 1 | x y z | xx xy xz yy yz zz.
TEST(Monomials, OrderWithinDegreeIsLexicographic) {
  using M = Monomials<3, 2>;
  const std::array<std::array<std::uint8_t, 3>, 10> expected{{{0, 0, 0},
                                                              {1, 0, 0},
                                                              {0, 1, 0},
                                                              {0, 0, 1},
                                                              {2, 0, 0},
                                                              {1, 1, 0},
                                                              {1, 0, 1},
                                                              {0, 2, 0},
                                                              {0, 1, 1},
                                                              {0, 0, 2}}};
  EXPECT_EQ(M::exponents, expected);
}

}  // namespace
}  // namespace recon
