// Polynomials about a particle that are orthogonal under its functions S_i, for maps that carry
// more than a velocity: APIC (Jiang et al. 2015) and PolyPIC (Fu et al. 2017).
//
// On each axis s_0 = 1, s_1 = d, s_2 = d^2 - kappa d - nu with d = x_i - x and sum_i S_i s_r s_q
// = 0; in D dimensions the products of these. For quadratic splines inside the grid nu = h^2 / 4
// and kappa = z (h^2 - 4 z^2) / h^2 with z = x less the nearest node: the closed forms of the
// sources. Here they are built from the functions S_i themselves, so that they hold for all
// functions that are positive products, and also next to a face, where splines are different. A
// particle keeps the coefficients
//     c_r = sum_i S_i s_r(x_i) u_i / norm_r ,   norm_r = sum_i S_i s_r(x_i)^2 ,
// and its field is u + sum_r c_r s_r: with u the value of the nodes, the best approximation of
// their data in the weights S_i. The coefficients move with the particle to places where norm_r
// differs; norm_1 is the same everywhere inside the grid, so angular momentum is kept.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   const recon::SplineFunctions<2> spline;
//   recon::SplineFunctions<2>::Nodes<2> at;
//   spline.at(grid, x, at);
//   recon::PolynomialModes<2> modes;
//   modes.fill(grid, spline.axes(grid, x), x, recon::ModeSet::affine);
//   const double slope_x = modes.coefficient(0, at, nodal_density);  // per length
//   const double seen_by_its_first_node = at.value(nodal_density) + slope_x * modes.value(0, 0);
// ```
//
// s_r and norm_r have the unit length^(r_1 + .. + r_D), norm_r that squared. Nothing is allocated.
// Data that are not finite are refused as NodeFunctions does.
//
// DomainModes are the affine modes of functions that are no products: averages over the domain of a
// particle (domain_functions.hpp). There the D polynomials s_d = (x_i - m)_d, m = sum_i S_i x_i, are
// not orthogonal to each other, and the coefficients are the columns of the slope
//     C = (sum_i S_i u_i (x_i - m)^T) D^+ ,   D = sum_i S_i (x_i - m) (x_i - m)^T .
// D^+ is the inverse on the directions that the domain sees and zero on the others: those in which
// D is below 1e-3 h^2, as in a small domain about a node or on an edge of cells. There the nodes to
// both sides have a thousandth of S together, and nothing that is shown to them counts. Linear
// fields are exact along all directions that are seen.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "recon/transfer/point_functions.hpp"

