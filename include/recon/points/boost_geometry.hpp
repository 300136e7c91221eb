// points_of for any type registered as a Boost.Geometry point. Include it when you want it:
// recon.hpp does not, so that nobody pays for Boost's headers unasked.
//
// Coordinates are read through boost::geometry::get, so types with accessors work too.
#pragma once

#include <boost/geometry/core/access.hpp>
#include <boost/geometry/core/coordinate_dimension.hpp>
#include <boost/geometry/core/coordinate_type.hpp>
#include <boost/geometry/core/tag.hpp>
#include <boost/geometry/core/tags.hpp>

#include "recon/points/make_view.hpp"

namespace recon {

template <class T>
concept BoostPoint =
    std::same_as<typename boost::geometry::tag<T>::type, boost::geometry::point_tag>;

// A view of an array of Boost.Geometry points of dimension 1 to 3 with float or double coordinates.
template <detail::StableArray Range>
requires(BoostPoint<std::ranges::range_value_t<Range>> &&
         !detail::HasLayout<std::ranges::range_value_t<Range>>) auto points_of(Range&& elements) {
  namespace bg = boost::geometry;
  using Point = std::ranges::range_value_t<Range>;
  using Scalar = typename bg::coordinate_type<Point>::type;
  constexpr int dimension = static_cast<int>(bg::dimension<Point>::value);
  static_assert(dimension >= 1 && dimension <= max_dimension, "points have 1, 2 or 3 coordinates");
  static_assert(detail::is_scalar<Scalar>, "coordinates are float or double");

  std::array<typename PointsView<Scalar>::Reader, max_dimension> readers{};
  const auto set = [&]<std::size_t... Axis>(std::index_sequence<Axis...>) {
    ((readers[Axis] =
          [](const void* at) {
            return static_cast<Scalar>(bg::get<Axis>(*static_cast<const Point*>(at)));
          }),
     ...);
  };
  set(std::make_index_sequence<dimension>{});
  return PointsView<Scalar>(std::ranges::size(elements), dimension, std::ranges::data(elements),
                            sizeof(Point), readers);
}

}  // namespace recon
