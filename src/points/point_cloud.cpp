#include "recon/points/point_cloud.hpp"

#include <algorithm>
#include <cmath>

namespace recon {

template <class Scalar>
PointCloud<Scalar>::PointCloud(const PointsView<Scalar>& points, const char* name,
                               const PeriodicDomain<Scalar>& domain)
    : dimension_(points.dimension()), box_(bounding_box(points, name)) {
  require(points.size() < 0xFFFFFFFFu, name, points.size(), "must be fewer than 2^32 - 1 points");
  domain.validate(dimension_);
  for (int d = 0; d < dimension_; ++d) {
    axes_[d].resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) axes_[d][i] = domain.wrap(points(i, d), d);
    if (domain.periodic[d] && points.size() > 0) {
      box_.lower[d] = box_.upper[d] = axes_[d][0];
      for (const Scalar x : axes_[d]) box_.add(d, x);
    }
  }
  // Distances are squared: a box whose diagonal overflows would make every comparison meaningless.
  Scalar diagonal = 0;
  for (int d = 0; d < dimension_ && !box_.is_empty(); ++d) {
    const Scalar size = std::max(std::abs(box_.lower[d]), std::abs(box_.upper[d]));
    diagonal += 4 * size * size;
  }
  require(std::isfinite(diagonal), name, diagonal,
          "must have coordinates whose squares can be represented");
}

template class PointCloud<float>;
template class PointCloud<double>;

}  // namespace recon
