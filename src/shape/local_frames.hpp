// Where supports are ellipsoids: coordinates of each target in which its own is a ball.
//
//     y = F (x_p - x) ,   F = rho A^-1 ,   a length, so that |y| / rho = |A^-1 (x_p - x)| = q ,
//
// with the tensor A and the radius rho of the target. A fit in y is a fit in x, because the
// polynomials are the same; derivatives go back by d / dx = F d / dy. Where the supports belong to
// pairs, with the tensor A_p, the weight is that of
//     q = |A_p^-1 (x_p - x)| ,   q dq / dxi = A A_p^-1 A_p^-1 (x_p - x) ,   xi = y / rho .
#pragma once

#include <cmath>
#include <vector>

#include "recon/neighbourhood/support_tensor.hpp"
#include "recon/shape/shape_kernel.hpp"

namespace recon::detail {

// Those of a block of targets, with memory that is kept.
template <class Scalar, int D>
class LocalFrames {
 public:
  // The targets begin <= t < end; with `slopes` q dq / dxi of the pairs, where there are any.
  void prepare(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
               bool slopes) {
    const NeighbourListView<Scalar>& list = problem.neighbours;
    begin_ = begin;
    first_ = list.offsets[begin];
    const auto entries = static_cast<std::size_t>(list.offsets[end] - first_);
    frame_.resize(end - begin);
    size_.resize((end - begin) * D);
    offset_.resize(entries * D);
    distance_.resize(list.pair_tensor ? entries : 0);
    slope_.resize(list.pair_tensor && slopes ? entries * D : 0);
    for (std::size_t t = begin; t < end; ++t) prepare(problem, t);
  }

  // Of target t: how large its coordinates are, in y, along each axis.
  const Scalar* size(std::size_t t) const { return size_.data() + (t - begin_) * D; }
  // Of an entry of the list: y, and of a pair q and q dq / dxi; null where pairs have no tensors.
  const Scalar* offset(std::int64_t entry) const { return offset_.data() + (entry - first_) * D; }
  const Scalar* distance(std::int64_t entry) const {
    return distance_.empty() ? nullptr : distance_.data() + (entry - first_);
  }
  const Scalar* slope(std::int64_t entry) const {
    return slope_.empty() ? nullptr : slope_.data() + (entry - first_) * D;
  }

  // F times 1 / stretch, from (x_p - x) of the caller's coordinates to y.
  std::array<std::array<double, D>, D> from_callers(const ShapeProblem<Scalar>& problem,
                                                    std::size_t t) const {
    std::array<std::array<double, D>, D> map{};
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b)
        map[a][b] = frame_[t - begin_](a, b) * static_cast<double>(problem.axis_scale[b]);
    return map;
  }

  // Turns derivatives along y, in the rows of all these targets, into those of the caller's
  // coordinates.
  void turn_back(const ShapeProblem<Scalar>& problem, std::size_t end,
                 const ShapeRows<Scalar>& rows) const {
    constexpr int seconds = D * (D + 1) / 2;
    for (std::size_t t = begin_; t < end && (rows.gradient || rows.hessian); ++t) {
      const auto map = from_callers(problem, t);
      for (std::int64_t e = problem.neighbours.offsets[t]; e < problem.neighbours.offsets[t + 1];
           ++e) {
        if (rows.gradient) turn_gradient(map, rows.gradient + e * D);
        if (rows.hessian) turn_hessian(map, rows.hessian + e * seconds);
      }
    }
  }

 private:
  using Map = std::array<std::array<double, D>, D>;
  using Tensor = SymmetricTensor<D>;

  void prepare(const ShapeProblem<Scalar>& problem, std::size_t t) {
    const NeighbourListView<Scalar>& list = problem.neighbours;
    const std::array<Scalar, D> x = problem.targets.template point<D>(t);
    const double rho = static_cast<double>(list.support[t]);
    const Tensor tensor =
        list.tensor ? Tensor::at(list.tensor + t * Tensor::size) : Tensor::ball(rho);
    const Tensor frame = list.tensor ? tensor.inverse() * rho : Tensor::ball(1);
    frame_[t - begin_] = frame;
    for (int a = 0; a < D; ++a) {
      double size = 0;
      for (int b = 0; b < D; ++b) size += std::abs(frame(a, b) * static_cast<double>(x[b]));
      size_[(t - begin_) * D + static_cast<std::size_t>(a)] = static_cast<Scalar>(size);
    }
    for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
      std::array<double, D> apart;
      for (int d = 0; d < D; ++d) {
        Scalar along = problem.particles(list.indices[e], d) - x[d];
        if (list.shifts && problem.domain.periodic[d])
          along += static_cast<Scalar>(list.shifts[e][d]) * problem.domain.period(d);
        apart[d] = static_cast<double>(along);
      }
      const std::int64_t i = e - first_;
      const auto y = frame.times(apart);
      for (int d = 0; d < D; ++d) offset_[i * D + d] = static_cast<Scalar>(y[d]);
      if (!list.pair_tensor) continue;
      const Tensor inverse = Tensor::at(list.pair_tensor + e * Tensor::size).inverse();
      const auto eta = inverse.times(apart);
      double q2 = 0;
      for (const double along : eta) q2 += along * along;
      distance_[i] = static_cast<Scalar>(std::sqrt(q2));
      if (slope_.empty()) continue;
      const auto outwards = tensor.times(inverse.times(eta));
      for (int d = 0; d < D; ++d) slope_[i * D + d] = static_cast<Scalar>(outwards[d]);
    }
  }

  static void turn_gradient(const Map& map, Scalar* gradient) {
    std::array<double, D> turned{};
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) turned[b] += map[a][b] * static_cast<double>(gradient[a]);
    for (int d = 0; d < D; ++d) gradient[d] = static_cast<Scalar>(turned[d]);
  }

  static void turn_hessian(const Map& map, Scalar* packed) {
    const Tensor hessian = Tensor::at(packed);
    for (int i = 0; i < D; ++i)
      for (int j = i; j < D; ++j) {
        double sum = 0;
        for (int a = 0; a < D; ++a)
          for (int b = 0; b < D; ++b) sum += map[a][i] * hessian(a, b) * map[b][j];
        packed[Tensor::place(i, j)] = static_cast<Scalar>(sum);
      }
  }

  std::size_t begin_ = 0;
  std::int64_t first_ = 0;
  std::vector<Tensor> frame_;  // F
  std::vector<Scalar> size_, offset_, distance_, slope_;
};

}  // namespace recon::detail
