// Graded monomials: the polynomial basis of every fit.
//
// For a target x and support radius rho the basis is written in xi = (x_p - x) / rho, which has no
// unit, so that all terms are of the order of one and nothing depends on where the origin is. The
// terms are ordered by degree, and within a degree lexicographically; in 3-D
//     1 | x y z | xx xy xz yy yz zz | ...
// Degree 0 reproduces constants (Shepard), degree 1 linear fields, and so on; there are
// C(degree + D, D) terms. At the target xi = 0. So the coefficient of 1 is the value of the fit
// there, those of x, y, z divided by rho are its gradient, and so on: they are the Taylor
// coefficients of the fit.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "recon/core/unroll.hpp"

// A constexpr array that is indexed while the program runs. Device code cannot see the host's, but
// has copies.
#if defined(__CUDA_ARCH__)
#define RECON_TABLE(table)       \
  ([] {                          \
    constexpr auto copy = table; \
    return copy;                 \
  }())
#else
#define RECON_TABLE(table) (table)
#endif

namespace recon {

namespace detail {

// Loops over more terms than these are left to the compiler.
inline constexpr int most_unrolled = 35;

constexpr int term_count(int dimension, int degree) {
  if (degree < 0) return 0;
  long count = 1;
  for (int i = 1; i <= dimension; ++i) count = count * (degree + i) / i;
  return static_cast<int>(count);
}

}  // namespace detail

// The number of monomials of degree at most `degree` in so many variables, C(degree + dim, dim).
constexpr int monomial_count(int dimension, int degree) {
  return detail::term_count(dimension, degree);
}

template <int D, int R>
struct Monomials {
  static_assert(D >= 1 && D <= 3 && R >= 0);
  static constexpr int dimension = D;
  static constexpr int degree = R;
  static constexpr int size = detail::term_count(D, R);

  // The first term of degree k; begin(R + 1) == size.
  static constexpr int begin(int k) { return detail::term_count(D, k - 1); }

  using Exponents = std::array<std::uint8_t, D>;
  static constexpr std::array<Exponents, size> exponents = [] {
    std::array<Exponents, size> all{};
    int j = 0;
    for (int k = 0; k <= R; ++k) {
      // Exponents that sum to k, the first one falling from k to 0 and so on: lexicographic order.
      Exponents e{};
      e[0] = static_cast<std::uint8_t>(k);
      for (;;) {
        all[j++] = e;
        int d = D - 2;  // the last axis from which a later one can take
        while (d >= 0 && e[d] == 0) --d;
        if (d < 0) break;
        std::uint8_t rest = 0;
        for (int i = d + 1; i < D; ++i) {
          rest = static_cast<std::uint8_t>(rest + e[i]);
          e[i] = 0;
        }
        --e[d];
        e[d + 1] = static_cast<std::uint8_t>(rest + 1);
      }
    }
    return all;
  }();

  // The place of the monomial with these exponents among the terms, or -1 if its degree is above
  // R. Before it come all terms of lower degree, and those of its own degree with higher exponents
  // of earlier axes.
  static constexpr int find(const Exponents& wanted) {
    int place = 0, left = 0;
    for (int d = D - 1; d >= 0; --d) {
      left += wanted[d];
      place += detail::term_count(D - d, left - 1);
    }
    return left <= R ? place : -1;
  }

  // exponents[j], in device code too.
  static constexpr Exponents exponents_of(int j) { return RECON_TABLE(exponents)[j]; }

  // values[j] = factor * xi^exponents[j] for all terms, each by one product with an earlier term.
  template <class T>
  RECON_INLINE static constexpr void evaluate(const std::array<T, D>& xi, T* values,
                                              const T& factor = T(1)) {
    values[0] = factor;
    if constexpr (size <= detail::most_unrolled) {
      detail::unroll<size - 1>([&](auto i) RECON_INLINE_LAMBDA {
        constexpr Step step = steps[i + 1];
        values[i + 1] = values[step.parent] * xi[step.axis];
      });
    } else {
      for (int j = 1; j < size; ++j) {
        const Step step = RECON_TABLE(steps)[j];
        values[j] = values[step.parent] * xi[step.axis];
      }
    }
  }

  // The coefficients of prod_d (forms[d] . xi)^e_d, a product of linear forms, of degree at most R.
  template <class T>
  static constexpr std::array<T, size> of_forms(const Exponents& e,
                                                const std::array<std::array<T, D>, D>& forms) {
    std::array<T, size> product{};
    product[0] = T(1);
    int k = 0;
    for (int d = 0; d < D; ++d)
      for (int i = 0; i < e[d]; ++i, ++k)
        for (int j = begin(k); j < begin(k + 1); ++j) {
          for (int axis = 0; axis < D; ++axis) {
            Exponents up = exponents_of(j);
            ++up[axis];
            product[find(up)] += product[j] * forms[d][axis];
          }
          product[j] = T(0);
        }
    return product;
  }

  // The Taylor coefficient of term j at xi = 0 with number a, where the coefficients are numbered
  // as the terms of degree <= 2.
  static constexpr double origin(int j, int a) { return j == a ? 1.0 : 0.0; }

 private:
  struct Step {
    int parent = 0, axis = 0;
  };
  static constexpr std::array<Step, size> steps = [] {
    std::array<Step, size> all{};
    for (int j = 1; j < size; ++j) {
      Exponents e = exponents[j];
      int d = 0;
      while (e[d] == 0) ++d;
      --e[d];
      all[j] = {find(e), d};
    }
    return all;
  }();
};

namespace detail {

template <class B>
inline constexpr bool is_monomials = false;
template <int D, int R>
inline constexpr bool is_monomials<Monomials<D, R>> = true;

}  // namespace detail

// A basis of your own. Terms come in blocks of rising degree: begin(k) is the first of block k, and
// the first block is the constant 1 alone. evaluate() gives all terms at xi; origin() gives their
// Taylor coefficients at xi = 0 up to order 2, numbered 1 | x y z | xx xy ..., where that of xx is
// half the second derivative and that of xy the mixed derivative.
template <class B>
concept Basis = requires(const std::array<double, B::dimension>& xi, double* values) {
  { B::dimension } -> std::convertible_to<int>;
  { B::degree } -> std::convertible_to<int>;
  { B::size } -> std::convertible_to<int>;
  { B::begin(0) } -> std::convertible_to<int>;
  { B::origin(0, 0) } -> std::convertible_to<double>;
  B::evaluate(xi, values);
};

static_assert(Basis<Monomials<3, 2>>);
static_assert(Monomials<3, 4>::size == 35 && Monomials<2, 2>::begin(2) == 3);

}  // namespace recon
