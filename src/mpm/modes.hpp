// The polynomials that the particles of a velocity map carry beyond their velocities.
#pragma once

#include <Eigen/LU>

#include "recon/mpm/method.hpp"
#include "recon/transfer/modes.hpp"

namespace recon::mpm {

inline ModeSet mode_set(VelocityMap map) {
  return map == VelocityMap::affine ? ModeSet::affine : ModeSet::polynomial;
}
// The number of coefficients of a particle beyond its velocity.
inline int mode_count(VelocityMap map, int dimension) {
  if (map != VelocityMap::affine && map != VelocityMap::polynomial) return 0;
  return mode_count(mode_set(map), dimension);
}

// The affine modes of functions that are averages over a domain: with d = x_i - sum_i S_i x_i and D
// = sum_i S_i d d^T (not diagonal, as that of products is) the slope C = (sum_i S_i u_i d^T) D^-1,
// whose columns are the coefficients. Linear fields are exact whatever the domain. Zero where D is
// as good as singular: a domain that sees a single node along some direction.
template <int D>
class DomainModes {
 public:
  template <class At>
  void fill(const Grid<D>& grid, const At& at) {
    constexpr double least = 1e-12;  // of det D, where D had equal edges
    Vector<D> mean = Vector<D>::Zero();
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
    const double det = second_.determinant();
    inverse_.setZero();
    if (det > least * std::pow(second_.trace() / D, D)) inverse_ = second_.inverse();
  }
  void add_to(std::vector<Vector<D>>& shown, std::size_t size, const Vector<D>* c) const {
    for (std::size_t k = 0; k < size; ++k)
      for (int d = 0; d < D; ++d) shown[k] += offset_[k][d] * c[d];
  }
  template <class At>
  void take(const At& at, const std::vector<Vector<D>>& u, Vector<D>* c) const {
    Matrix<D> moment = Matrix<D>::Zero();
    for (std::size_t k = 0; k < at.size(); ++k)
      moment += at.S[k] * u[at.node[k]] * offset_[k].transpose();
    const Matrix<D> slope = moment * inverse_;
    for (int d = 0; d < D; ++d) c[d] = slope.col(d);
  }
  // sum_i S_i u_i d^T of the particle's own field.
  Matrix<D> moment(const Vector<D>* c) const {
    Matrix<D> slope;
    for (int d = 0; d < D; ++d) slope.col(d) = c[d];
    return slope * second_;
  }

 private:
  std::vector<Vector<D>> offset_;
  Matrix<D> second_, inverse_;
};

// The modes of a particle with the policy Shape.
template <int D, class Shape>
class ParticleModes {
 public:
  template <class At>
  void fill(const Grid<D>& grid, const Shape& shape_of, const Vector<D>& x, const At& at,
            ModeSet set) {
    if constexpr (product)
      of_.fill(grid, shape_of.functions.axes(grid, x), x, set), set_ = set;
    else
      of_.fill(grid, at);
  }
  // shown[k] += sum_r c_r s_r at node k of the particle.
  void add_to(std::vector<Vector<D>>& shown, std::size_t size, const Vector<D>* c) const {
    if constexpr (product)
      of_.add_to(shown, size, c, trusted);
    else
      of_.add_to(shown, size, c);
  }
  // The coefficients of nodal velocities.
  template <class At>
  void take(const At& at, const std::vector<Vector<D>>& velocity, Vector<D>* c) const {
    if constexpr (product)
      for (int r = 0; r < of_.count(); ++r) c[r] = of_.coefficient(r, at, velocity, trusted);
    else
      of_.take(at, velocity, c);
  }
  // m B with B = sum_i S_i v_i d^T of the field v + sum_r c_r s_r.
  Matrix<D> moment(double m, const Vector<D>* c) const {
    if constexpr (product) {
      Matrix<D> B;
      for (int d = 0; d < D; ++d) {
        const int r = linear_mode(set_, d);
        B.col(d) = m * of_.norm(r) * c[r];
      }
      return B;
    } else {
      return m * of_.moment(c);
    }
  }

 private:
  static constexpr bool product = is_product<D, Shape>;
  std::conditional_t<product, PolynomialModes<D>, DomainModes<D>> of_;
  ModeSet set_ = ModeSet::affine;
};

}  // namespace recon::mpm
