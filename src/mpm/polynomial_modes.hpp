// Polynomials about a particle that are orthogonal under its shape functions S_ip, for the maps
// that carry more than a velocity (Jiang et al. 2015; Fu et al. 2017).
//
// On each axis s_0 = 1, s_1 = d, s_2 = d^2 - kappa d - nu with d = x_i - x_p and sum_i S_i s_r s_q
// = 0; in D dimensions the products of these. For quadratic splines inside the grid nu = h^2 / 4
// and kappa = z (h^2 - 4 z^2) / h^2 with z = x_p less the nearest node: the closed forms of the
// sources. Here they are built from the functions S_i themselves, so that they hold for every basis
// of positive products, and also next to a face, where splines are different. A particle keeps the
// coefficients c_r = sum_i S_i s_r(x_i) v_i / norm_r with norm_r = sum_i S_i s_r^2: its velocity
// field is v_p + sum_r c_r s_r. The coefficients move with the particle to places where norm_r
// differs; norm_1 is the same everywhere inside the grid, so angular momentum is kept.
#pragma once

#include "recon/mpm/method.hpp"

namespace recon::mpm {

// The number of coefficients of a particle beyond its velocity. affine: s_1 of axis d has number d.
// polynomial: the product of the s_(r_d) has number sum_d r_d 3^d - 1.
inline int mode_count(VelocityMap map, int dimension) {
  if (map == VelocityMap::affine) return dimension;
  if (map != VelocityMap::polynomial) return 0;
  return dimension == 1 ? 2 : dimension == 2 ? 8 : 26;
}
// The number of the coefficient of s_1 of an axis.
inline int linear_mode(VelocityMap map, int axis) {
  if (map == VelocityMap::affine) return axis;
  return axis == 0 ? 0 : axis == 1 ? 2 : 8;
}

// Whether a policy is a product of functions of the axes.
template <int D, class Shape>
constexpr bool is_product = requires(const Shape& shape, const Grid<D>& grid, const Vector<D>& x) {
  shape.template axes<D>(grid, x);
};

template <int D>
class PolynomialModes {
 public:
  void fill(const Grid<D>& grid, const std::array<detail::AxisShape, D>& axes, const Vector<D>& x,
            VelocityMap map) {
    std::array<Axis, D> of;
    nodes_ = 1;
    for (int d = 0; d < D; ++d) {
      of[d] = modes_of(grid, axes[d], x[d], d);
      nodes_ *= static_cast<std::size_t>(axes[d].count);
    }
    count_ = mode_count(map, D);
    norm_.assign(static_cast<std::size_t>(count_), 1);
    value_.assign(static_cast<std::size_t>(count_) * nodes_, 1);
    for (int r = 0; r < count_; ++r) {
      std::array<int, D> degree{};
      if (map == VelocityMap::affine)
        degree[static_cast<std::size_t>(r)] = 1;
      else
        for (int d = 0, rest = r + 1; d < D; ++d, rest /= 3) degree[d] = rest % 3;
      for (int d = 0; d < D; ++d) norm_[r] *= of[d].norm[degree[d]];
      std::array<int, D> k{};
      for (std::size_t n = 0; n < nodes_; ++n) {
        for (int d = 0; d < D; ++d)
          value_[static_cast<std::size_t>(r) * nodes_ + n] *= of[d].value[degree[d]][k[d]];
        for (int d = 0; d < D && ++k[d] == axes[d].count; ++d) k[d] = 0;
      }
    }
  }

  int count() const { return count_; }
  // norm_r; 0 where the functions S_i cannot tell the polynomial from those before it.
  double norm(int r) const { return norm_[static_cast<std::size_t>(r)]; }
  // s_r at node n, in the order of tensor_product().
  double value(int r, std::size_t n) const {
    return value_[static_cast<std::size_t>(r) * nodes_ + n];
  }

 private:
  static constexpr int widest = 4;  // nodes of a spline on an axis
  struct Axis {
    double norm[3];
    double value[3][widest];
  };

  static Axis modes_of(const Grid<D>& grid, const detail::AxisShape& axis, double x, int d) {
    constexpr double least_linear = 1e-12, least_quadratic = 1e-6;
    const double h = grid.h();
    Axis modes{};
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
    if (modes.norm[1] == 0) return modes;
    for (int k = 0; k < axis.count; ++k) {
      const double s = modes.value[1][k];
      modes.value[2][k] = s * s - third / modes.norm[1] * s - modes.norm[1] / modes.norm[0];
      modes.norm[2] += axis.S[k] * modes.value[2][k] * modes.value[2][k];
    }
    if (!(modes.norm[2] > least_quadratic * h * h * h * h)) modes.norm[2] = 0;
    return modes;
  }

  int count_ = 0;
  std::size_t nodes_ = 0;
  std::vector<double> norm_, value_;
};

}  // namespace recon::mpm
