// Polynomials about a particle that are orthogonal under its shape functions S_ip, for the maps
// that carry more than a velocity (Jiang et al. 2015; Fu et al. 2017).
//
// On each axis s_0 = 1, s_1 = d, s_2 = d^2 - kappa d - nu with d = x_i - x_p and
// sum_i S_i s_r s_q = 0; in D dimensions their products. For quadratic splines inside the grid nu =
// h^2 / 4 and kappa = z (h^2 - 4 z^2) / h^2 with z = x_p less the nearest node: the closed forms of
// the sources. Built from the functions themselves they hold for every basis of positive products,
// and next to a face, where splines end otherwise.
//
// A particle remembers sum_i t_r(x_i) v_i for products t_r of these, and its field is v_p plus
// the sum of them times products of those, n_r = sum_i S_i s_r^2:
//     degree   remembered            field          kept while the particle moves
//     0        S_i                   1              velocity
//     1        S_i s_1               s_1 / n_1      moment, and with it the angular momentum
//     2        S_i s_2 / n_2         s_2            curvature; the moment would make it grow
//     without
//                                                   bound where n_2 falls to zero: half way between
//                                                   two nodes the third has no weight
#pragma once

#include "recon/mpm/method.hpp"

namespace recon::mpm {

// Moments of a particle beyond its velocity. affine: s_1 of axis d is number d. polynomial: the
// product of s_(r_d) is number sum_d r_d 3^d - 1.
inline int moment_count(VelocityMap map, int dimension) {
  if (map == VelocityMap::affine) return dimension;
  if (map != VelocityMap::polynomial) return 0;
  return dimension == 1 ? 2 : dimension == 2 ? 8 : 26;
}
// Of s_1 of an axis.
inline int linear_moment(VelocityMap map, int axis) {
  if (map == VelocityMap::affine) return axis;
  return axis == 0 ? 0 : axis == 1 ? 2 : 8;
}

template <int D>
class PolynomialModes {
 public:
  void fill(const Grid<D>& grid, const std::array<detail::AxisShape, D>& axes, const Vector<D>& x,
            VelocityMap map) {
    std::array<Axis, D> of;
    nodes_ = 1;
    for (int d = 0; d < D; ++d) {
      of[d] = modes_of(grid, axes[d], x[d], d);
      second_[d] = of[d].second;
      nodes_ *= static_cast<std::size_t>(axes[d].count);
    }
    count_ = moment_count(map, D);
    value_.assign(static_cast<std::size_t>(count_) * nodes_, 1);
    dual_ = value_;
    for (int r = 0; r < count_; ++r) {
      std::array<int, D> degree{};
      if (map == VelocityMap::affine)
        degree[static_cast<std::size_t>(r)] = 1;
      else
        for (int d = 0, rest = r + 1; d < D; ++d, rest /= 3) degree[d] = rest % 3;
      std::array<int, D> k{};
      for (std::size_t n = 0; n < nodes_; ++n) {
        const std::size_t at = static_cast<std::size_t>(r) * nodes_ + n;
        for (int d = 0; d < D; ++d) {
          value_[at] *= of[d].value[degree[d]][k[d]];
          dual_[at] *= of[d].dual[degree[d]][k[d]];
        }
        for (int d = 0; d < D && ++k[d] == axes[d].count; ++d) k[d] = 0;
      }
    }
  }

  int count() const { return count_; }
  // n_1 of an axis.
  double second(int d) const { return second_[static_cast<std::size_t>(d)]; }
  // What a unit of number r adds to the field at node n, in the order of tensor_product().
  double value(int r, std::size_t n) const {
    return value_[static_cast<std::size_t>(r) * nodes_ + n];
  }
  // What a unit of velocity at node n adds to number r.
  double dual(int r, std::size_t n) const {
    return dual_[static_cast<std::size_t>(r) * nodes_ + n];
  }

 private:
  static constexpr int widest = 4;  // nodes of a spline on an axis
  struct Axis {
    double value[3][widest];
    double dual[3][widest];
    double second;
  };

  // Zero for polynomials that the nodes cannot tell from those before.
  static Axis modes_of(const Grid<D>& grid, const detail::AxisShape& axis, double x, int d) {
    constexpr double least_norm = 1e-12;
    const double h = grid.h();
    Axis modes{};
    double sum = 0, mean = 0;
    for (int k = 0; k < axis.count; ++k) {
      modes.value[0][k] = 1;
      modes.dual[0][k] = axis.S[k];
      sum += axis.S[k];
      mean += axis.S[k] * (grid.node(axis.first + k, d) - x);
    }
    mean /= sum;
    double s[widest], second = 0, third = 0;
    for (int k = 0; k < axis.count; ++k) {
      s[k] = grid.node(axis.first + k, d) - x - mean;
      second += axis.S[k] * s[k] * s[k];
      third += axis.S[k] * s[k] * s[k] * s[k];
    }
    if (!(second > least_norm * h * h)) return modes;
    modes.second = second;
    double norm = 0;
    for (int k = 0; k < axis.count; ++k) {
      modes.value[1][k] = s[k] / second;
      modes.dual[1][k] = axis.S[k] * s[k];
      if (axis.count == 2) continue;
      modes.value[2][k] = s[k] * s[k] - third / second * s[k] - second / sum;
      modes.dual[2][k] = axis.S[k] * modes.value[2][k];
      norm += axis.S[k] * modes.value[2][k] * modes.value[2][k];
    }
    // Of three nodes nothing but the second difference is left, whatever their weights.
    constexpr double difference[3] = {0.5, -1, 0.5};
    for (int k = 0; k < axis.count && axis.count > 2; ++k)
      modes.dual[2][k] = axis.count == 3 ? difference[k] / (h * h) : modes.dual[2][k] / norm;
    return modes;
  }

  int count_ = 0;
  std::size_t nodes_ = 0;
  std::array<double, D> second_{};
  std::vector<double> value_, dual_;
};

}  // namespace recon::mpm
