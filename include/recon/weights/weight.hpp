// Weight functions: how much a particle counts at a distance.
//
// A weight is a function w(q) of q = |x - x_p| / rho, with rho the support radius (a length) and q
// without unit; w > 0 for q < 1 and w = 0 for q >= 1. It multiplies the squared residual:
//     minimise  sum_p w(q_p) (p(x_p) - u_p)^2  over the polynomials p.
// Its scale does not matter to a fit. Radial weights use one q; a tensor-product weight is the
// product of one factor w(|x_d - x_pd| / rho) per axis, with the support a cube.
//
// Written here, each a small struct with operator() and derivative() = dw/dq for any arithmetic
// type, packs (core/pack.hpp) among them:
//   BSpline<P>, P = 1..5      centred cardinal B-splines (Schoenberg 1946). On a grid of spacing h
//                             the cardinal spline has rho = (P + 1) h / 2: linear h, quadratic
//                             1.5 h, cubic 2 h. P = 2 is Gong (2015) eq. 5.2, P = 3 is Tran et al.
//                             (2019) eq. 10
//   Wendland<K>, K = 0,2,4,6  C^K functions, positive definite in up to three dimensions
//                             (Wendland 1995)
//   Gaussian                  exp(-(q/c)^2), lowered so that it is continuous at q = 1
//                             (Belytschko, Lu, Gu 1994), c its width in support radii; it tends to
//                             1 - q^2 for c >> 1
//   InverseDistance           (1 - q)^2 / (q^2 + e^2), after Franke and Little (Franke 1982): for
//                             small e nearly interpolating
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "recon/core/error.hpp"
#include "recon/core/instruction_set.hpp"
#include "recon/core/lanes.hpp"
#include "recon/core/unroll.hpp"

namespace recon {

// A weight of your own: any copyable type with these two functions. They are called with 0 <= q < 1
// only, possibly concurrently, and must return finite numbers, w(q) >= 0; for others
// InvalidArgument is thrown, with q and w, by the call that asked for the weight. A weight with
// parameters may have a member validate() that throws InvalidArgument for values that are not
// allowed; it is called when the weight is chosen. T is the scalar that a fit is computed in.
template <class W, class T = double>
concept RadialWeight = std::copy_constructible<W> && requires(const W& w, T q) {
  { w(q) } -> std::convertible_to<T>;             // q = |x - x_p| / rho, no unit
  { w.derivative(q) } -> std::convertible_to<T>;  // dw/dq
};

namespace detail {

template <int N, class T>
constexpr T power(T x) {
  if constexpr (N == 0) {
    return T(1);
  } else if constexpr (N % 2 == 0) {
    const T half = power<N / 2>(x);
    return half * half;
  } else {
    return x * power<N - 1>(x);
  }
}

constexpr double binomial(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

// exp(x) - 1 where constants are evaluated: Taylor's series at x / 2^k, doubled k times.
constexpr double constant_expm1(double x) {
  if (x < -750) return -1;
  int doublings = 0;
  for (; x < -0.25 || x > 0.25; ++doublings) x *= 0.5;
  double term = x, sum = x;
  for (int n = 2; n < 16; ++n) {
    term *= x / n;
    sum += term;
  }
  for (; doublings > 0; --doublings) sum *= sum + 2;
  return sum;
}

// expm1 and exp, found by the argument's type; for built-in numbers in constant expressions too.
template <class T>
RECON_INLINE constexpr T expm1_of(const T& x) {
  if constexpr (std::is_floating_point_v<T>)
    if (__builtin_is_constant_evaluated()) return T(constant_expm1(double(x)));
  using std::expm1;
  return T(expm1(x));
}
template <class T>
RECON_INLINE constexpr T exp_of(const T& x) {
  if constexpr (std::is_floating_point_v<T>)
    if (__builtin_is_constant_evaluated()) return T(constant_expm1(double(x)) + 1);
  using std::exp;
  return T(exp(x));
}

// Checks what a weight returned; whatever calls a weight for one q after the other uses it.
template <class Scalar>
constexpr void require_weight(const Scalar& q, const Scalar& w) {
  if (!(w >= Scalar(0)) || !is_finite(w)) [[unlikely]]
    RECON_REFUSE(
        throw_invalid("weight w(q) at q = " + to_text(q), w, "must be finite and not negative"));
}
template <class Scalar>
constexpr void require_slope(const Scalar& q, const Scalar& slope) {
  if (!is_finite(slope)) [[unlikely]]
    RECON_REFUSE(throw_invalid("derivative w'(q) of the weight at q = " + to_text(q), slope,
                               "must be finite"));
}

// Calls validate() of a weight that has one.
template <class W>
constexpr void validate_weight(const W& weight) {
  if constexpr (requires { weight.validate(); }) weight.validate();
}

template <int N>
inline constexpr double factorial = [] {
  double value = 1;
  for (int i = 2; i <= N; ++i) value *= i;
  return value;
}();

}  // namespace detail

// With s = (1 - q) (P + 1) / 2, the distance to the end of the support in units of h:
//     w = 1/P! sum_k (-1)^k C(P + 1, k) max(s - k, 0)^P ,  k <= (P + 1) / 2.
// Free of branches, and exact to the last digits where w becomes small.
template <int P>
struct BSpline {
  static_assert(P >= 1 && P <= 5);
  static constexpr int degree = P;

