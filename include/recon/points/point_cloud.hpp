// Coordinates gathered once into an own, axis-by-axis copy: what searches and solvers read.
//
// Views may have any stride or hide coordinates behind functions; a PointCloud has one
// contiguous array per axis, checked to be finite and wrapped into the periodic domain.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon {

template <class Scalar>
class PointCloud {
 public:
  PointCloud() = default;

  // Copies the points; with a domain, into its periodic image [lower, upper). Throws
  // InvalidArgument for coordinates that are not finite and for more than 2^32 - 2 points; `name`
  // is what messages call them.
  explicit PointCloud(const PointsView<Scalar>& points, const char* name = "points",
                      const PeriodicDomain<Scalar>& domain = {});

  std::size_t size() const { return axes_[0].size(); }
  int dimension() const { return dimension_; }
  const Box<Scalar>& box() const { return box_; }
  std::span<const Scalar> axis(int d) const { return axes_[d]; }
  Scalar operator()(std::size_t point, int d) const { return axes_[d][point]; }

  // Point i as an array of D numbers, for code that knows the dimension.
  template <int D>
  std::array<Scalar, D> point(std::size_t i) const {
    std::array<Scalar, D> x;
    for (int d = 0; d < D; ++d) x[d] = axes_[d][i];
    return x;
  }

  PointsView<Scalar> view() const { return points_of_axes(axes_, dimension_); }

 private:
  int dimension_ = 1;
  std::array<std::vector<Scalar>, max_dimension> axes_;
  Box<Scalar> box_ = Box<Scalar>::empty(1);
};

extern template class PointCloud<float>;
extern template class PointCloud<double>;

}  // namespace recon
