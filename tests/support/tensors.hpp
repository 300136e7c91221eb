// Support tensors to test with: of any orientation, drawn at random.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "recon/points/generate.hpp"

namespace recon::testing {

template <int D>
using Matrix = Eigen::Matrix<double, D, D>;

template <int D>
Matrix<D> random_rotation(RandomNumbers& random) {
  Matrix<D> m;
  for (int i = 0; i < D; ++i)
    for (int j = 0; j < D; ++j) m(i, j) = random.uniform(-1, 1);
  const Eigen::HouseholderQR<Matrix<D>> qr(m);
  return qr.householderQ();
}

// With half axes from `least` to `largest`, evenly by their logarithms.
template <int D>
std::vector<Matrix<D>> random_tensors(std::size_t count, double least, double largest,
                                      std::uint64_t seed) {
  RandomNumbers random(seed);
  std::vector<Matrix<D>> tensors;
  for (std::size_t i = 0; i < count; ++i) {
    const Matrix<D> axes = random_rotation<D>(random);
    Eigen::Matrix<double, D, 1> half;
    for (int d = 0; d < D; ++d) half[d] = least * std::pow(largest / least, random.uniform());
    const Matrix<D> tensor = axes * half.asDiagonal() * axes.transpose();
    tensors.push_back((tensor + tensor.transpose()) / 2);
  }
  return tensors;
}

// The tensors of the same ellipsoids after x -> map x.
template <int D>
std::vector<Matrix<D>> mapped_tensors(const std::vector<Matrix<D>>& tensors, const Matrix<D>& map) {
  std::vector<Matrix<D>> mapped;
  for (const Matrix<D>& tensor : tensors) {
    const Matrix<D> square = map * tensor * tensor * map.transpose();
    mapped.push_back(Eigen::SelfAdjointEigenSolver<Matrix<D>>(square).operatorSqrt());
  }
  return mapped;
}

template <class Scalar, int D>
Eigen::Matrix<double, D, 1> vector_of(const std::array<Scalar, D>& x) {
  Eigen::Matrix<double, D, 1> v;
  for (int d = 0; d < D; ++d) v[d] = static_cast<double>(x[d]);
  return v;
}

template <int D>
PointList<double, D> mapped_points(const PointList<double, D>& points, const Matrix<D>& map) {
  PointList<double, D> mapped;
  for (const auto& x : points) {
    const Eigen::Matrix<double, D, 1> y = map * vector_of<double, D>(x);
    std::array<double, D> at;
    for (int d = 0; d < D; ++d) at[d] = y[d];
    mapped.push_back(at);
  }
  return mapped;
}

}  // namespace recon::testing
