#include "recon/points/domain.hpp"
#include "core/instantiate.hpp"

#include <string>

namespace recon {

namespace detail {

std::string coordinate_name(std::size_t point, int axis, const char* points) {
  return std::string("coordinate ") + "xyz"[axis] + " of point " + std::to_string(point) +
         " of the " + points;
}

}  // namespace detail

template <class Scalar>
Box<Scalar> bounding_box(const PointsView<Scalar>& points, const char* name) {
  const int dimension = points.dimension();
  auto box = Box<Scalar>::empty(dimension);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int d = 0; d < dimension; ++d) {
      const Scalar x = points(i, d);
      if (!std::isfinite(x))
        detail::throw_invalid(detail::coordinate_name(i, d, name), x, "must be finite");
      box.add(d, x);
    }
  return box;
}

RECON_FLOAT(template Box<float> bounding_box(const PointsView<float>&, const char*);)
template Box<double> bounding_box(const PointsView<double>&, const char*);

}  // namespace recon
