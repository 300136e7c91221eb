// Coordinates gathered once into an own, contiguous copy: what searches and solvers read.
//
// Views may have any stride or hide coordinates behind functions; a PointCloud has the coordinates
// of one point after those of another, checked to be finite and wrapped into the periodic domain.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "recon/core/array.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon {

template <class Scalar>
class PointCloud {
 public:
  PointCloud() = default;

  // Copies the points; with a domain, into its periodic image [lower, upper). Throws
  // InvalidArgument for coordinates that are not finite and for more than 2^32 - 2 points; `name`
  // is what messages call them. threads as in parallel_blocks.
  explicit PointCloud(const PointsView<Scalar>& points, const char* name = "points",
                      const PeriodicDomain<Scalar>& domain = {}, int threads = 0);

  // As the constructor does, into the memory of this cloud where that is large enough.
  void assign(const PointsView<Scalar>& points, const char* name = "points",
              const PeriodicDomain<Scalar>& domain = {}, int threads = 0);

  // The points order[0], order[1], ... of another cloud, into the memory of this one. The box stays
  // that of the other cloud, whichever of its points are taken.
  void assign_permuted(const PointCloud& other, std::span<const std::uint32_t> order,
                       int threads = 0);
  // The same as a new cloud.
  PointCloud permuted(std::span<const std::uint32_t> order, int threads = 0) const;

  std::size_t size() const { return size_; }
  int dimension() const { return dimension_; }
  const Box<Scalar>& box() const { return box_; }
  Scalar operator()(std::size_t point, int d) const {
    return coordinates_[point * static_cast<std::size_t>(dimension_) + d];
  }
  // All coordinates, x0 y0 z0 x1 y1 z1 ..., dimension() numbers per point.
  const Scalar* data() const { return coordinates_.data(); }

  // Point i as an array of D numbers, for code that knows the dimension.
  template <int D>
  std::array<Scalar, D> point(std::size_t i) const {
    std::array<Scalar, D> x;
    for (int d = 0; d < D; ++d) x[d] = coordinates_[i * D + d];
    return x;
  }

  PointsView<Scalar> view() const {
    const auto stride = static_cast<std::ptrdiff_t>(sizeof(Scalar)) * dimension_;
    std::array<const void*, max_dimension> first{};
    for (int d = 0; d < dimension_ && size_ > 0; ++d) first[d] = coordinates_.data() + d;
    return {size_, dimension_, first, {stride, stride, stride}};
  }

 private:
  // Coordinates along axis d of the points of a range, with their extent.
  void copy_axis(const PointsView<Scalar>& points, std::size_t begin, std::size_t end, int d,
                 const char* name, const PeriodicDomain<Scalar>& domain, Box<Scalar>& box);

  int dimension_ = 1;
  std::size_t size_ = 0;
  Array<Scalar> coordinates_;
  Box<Scalar> box_ = Box<Scalar>::empty(1);
};

extern template class PointCloud<float>;
extern template class PointCloud<double>;

}  // namespace recon
