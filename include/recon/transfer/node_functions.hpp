// What a particle sees of the grid: nodes i with S_i and G_i, the value and the gradient of their
// functions N_i at the particle or averaged over its domain, and the two ways along them:
//
//     to the particle   value(u)    = sum_i S_i u_i ,  gradient(u) = sum_i u_i (x) G_i
//     to the nodes      add(u, a):    u_i += S_i a ,   add_gradient(u, P): u_i += P G_i
//
// add() is the transpose of value(), and add_gradient() that of gradient(): with u zero before,
// sum_i u_i . w_i is a . value(w) and P : gradient(w) for any nodal w. The internal force of the
// material point method is add_gradient(force, -volume * stress) (Sulsky, Chen, Schreyer 1994).
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   std::vector<std::array<double, 2>> nodal_velocity(grid.size());
//   recon::LinearFunctions::Nodes<2> at;
//   recon::LinearFunctions{}.at(grid, x, at);  // x: anything with x[0] and x[1]
//   const std::array<double, 2> v = at.value(nodal_velocity);
//   const Eigen::Matrix2d L = at.gradient(nodal_velocity);  // L(a, d) = d v_a / d x_d
// ```
//
// Nodal data are arrays of yours: anything with u[i], or a function u(i), for the number i of a
// node. An element is a float or double, a std::array of such or a vector of Eigen (of fixed size);
// value() returns the like. S has no unit, G is 1 / length. How many nodes there are is part of the
// type where it is known, so that nothing is allocated for a particle.
//
// Throws InvalidArgument, before anything is written, for an amount that is not finite, naming its
// component, and for nodal data that are not finite where a function is not 0, naming node and
// component: what a node holds that no particle sees may be anything. With `trusted` as the last
// argument nothing is looked at (operators/limit.hpp).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "recon/operators/limit.hpp"
#include "recon/transfer/cartesian_grid.hpp"