  template <class T>
  constexpr T operator()(T q) const {
    return sum<P>((T(1) - q) * detail::constant<T>((P + 1) / 2.0)) *
           detail::constant<T>(1 / detail::factorial<P>);
  }
  template <class T>
  constexpr T derivative(T q) const {
    return sum<P - 1>((T(1) - q) * detail::constant<T>((P + 1) / 2.0)) *
           detail::constant<T>(-(P + 1) / 2.0 / detail::factorial<P - 1>);
  }

 private:
  // The alternating sum of the N-th powers of the distances to the knots; q >= 1 gives
  // s <= 0 and so 0.
  template <int N, class T>
  static constexpr T sum(T s) {
    using std::max;
    T total = T(0);
    for (int k = 0; 2 * k < P + 1; ++k) {
      const T coefficient = detail::constant<T>((k % 2 ? -1 : 1) * detail::binomial(P + 1, k));
      if constexpr (N == 0) {
        total = detail::select(s - T(k) > T(0), T(total + coefficient), total);
      } else {
        total = total + coefficient * detail::power<N>(T(max(T(s - T(k)), T(0))));
      }
    }
    return total;
  }
};

template <int K>
struct Wendland {
  static_assert(K == 0 || K == 2 || K == 4 || K == 6);

  template <class T>
  constexpr T operator()(T q) const {
    using std::max;
    const T r = max(T(T(1) - q), T(0));
    if constexpr (K == 0) return r * r;
    if constexpr (K == 2) return detail::power<4>(r) * (T(4) * q + T(1));
    if constexpr (K == 4)
      return detail::power<6>(r) * ((T(35) * q + T(18)) * q + T(3)) * detail::constant<T>(1.0 / 3);
    if constexpr (K == 6)
      return detail::power<8>(r) * (((T(32) * q + T(25)) * q + T(8)) * q + T(1));
  }
  template <class T>
  constexpr T derivative(T q) const {
    using std::max;
    const T r = max(T(T(1) - q), T(0));
    if constexpr (K == 0) return T(-2) * r;
    if constexpr (K == 2) return T(-20) * q * detail::power<3>(r);
    if constexpr (K == 4)
      return detail::constant<T>(-56.0 / 3) * q * (T(5) * q + T(1)) * detail::power<5>(r);
    if constexpr (K == 6) return T(-22) * q * ((T(16) * q + T(7)) * q + T(1)) * detail::power<7>(r);
  }
};

//     w = (exp(-a q^2) - exp(-a)) / (1 - exp(-a)) ,  a = 1 / c^2 ,
// as a product: no difference of nearly equal numbers, whether c is small or large.
struct Gaussian {
  double shape = 0.4;  // c: the width as a fraction of the support; positive, finite

  template <class T>
  constexpr T operator()(T q) const {
    const double a = steepness();
    const T rest = (T(1) - q) * (T(1) + q);
    return detail::select(q < T(1),
                          T(detail::exp_of(T(q * q * detail::constant<T>(-a))) *
                            detail::expm1_of(T(rest * detail::constant<T>(-a))) *
                            detail::constant<T>(1 / detail::expm1_of(-a))),
                          T(0));
  }
  template <class T>
  constexpr T derivative(T q) const {
    const double a = steepness();
    const T slope = q * detail::constant<T>(2 * a / detail::expm1_of(-a));
    return detail::select(q < T(1), T(slope * detail::exp_of(T(q * q * detail::constant<T>(-a)))),
                          T(0));
  }
  constexpr void validate() const {
    detail::require(detail::is_finite(shape) && shape > 0, "shape of the weight Gaussian", shape,
                    "must be positive and finite: its width as a fraction of the support");
  }

 private:
  // Beyond these values of c, w equals its limits in all digits: 1 - q^2, and a spike at q = 0.
  RECON_INLINE constexpr double steepness() const {
    const double a = 1 / (shape * shape);
    return a < 1e-20 ? 1e-20 : a > 1e20 ? 1e20 : a;
  }
};

struct InverseDistance {
  double softening =
      1e-2;  // e: keeps w finite where a particle sits on the target; positive, finite