namespace recon {

namespace detail {
// Whether the eigenvalues of a symmetric matrix are all above `least`, as far as that is seen
// without them: all are positive where these sums are, and none is below the determinant over the
// greatest product of the others. (Beyond a face functions may be negative, and so may what they weigh.)
template <class M>
constexpr bool exceeds_along_all(const M& matrix, double least) {
  constexpr int D = M::RowsAtCompileTime;
  const double trace = matrix.trace(), pairs = trace * trace - matrix.squaredNorm();
  double most = 1;
  for (int d = 1; d < D; ++d) most *= trace;
  return trace > 0 && (D < 3 || pairs > 0) && matrix.determinant() > least * most;
}
// The inverse of a symmetric matrix on the directions whose eigenvalues are above `least`, zero on
// the others. Gives the number of the former.
template <int D>
int invert_along(const SpaceMatrix<D>& matrix, double least, SpaceMatrix<D>& inverse);

// s_0, s_1 and s_2 of an axis at its nodes, and their norms.
inline constexpr int widest_with_modes = 4;  // nodes of a spline on an axis
struct AxisModes {
  double norm[3];
  double value[3][widest_with_modes];
};
// Up to s_1 where no quadratic ones are asked for.
template <class Grid, class Count>
constexpr AxisModes modes_of_axis(const Grid& grid, const AxisFunctions<Count>& axis, double x,
                                  int d, bool quadratic) {
  static_assert(Count::most <= widest_with_modes);
  constexpr double least_linear = 1e-12, least_quadratic = 1e-6;
  const double h = grid.h();
  AxisModes modes{};
  double mean = 0;
  for (int k = 0; k < axis.count; ++k) {
    modes.value[0][k] = 1;
    modes.value[1][k] = grid.node(axis.first + k, d) - x;
    modes.norm[0] += axis.S[k];
    mean += axis.S[k] * modes.value[1][k];
  }
  mean /= modes.norm[0];
  double third = 0;
  for (int k = 0; k < axis.count; ++k) {
    double& s = modes.value[1][k];
    s -= mean;
    modes.norm[1] += axis.S[k] * s * s;
    third += axis.S[k] * s * s * s;
  }
  if (!(modes.norm[1] > least_linear * h * h)) modes.norm[1] = 0;
  if (modes.norm[1] == 0 || !quadratic) return modes;
  for (int k = 0; k < axis.count; ++k) {
    const double s = modes.value[1][k];
    modes.value[2][k] = s * s - third / modes.norm[1] * s - modes.norm[1] / modes.norm[0];
    modes.norm[2] += axis.S[k] * modes.value[2][k] * modes.value[2][k];
  }
  if (!(modes.norm[2] > least_quadratic * h * h * h * h)) modes.norm[2] = 0;
  return modes;
}
}  // namespace detail

// affine: s_1 of each axis; that of axis d has number d. polynomial: all products of the s_(r_d)
// with r_d = 0, 1, 2 but the constant; number sum_d r_d 3^d - 1.
enum class ModeSet { affine, polynomial };

// The number of modes beyond the constant.
constexpr int mode_count(ModeSet set, int dimension) {
  if (set == ModeSet::affine) return dimension;
  return dimension == 1 ? 2 : dimension == 2 ? 8 : 26;
}
// The number of s_1 of an axis.
constexpr int linear_mode(ModeSet set, int axis) {
  if (set == ModeSet::affine) return axis;
  return axis == 0 ? 0 : axis == 1 ? 2 : 8;
}

template <int D>
class PolynomialModes {
 public:
  // The modes about x of the product of these functions (ProductFunctions::axes()), at most four
  // on an axis.
  template <class Count, class Point>
  void fill(const CartesianGrid<D>& grid, const std::array<detail::AxisFunctions<Count>, D>& axes,
            const Point& x, ModeSet set) {
    std::array<detail::AxisModes, D> of;
    nodes_ = 1;
    for (int d = 0; d < D; ++d) {
      of[d] = detail::modes_of_axis(grid, axes[d], x[d], d, set == ModeSet::polynomial);
      nodes_ *= static_cast<std::size_t>(axes[d].count);
    }
    set_ = set;
    count_ = mode_count(set, D);
    for (int r = 0; r < count_; ++r) {
      std::array<int, D> degree{};
      if (set == ModeSet::affine)
        degree[static_cast<std::size_t>(r)] = 1;
      else
        for (int d = 0, rest = r + 1; d < D; ++d, rest /= 3) degree[d] = rest % 3;
      norm_[r] = 1;
      for (int d = 0; d < D; ++d) norm_[r] *= of[d].norm[degree[d]];
      std::array<int, D> k{};
      const double* line = of[0].value[degree[0]];
      double* to = &value_[static_cast<std::size_t>(r) * nodes_];
      for (const double* end = to + nodes_; to != end;) {
        double factor = 1;
        for (int d = 1; d < D; ++d) factor *= of[d].value[degree[d]][k[d]];
        for (int i = 0; i < axes[0].count; ++i) *to++ = line[i] * factor;
        for (int d = 1; d < D && ++k[d] == axes[d].count; ++d) k[d] = 0;
      }
    }
  }

  int count() const { return count_; }
  // norm_r; 0 where the functions S_i cannot tell the polynomial from those before it.
  double norm(int r) const { return norm_[static_cast<std::size_t>(r)]; }
  // s_r at node n, in the order of NodeFunctions.
  double value(int r, std::size_t n) const {
    return value_[static_cast<std::size_t>(r) * nodes_ + n];
  }
  // Those of all modes and nodes: s_r at node n is values()[r nodes() + n].
  const double* values() const { return value_.data(); }
  std::size_t nodes() const { return nodes_; }
  // Turns sum_i S_i s_r(x_i) u_i, of all modes, into c_r.
  template <class Coefficients>
  void divide(Coefficients&& moments) const {
    for (int r = 0; r < count_; ++r)
      if (norm(r) > 0)
        moments[r] /= norm(r);
      else
        moments[r] *= 0;
  }

  // c_r of nodal data u; zero where norm_r is.
  template <class Nodes, class Values>
  auto coefficient(int r, const Nodes& at, const Values& u, Data data = Data::checked) const {
    using Element = detail::ElementOf<const Values>;
    using Value = decltype(Element::zero());
    Value zero = Element::zero();
    if (!(norm(r) > 0)) return zero;
    const Value sum = detail::sum_over_nodes(
        at, u, zero, [&](std::size_t k) { return at.S[k] * value(r, k) != 0; },
        [&](Value& part, std::size_t k) {
          Element::add(part, at.S[k] * value(r, k), detail::nodal(u, at.node[k]));
        },
        data);
    return Value(Element::divided(sum, norm(r)));
  }
  // c_r of all modes.
  template <class Nodes, class Values, class Coefficients>
  void coefficients(const Nodes& at, const Values& u, Coefficients&& c,
                    Data data = Data::checked) const {
    for (int r = 0; r < count_; ++r) c[r] = coefficient(r, at, u, data);
  }
  // sum_i S_i w(x_i) (x_i - x)^T of a vector field w = sum_r c_r s_r: times the mass of the particle,
  // what its field adds to angular momentum.
  template <class Coefficients>
  auto moment(const Coefficients& c) const {
    Eigen::Matrix<double, std::remove_cvref_t<decltype(c[0])>::SizeAtCompileTime, D> B;
    for (int d = 0; d < D; ++d) {
      const int r = linear_mode(set_, d);
      B.col(d) = norm(r) * c[r];
    }
    return B;
  }
  // shown[n] += sum_r c_r s_r at node n, for the `size` nodes of the particle.
  template <class Shown, class Coefficients>
  void add_to(Shown& shown, std::size_t size, const Coefficients& c,
              Data data = Data::checked) const {
    using Element = detail::ElementOf<Shown>;
    for (int r = 0; r < count_; ++r) {
      if (!(norm(r) > 0)) continue;
      detail::require_finite<Element>(c[r], "the coefficients of a mode", data);
      for (std::size_t n = 0; n < size; ++n) Element::add(shown[n], value(r, n), c[r]);
    }
  }

