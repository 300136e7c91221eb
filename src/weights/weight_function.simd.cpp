#include "weights/weight_function.hpp"

#include "recon/core/pack.hpp"

namespace recon::RECON_SET {

namespace {

template <class W, class Scalar>
void evaluate(const void*, const Scalar* q, Scalar* w, Scalar* slope, std::size_t n) {
  using T = Pack<Scalar>;
  constexpr auto aligned = std::experimental::element_aligned;
  const auto both = [&](const auto& x, auto&& store) {
    using X = std::remove_cvref_t<decltype(x)>;
    store(detail::select(x < X(1), X(W{}(x)), X(0)), w);
    if (slope) store(detail::select(x < X(1), X(W{}.derivative(x)), X(0)), slope);
  };
  std::size_t i = 0;
  for (; i + T::size() <= n; i += T::size())
    both(T(q + i, aligned), [&](const T& value, Scalar* to) { value.copy_to(to + i, aligned); });
  for (; i < n; ++i)
    both(std::experimental::simd<Scalar, std::experimental::simd_abi::scalar>(q[i]),
         [&](const auto& value, Scalar* to) { to[i] = value[0]; });
}

}  // namespace

template <class Scalar>
WeightFunction::Function<Scalar> weight_function(Weight weight) {
  switch (weight) {
    case Weight::linear_b_spline:
      return &evaluate<BSpline<1>, Scalar>;
    case Weight::quadratic_b_spline:
      return &evaluate<BSpline<2>, Scalar>;
    case Weight::cubic_b_spline:
      return &evaluate<BSpline<3>, Scalar>;
    case Weight::quartic_b_spline:
      return &evaluate<BSpline<4>, Scalar>;
    case Weight::quintic_b_spline:
      return &evaluate<BSpline<5>, Scalar>;
    case Weight::wendland_c0:
      return &evaluate<Wendland<0>, Scalar>;
    case Weight::wendland_c2:
      return &evaluate<Wendland<2>, Scalar>;
    case Weight::wendland_c4:
      return &evaluate<Wendland<4>, Scalar>;
    case Weight::wendland_c6:
      return &evaluate<Wendland<6>, Scalar>;
    case Weight::gaussian:
      return &evaluate<Gaussian, Scalar>;
    case Weight::inverse_distance:
      return &evaluate<InverseDistance, Scalar>;
  }
  return nullptr;
}

template WeightFunction::Function<float> weight_function<float>(Weight);
template WeightFunction::Function<double> weight_function<double>(Weight);

}  // namespace recon::RECON_SET