namespace recon {

// A number of nodes: always N, never more than N, or not known before.
template <int N>
struct Exactly {
  static constexpr int most = N;
};
template <int N>
struct AtMost {
  static constexpr int most = N;
};
struct AnyNumber {};

namespace detail {

template <int N>
constexpr int to_the_power(int D) {
  return D == 0 ? 1 : N * to_the_power<N>(D - 1);
}

// The number of nodes of a product of the functions of D axes.
template <class Count, int D>
struct Product;
template <int N, int D>
struct Product<Exactly<N>, D> {
  using Count = Exactly<to_the_power<N>(D)>;
};
template <int N, int D>
struct Product<AtMost<N>, D> {
  using Count = AtMost<to_the_power<N>(D)>;
};

// Whether an object for `Room` many nodes can take `Count` many.
template <class Room, class Count>
inline constexpr bool takes = false;
template <class Count>
inline constexpr bool takes<AnyNumber, Count> = true;
template <int N>
inline constexpr bool takes<Exactly<N>, Exactly<N>> = true;
template <int M, int N>
inline constexpr bool takes<AtMost<M>, Exactly<N>> = N <= M;
template <int M, int N>
inline constexpr bool takes<AtMost<M>, AtMost<N>> = N <= M;

// The functions of one axis at `count` consecutive nodes from `first` on.
template <class Count>
struct AxisFunctions;
template <int N>
struct AxisFunctions<Exactly<N>> {
  static constexpr int count = N;
  static constexpr void set_count(int) {}
  int first = 0;
  std::array<double, N> S, G;
};
template <int N>
struct AxisFunctions<AtMost<N>> {
  constexpr void set_count(int to) { count = to; }
  int first = 0, count = 0;
  std::array<double, N> S, G;
};

template <int D, class Count>
struct NodeArrays;
template <int D, int N>
struct NodeArrays<D, Exactly<N>> {
  std::array<std::uint32_t, N> node;
  std::array<double, N> S;
  std::array<SpaceVector<D>, N> G;
  static void resize(std::size_t) {}
  static constexpr std::size_t size() { return N; }
};
template <int D, int N>
struct NodeArrays<D, AtMost<N>> {
  std::array<std::uint32_t, N> node;
  std::array<double, N> S;
  std::array<SpaceVector<D>, N> G;
  void resize(std::size_t count) { size_ = count; }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};
template <int D>
struct NodeArrays<D, AnyNumber> {
  std::vector<std::uint32_t> node;
  std::vector<double> S;
  std::vector<SpaceVector<D>> G;
  void resize(std::size_t count) {  // keeps the memory
    node.resize(count);
    S.resize(count);
    G.resize(count);
  }
  std::size_t size() const { return node.size(); }
};

// Nodal data: u[i], or u(i).
template <class Values>
decltype(auto) nodal(Values& u, std::uint32_t i) {
  if constexpr (requires { u[i]; })
    return u[i];
  else
    return u(i);
}

// What an element of nodal data is to sums: a number, a std::array, or a vector of Eigen.
template <class T>
struct Element {
  static_assert(std::is_floating_point_v<T>,
                "an element of nodal data is a floating-point number, a std::array of such or a "
                "vector of Eigen");
  static constexpr std::size_t components = 1;
  static T zero() { return 0; }
  template <int D>
  using Gradient = SpaceVector<D>;
  static void add(T& sum, double factor, const T& value) {
    sum = static_cast<T>(sum + factor * value);
  }
  static T divided(const T& value, double by) { return static_cast<T>(value / by); }
  template <int D>
  static void add_gradient(SpaceVector<D>& sum, const T& value, const SpaceVector<D>& G) {
    sum += value * G;
  }
  template <class P, int D>
  static void add_flux(T& sum, const P& flux, const SpaceVector<D>& G) {
    sum = static_cast<T>(sum + flux.dot(G));
  }
};
template <class T, std::size_t C>
struct Element<std::array<T, C>> {
  using Value = std::array<T, C>;
  static constexpr std::size_t components = C;
  static Value zero() { return {}; }
  template <int D>
  using Gradient = Eigen::Matrix<double, static_cast<int>(C), D>;
  template <class Amount>
  static void add(Value& sum, double factor, const Amount& value) {
    for (std::size_t c = 0; c < C; ++c) sum[c] = static_cast<T>(sum[c] + factor * value[c]);
  }
  static Value divided(Value value, double by) {
    for (T& component : value) component = static_cast<T>(component / by);
    return value;
  }
  template <int D>
  static void add_gradient(Gradient<D>& sum, const Value& value, const SpaceVector<D>& G) {
    for (std::size_t c = 0; c < C; ++c) sum.row(static_cast<int>(c)) += value[c] * G.transpose();
  }
  template <class P, int D>
  static void add_flux(Value& sum, const P& flux, const SpaceVector<D>& G) {
    for (std::size_t c = 0; c < C; ++c)
      sum[c] = static_cast<T>(sum[c] + flux.row(static_cast<int>(c)).dot(G));
  }
};
template <class T>
requires requires {
  typename T::PlainObject;
}
struct Element<T> {
  using Value = typename T::PlainObject;
  static_assert(Value::SizeAtCompileTime > 0, "vectors of nodal data have a fixed size");
  static constexpr std::size_t components = Value::SizeAtCompileTime;
  static Value zero() { return Value::Zero(); }
  template <int D>
  using Gradient = Eigen::Matrix<double, Value::SizeAtCompileTime, D>;
  template <class Sum, class Amount>
  static void add(Sum&& sum, double factor, const Amount& value) {
    sum += factor * value;
  }
  static Value divided(const Value& value, double by) { return value / by; }
  template <int D>
  static void add_gradient(Gradient<D>& sum, const T& value, const SpaceVector<D>& G) {
    sum += value * G.transpose();
  }
  template <class Sum, class P, int D>
  static void add_flux(Sum&& sum, const P& flux, const SpaceVector<D>& G) {
    sum += flux * G;
  }
};
template <class Values>
using ElementOf =
    Element<std::remove_cvref_t<decltype(nodal(std::declval<Values&>(), std::uint32_t{}))>>;

// Component i of a number, of anything with [i], or of a vector or matrix of Eigen (a matrix row by
// row).
template <class T>
inline constexpr bool is_eigen = requires {
  typename T::PlainObject;
};
template <class T>
double component(const T& value, std::size_t i) {
  if constexpr (is_eigen<T>)
    return static_cast<double>(value(static_cast<Eigen::Index>(i) / value.cols(),
                                     static_cast<Eigen::Index>(i) % value.cols()));
  else if constexpr (requires { static_cast<double>(value); })
    return static_cast<double>(value);
  else
    return static_cast<double>(value[i]);
}
// Of data that go with this element.
template <class Element, class T>
std::size_t component_count([[maybe_unused]] const T& value) {
  if constexpr (is_eigen<T>)
    return static_cast<std::size_t>(value.size());
  else
    return Element::components;
}
// x - x is 0 for numbers and NaN for others.
template <class Element, class T>
bool all_finite(const T& value) {
  if constexpr (is_eigen<T>) {
    return (value - value).sum() == 0;
  } else {
    double zero = 0;
    for (std::size_t i = 0; i < Element::components; ++i)
      zero += component(value, i) - component(value, i);
    return zero == 0;
  }
}

[[noreturn]] void throw_component(const char* of, double value, std::size_t component,
                                  const char* rule);
[[noreturn]] void throw_nodal(std::uint32_t node, double value, std::size_t component,
                              const char* rule);

// Throws InvalidArgument for the first component that is not finite.
template <class Element, class T>
[[gnu::noinline]] void refuse_component(const T& value, const char* of, const char* rule) {
  for (std::size_t i = 0; i < component_count<Element>(value); ++i)
    if (const double number = component(value, i); !std::isfinite(number))
      throw_component(of, number, i, rule);
}
inline constexpr const char* added_amount = "the amount that is added to nodes";
template <class Element, class T>
void require_finite(const T& value, const char* of, Data data) {
  if (data == Data::checked && !all_finite<Element>(value)) [[unlikely]]
    refuse_component<Element>(value, of, "must be finite");
}

// The sum of terms of nodes, where it is not finite: add(sum, k) adds that of node k, whose nodal
// data are not needed unless used(k).
template <class Nodes, class Values, class Sum, class Used, class Add>
[[gnu::noinline]] Sum sum_without_unused(const Nodes& at, const Values& u, Sum sum,
                                         const Used& used, const Add& add) {
  using Element = ElementOf<const Values>;
  for (std::size_t k = 0; k < at.size(); ++k) {
    if (!used(k)) continue;
    const auto& value = nodal(u, at.node[k]);
    for (std::size_t i = 0; i < component_count<Element>(value); ++i)
      if (const double number = component(value, i); !std::isfinite(number))
        throw_nodal(at.node[k], number, i, "must be finite");
    add(sum, k);
  }
  refuse_component<Element>(sum, "the sum over nodal data", "overflows: the data are too large");
  return sum;
}
// Of nodal data u, from `zero` on; checked as far as `data` says.
template <class Nodes, class Values, class Sum, class Used, class Add>
Sum sum_over_nodes(const Nodes& at, const Values& u, const Sum& zero, const Used& used,
                   const Add& add, Data data) {
  Sum sum = zero;
  for (std::size_t k = 0; k < at.size(); ++k) add(sum, k);
  if (data == Data::checked && !all_finite<ElementOf<const Values>>(sum)) [[unlikely]]
    return sum_without_unused(at, u, zero, used, add);
  return sum;
}

}  // namespace detail

// The nodes of a particle, with the members
//     node   their numbers; with corner domains one may occur more than once
//     S, G   values and gradients
//     size() how many there are
// The default holds whatever any functions give, in memory of the heap that it keeps; functions
// name the type that they need no more than (LinearFunctions::Nodes<D>), which needs none.
template <int D, class Count = AnyNumber>
struct NodeFunctions : detail::NodeArrays<D, Count> {
  using detail::NodeArrays<D, Count>::node;
  using detail::NodeArrays<D, Count>::S;
  using detail::NodeArrays<D, Count>::G;
  using detail::NodeArrays<D, Count>::size;