  template <class T>
  constexpr T operator()(T q) const {
    using std::max;
    const T r = max(T(T(1) - q), T(0));
    return r * r / (q * q + detail::constant<T>(softening * softening));
  }
  template <class T>
  constexpr T derivative(T q) const {
    using std::max;
    const T r = max(T(T(1) - q), T(0));
    const T d = q * q + detail::constant<T>(softening * softening);
    return (T(-2) * r * d - T(2) * q * r * r) / (d * d);
  }
  constexpr void validate() const {
    detail::require(detail::is_finite(softening) && softening > 0,
                    "softening of the weight InverseDistance", softening,
                    "must be positive and finite: the distance, as a fraction of the support, "
                    "within which the weight stays level");
  }
};

static_assert(RadialWeight<BSpline<3>> && RadialWeight<Wendland<2>> && RadialWeight<Gaussian> &&
              RadialWeight<InverseDistance>);

// The weights by name, for a choice made while the program runs.
enum class Weight {
  linear_b_spline,
  quadratic_b_spline,
  cubic_b_spline,
  quartic_b_spline,
  quintic_b_spline,
  wendland_c0,
  wendland_c2,
  wendland_c4,
  wendland_c6,
  gaussian,
  inverse_distance
};

enum class WeightForm { radial, tensor_product };

namespace detail {
constexpr void require_form(WeightForm form) {
  require(form == WeightForm::radial || form == WeightForm::tensor_product, "form",
          static_cast<int>(form), "must be an enumerator of recon::WeightForm");
}
}  // namespace detail

// All weights, and their names: "linear", "quadratic", "cubic", "quartic", "quintic" (B-splines),
// "wendland_c0", ..., "gaussian", "inverse_distance".
std::span<const Weight> all_weights();
std::string_view name_of(Weight weight);
// Throws InvalidArgument with the nearest valid names for an unknown one.
Weight weight_named(std::string_view name);

// Any weight, chosen at run time: one of the enumerators, or an object of your own that is a
// RadialWeight. It is evaluated for many q in one call, so the choice costs nothing inside a loop.
class WeightFunction {
 public:
  template <class Scalar>
  using Function = void (*)(const void* state, const Scalar* q, Scalar* w, Scalar* slope,
                            std::size_t n);

  WeightFunction(Weight weight = Weight::cubic_b_spline);

  // A type that is no RadialWeight is taken and refused in words, instead of with a list of the
  // constructors that it does not fit.
  template <class W>
  requires(std::is_class_v<W> && !std::derived_from<W, WeightFunction> &&
           !std::convertible_to<W, Weight>) WeightFunction(W weight) {
    static_assert(
        RadialWeight<W>,
        "a weight needs w(q) and derivative(q), const, double in and double out, and must "
        "be copyable: see RadialWeight in recon/weights/weight.hpp");
    if constexpr (RadialWeight<W>) {
      detail::validate_weight(weight);
      state_ = std::make_shared<const W>(std::move(weight));
      evaluate_double_ = &run<W, double>;
      evaluate_float_ = &run<W, float>;
    }
  }

  // evaluate() as a plain function, to be called with state(). The built-in weights are compiled
  // for the given instruction set (a resolved one).
  template <class Scalar>
  Function<Scalar> function(InstructionSet set) const;
  const void* state() const { return state_.get(); }
  // The enumerator it was made from; none for an object of your own.
  const std::optional<Weight>& named() const { return named_; }

  // w[i] = w(q[i]) and, unless `slope` is null, slope[i] = w'(q[i]), for i < n; 0 where q[i] >= 1.
  // Throws InvalidArgument for a w that is negative or not finite.
  void evaluate(const double* q, double* w, double* slope, std::size_t n) const {
    evaluate_double_(state_.get(), q, w, slope, n);
  }
  void evaluate(const float* q, float* w, float* slope, std::size_t n) const {
    evaluate_float_(state_.get(), q, w, slope, n);
  }

 private:
  template <class W, class Scalar>
  static void run(const void* state, const Scalar* q, Scalar* w, Scalar* slope, std::size_t n) {
    const W& weight = *static_cast<const W*>(state);
    // Slopes first: w may be written over q.
    for (std::size_t i = 0; slope && i < n; ++i) {
      slope[i] = q[i] < Scalar(1) ? static_cast<Scalar>(weight.derivative(q[i])) : Scalar(0);
      detail::require_slope(q[i], slope[i]);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const Scalar at = q[i];
      w[i] = at < Scalar(1) ? static_cast<Scalar>(weight(at)) : Scalar(0);
      detail::require_weight(at, w[i]);
    }
  }

  std::shared_ptr<const void> state_;
  Function<double> evaluate_double_ = nullptr;
  Function<float> evaluate_float_ = nullptr;
  std::optional<Weight> named_;
};

// The support of the cardinal B-spline of degree P in spacings of its grid, (P + 1) / 2; 0 for
// weights that are no B-splines.
double natural_support(const WeightFunction& weight);

}  // namespace recon