 private:
  static constexpr int most_modes = mode_count(ModeSet::polynomial, D);
  ModeSet set_ = ModeSet::affine;
  int count_ = 0;
  std::size_t nodes_ = 0;
  std::array<double, most_modes> norm_{};
  std::array<double, most_modes * detail::to_the_power<detail::widest_with_modes>(D)> value_{};
};

// Nodal data are vectors of Eigen here. Keeps its memory from particle to particle.
template <int D>
class DomainModes {
 public:
  // Of the functions of a particle.
  template <class Nodes>
  void fill(const CartesianGrid<D>& grid, const Nodes& at) {
    SpaceVector<D> mean = SpaceVector<D>::Zero();
    offset_.resize(at.size());
    for (std::size_t k = 0; k < at.size(); ++k) {
      offset_[k] = grid.position(at.node[k]);
      mean += at.S[k] * offset_[k];
    }
    second_.setZero();
    for (std::size_t k = 0; k < at.size(); ++k) {
      offset_[k] -= mean;
      second_ += at.S[k] * offset_[k] * offset_[k].transpose();
    }
    invert(1e-3 * grid.h() * grid.h());
  }
  // The number of directions that the domain sees.
  int rank() const { return rank_; }

  static constexpr int count() { return D; }
  // s_d at node n is values()[n D + d].
  const double* values() const { return offset_.data()->data(); }
  // As of PolynomialModes.
  template <class Coefficients>
  void divide(Coefficients&& moments) const {
    auto slope = columns(moments);
    slope = (slope * inverse_).eval();
    for (int d = 0; d < D; ++d) moments[d] = slope.col(d);
  }
  // c_d, the derivative along axis d, of nodal data u.
  template <class Nodes, class Values, class Coefficients>
  void coefficients(const Nodes& at, const Values& u, Coefficients&& c,
                    Data data = Data::checked) const {
    using Element = detail::ElementOf<const Values>;
    using Moment = typename Element::template Gradient<D>;
    const Moment zero = Moment::Zero();
    const Moment moment = detail::sum_over_nodes(
        at, u, zero, [&](std::size_t k) { return at.S[k] != 0; },
        [&](Moment& sum, std::size_t k) {
          sum += at.S[k] * detail::nodal(u, at.node[k]) * offset_[k].transpose();
        },
        data);
    const Moment slope = moment * inverse_;
    for (int d = 0; d < D; ++d) c[d] = slope.col(d);
  }
  // As of PolynomialModes.
  template <class Coefficients>
  auto moment(const Coefficients& c) const {
    auto slope = columns(c);
    slope = (slope * second_).eval();
    return slope;
  }
  template <class Shown, class Coefficients>
  void add_to(Shown& shown, std::size_t size, const Coefficients& c,
              Data data = Data::checked) const {
    using Element = detail::ElementOf<Shown>;
    for (int d = 0; d < D; ++d)
      detail::require_finite<Element>(c[d], "the coefficients of a mode", data);
    for (std::size_t k = 0; k < size; ++k)
      for (int d = 0; d < D; ++d) shown[k] += offset_[k][d] * c[d];
  }

 private:
  template <class Coefficients>
  static auto columns(const Coefficients& c) {
    Eigen::Matrix<double, std::remove_cvref_t<decltype(c[0])>::SizeAtCompileTime, D> all;
    for (int d = 0; d < D; ++d) all.col(d) = c[d];
    return all;
  }
  // D^+, where eigenvalues that are not above `least` count as zero.
  void invert(double least) {
    rank_ = D;
    if (detail::exceeds_along_all(second_, least)) [[likely]] {
      inverse_ = second_.inverse();
      return;
    }
    rank_ = detail::invert_along(second_, least, inverse_);
  }

  int rank_ = 0;
  std::vector<SpaceVector<D>> offset_;
  SpaceMatrix<D> second_, inverse_;
};

}  // namespace recon