  // sum_i S_i u_i
  template <class Values>
  auto value(const Values& u, Data data = Data::checked) const {
    using Element = detail::ElementOf<const Values>;
    using Value = decltype(Element::zero());
    const Value zero = Element::zero();
    return detail::sum_over_nodes(
        *this, u, zero, [this](std::size_t k) { return S[k] != 0; },
        [&](Value& sum, std::size_t k) { Element::add(sum, S[k], detail::nodal(u, node[k])); },
        data);
  }
  // sum_i u_i (x) G_i: of numbers a vector, of vectors with C components a C x D matrix with the
  // entries d u_c / d x_d.
  template <class Values>
  auto gradient(const Values& u, Data data = Data::checked) const {
    using Element = detail::ElementOf<const Values>;
    using Gradient = typename Element::template Gradient<D>;
    const Gradient zero = Gradient::Zero();
    return detail::sum_over_nodes(
        *this, u, zero, [this](std::size_t k) { return !G[k].isZero(0); },
        [&](Gradient& sum, std::size_t k) {
          Element::template add_gradient<D>(sum, detail::nodal(u, node[k]), G[k]);
        },
        data);
  }
  // u_i += S_i amount, where the amount is what the elements of u are.
  template <class Values, class Amount>
  void add(Values&& u, const Amount& amount, Data data = Data::checked) const {
    using Element = detail::ElementOf<Values>;
    detail::require_finite<Element>(amount, detail::added_amount, data);
    for (std::size_t k = 0; k < size(); ++k) Element::add(detail::nodal(u, node[k]), S[k], amount);
  }
  // u_i += flux G_i, where the flux is what gradient(u) would be: a vector of Eigen for numbers
  // u_i, a C x D matrix for vectors.
  template <class Values, class Flux>
  void add_gradient(Values&& u, const Flux& flux, Data data = Data::checked) const {
    using Element = detail::ElementOf<Values>;
    detail::require_finite<Element>(flux, "the flux that is added to nodes", data);
    for (std::size_t k = 0; k < size(); ++k)
      Element::add_flux(detail::nodal(u, node[k]), flux, G[k]);
  }
};

namespace detail {

// Writes the products of the first axis, which has `count` nodes, with S and G of the others.
// Most often the count is a constant, of which the loop is made.
template <int D, class Axis, class Count>
void line_of_products(const AxisFunctions<Axis>& line, const auto count, std::uint32_t first,
                      double S, const SpaceVector<D>& G, std::size_t n,
                      NodeFunctions<D, Count>& out) {
  for (int i = 0; i < count; ++i, ++n) {
    out.node[n] = first + static_cast<std::uint32_t>(i);
    out.S[n] = line.S[i] * S;
    out.G[n][0] = line.G[i] * S;
    for (int e = 1; e < D; ++e) out.G[n][e] = line.S[i] * G[e];
  }
}

// The products of the functions of all axes; the first axis runs fastest.
template <int D, class Axis, class Count>
void tensor_product(const CartesianGrid<D>& grid, const std::array<AxisFunctions<Axis>, D>& axes,
                    NodeFunctions<D, Count>& out) {
  std::size_t count = 1;
  for (const auto& axis : axes) count *= static_cast<std::size_t>(axis.count);
  out.resize(count);
  const AxisFunctions<Axis>& line = axes[0];
  std::array<int, D> k{}, index;
  index[0] = line.first;
  for (std::size_t n = 0; n < count;) {
    // The product over the other axes, and the products in which one factor is a derivative.
    double S = 1;
    SpaceVector<D> G = SpaceVector<D>::Ones();
    for (int d = 1; d < D; ++d) {
      const double value = axes[d].S[k[d]];
      index[d] = axes[d].first + k[d];
      S *= value;
      for (int e = 1; e < D; ++e) G[e] *= e == d ? axes[d].G[k[d]] : value;
    }
    const std::uint32_t first = grid.number(index);
    const auto write = [&](const auto length) {
      line_of_products<D>(line, length, first, S, G, n, out);
    };
    if (line.count == 2)
      write(std::integral_constant<int, 2>{});
    else if (line.count == 3 && Axis::most > 2)
      write(std::integral_constant<int, 3>{});
    else
      write(line.count);
    n += static_cast<std::size_t>(line.count);
    for (int d = 1; d < D && ++k[d] == axes[d].count; ++d) k[d] = 0;
  }
}

}  // namespace detail

}  // namespace recon
