// Support tensors: supports that are ellipsoids of any orientation.
//
// A support tensor A is a symmetric positive definite D x D matrix. Its eigenvalues are the half
// axes of the ellipsoid, lengths, and its eigenvectors their directions:
//     q = |A^-1 (x_p - x)| ,   the support is q <= 1 ,   its volume is det A times the unit ball's.
// A = rho I is the ball of radius rho, and what holds of radii holds of tensors: the mean of two is
// one of lengths. Adaptive smoothed particle hydrodynamics (Owen, Villumsen, Shapiro, Martel 1998)
// has eta = G (x_p - x) with G in 1/length: A = k G^-1 where its kernel ends at eta = k.
// For tensor-product weights the support is the parallelepiped on which no component of
// A^-1 (x_p - x) exceeds 1 in magnitude: a box where A is diagonal.
//
// Tensors are given as a FieldView with a value for each target or particle, either packed (xx, xy,
// xz, yy, yz, zz as far as the dimension has them, as Hessians are) or as full matrices of D * D
// components, which must be symmetric. The largest half axis of a tensor may be 1e5 times the
// smallest, in float 1e3 times: beyond that the rounding of its entries is seen in the weights.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "recon/core/array.hpp"
#include "recon/points/view.hpp"

namespace recon {

// The packed tensors (F F^T)^(1/2) of matrices F whose columns are the half axes of
// parallelepipeds, one after another in D * D components: particles that have been deformed, whose
// half axes are F times those that they had. A sphere that becomes an ellipsoid under F has this
// tensor. Throws InvalidArgument for a number of components other than 1, 4 or 9, and for numbers
// that are not finite; what comes of half axes in one plane is refused where it is used.
std::vector<double> support_tensors(const FieldView<double>& half_axes);

namespace detail {

// A symmetric matrix, packed.
template <int D>
struct SymmetricTensor {
  static constexpr int size = D * (D + 1) / 2;
  std::array<double, size> numbers{};

  static constexpr int place(int i, int j) {
    return i <= j ? i * D - i * (i - 1) / 2 + (j - i) : place(j, i);
  }
  constexpr double operator()(int i, int j) const { return numbers[place(i, j)]; }

  template <class Number>
  static SymmetricTensor at(const Number* packed) {
    SymmetricTensor tensor;
    for (int n = 0; n < size; ++n) tensor.numbers[n] = static_cast<double>(packed[n]);
    return tensor;
  }
  static SymmetricTensor ball(double radius) {
    SymmetricTensor tensor;
    for (int d = 0; d < D; ++d) tensor.numbers[place(d, d)] = radius;
    return tensor;
  }

  std::array<double, D> times(const std::array<double, D>& v) const {
    std::array<double, D> product{};
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j) product[i] += (*this)(i, j) * v[j];
    return product;
  }
  SymmetricTensor operator*(double factor) const {
    SymmetricTensor product = *this;
    for (double& number : product.numbers) number *= factor;
    return product;
  }
  SymmetricTensor operator+(const SymmetricTensor& other) const {
    SymmetricTensor sum = *this;
    for (int n = 0; n < size; ++n) sum.numbers[n] += other.numbers[n];
    return sum;
  }

  double determinant() const {
    const SymmetricTensor c = cofactors();
    double sum = 0;
    for (int j = 0; j < D; ++j) sum += (*this)(0, j) * c(0, j);
    return sum;
  }
  // Entries are divided by the largest first, so that no product of them leaves the range.
  SymmetricTensor inverse() const {
    double largest = 0;
    for (const double number : numbers) largest = std::max(largest, std::abs(number));
    const SymmetricTensor scaled = *this * (1 / largest), c = scaled.cofactors();
    double determinant = 0;
    for (int j = 0; j < D; ++j) determinant += scaled(0, j) * c(0, j);
    return c * (1 / (determinant * largest));
  }

  // Half the edges of the box around the ellipsoid or, in a cube, around the parallelepiped.
  std::array<double, D> half_edges(bool cube) const {
    std::array<double, D> half{};
    for (int i = 0; i < D; ++i) {
      for (int j = 0; j < D; ++j)
        half[i] = cube ? half[i] + std::abs((*this)(i, j)) : std::hypot(half[i], (*this)(i, j));
    }
    return half;
  }

 private:
  SymmetricTensor cofactors() const {
    const auto& a = numbers;
    if constexpr (D == 1) return {{1}};
    if constexpr (D == 2) return {{a[2], -a[1], a[0]}};
    if constexpr (D == 3)
      return {{a[3] * a[5] - a[4] * a[4], a[2] * a[4] - a[1] * a[5], a[1] * a[4] - a[2] * a[3],
               a[0] * a[5] - a[2] * a[2], a[1] * a[2] - a[0] * a[4], a[0] * a[3] - a[1] * a[1]}};
  }
};

// The dimension of tensors of so many components; 0: none has so many.
constexpr int tensor_dimension(int components) {
  if (components == 1) return 1;
  if (components == 3 || components == 4) return 2;
  return components == 6 || components == 9 ? 3 : 0;
}

// One tensor of those that a caller gives, of this dimension.
template <int D>
SymmetricTensor<D> tensor_at(const FieldView<double>& tensors, std::size_t i) {
  using Tensor = SymmetricTensor<D>;
  Tensor tensor;
  if (tensors.components() == Tensor::size) {
    for (int n = 0; n < Tensor::size; ++n) tensor.numbers[n] = tensors(i, n);
  } else {
    for (int a = 0; a < D; ++a)
      for (int b = a; b < D; ++b)
        tensor.numbers[Tensor::place(a, b)] =
            a == b ? tensors(i, a * D + a) : (tensors(i, a * D + b) + tensors(i, b * D + a)) / 2;
  }
  return tensor;
}

// Calls use(std::integral_constant<int, D>) for the dimension.
template <class Use>
auto with_dimension(int dimension, const Use& use) {
  switch (dimension) {
    case 1:
      return use(std::integral_constant<int, 1>{});
    case 2:
      return use(std::integral_constant<int, 2>{});
    default:
      return use(std::integral_constant<int, 3>{});
  }
}

// Appends tensor number i, packed and multiplied by a factor; and a view of tensors packed like
// that.
void append_packed(const FieldView<double>& tensors, std::size_t i, double factor,
                   std::vector<double>& packed);
FieldView<double> view_of_packed(const std::vector<double>& packed, int dimension);

// Appends the packed tensor of a ball, of so many numbers.
template <class Scalar>
void append_ball(Scalar radius, std::size_t numbers, Array<Scalar>& packed) {
  with_dimension(tensor_dimension(static_cast<int>(numbers)), [&](auto dimension) {
    for (const double number : SymmetricTensor<dimension>::ball(1).numbers)
      packed.push_back(number > 0 ? radius : Scalar(0));
  });
}

struct HalfAxes {
  double smallest, largest;
};
template <int D>
HalfAxes half_axes(const SymmetricTensor<D>& tensor);

// Throws InvalidArgument unless there are `number` support tensors of this dimension; `whose` is
// "target " or "particle ".
template <class Scalar>
void require_tensors(const FieldView<double>& tensors, int dimension, std::size_t number,
                     const std::string& whose, const char* number_rule);
// The same for packed tensors of a list.
template <class Scalar>
void require_packed_tensors(const Array<Scalar>& tensors, int dimension, const std::string& whose);

}  // namespace detail
}  // namespace recon
