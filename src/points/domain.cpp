#include "recon/points/domain.hpp"

#include <string>

namespace recon {

template <class Scalar>
Box<Scalar> bounding_box(const PointsView<Scalar>& points, const char* name) {
  const int dimension = points.dimension();
  auto box = Box<Scalar>::empty(dimension);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int d = 0; d < dimension; ++d) {
      const Scalar x = points(i, d);
      if (!std::isfinite(x))
        detail::throw_invalid(std::string("coordinate ") + "xyz"[d] + " of point " +
                                  std::to_string(i) + " of the " + name,
                              x, "must be finite");
      box.add(d, x);
    }
  return box;
}

template Box<float> bounding_box(const PointsView<float>&, const char*);
template Box<double> bounding_box(const PointsView<double>&, const char*);

}  // namespace recon
