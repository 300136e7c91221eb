// Boxes, and periodic domains that are periodic in any choice of axes.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "recon/core/error.hpp"
#include "recon/points/view.hpp"

namespace recon {

// An axis-aligned box in up to three dimensions; empty (lower > upper) until something is added.
template <class Scalar>
struct Box {
  std::array<Scalar, max_dimension> lower{}, upper{};
  int dimension = 3;

  static Box empty(int dimension) {
    Box box;
    box.dimension = dimension;
    for (int d = 0; d < dimension; ++d) {
      box.lower[d] = std::numeric_limits<Scalar>::infinity();
      box.upper[d] = -std::numeric_limits<Scalar>::infinity();
    }
    return box;
  }

  bool is_empty() const { return dimension < 1 || lower[0] > upper[0]; }
  Scalar extent(int axis) const { return upper[axis] - lower[axis]; }

  void add(int axis, Scalar coordinate) {
    if (coordinate < lower[axis]) lower[axis] = coordinate;
    if (coordinate > upper[axis]) upper[axis] = coordinate;
  }
};

namespace detail {

// How messages call a coordinate: "coordinate y of point 7 of the targets".
std::string coordinate_name(std::size_t point, int axis, const char* points);

}  // namespace detail

// The box of all points; empty for no points. Throws InvalidArgument where a coordinate is not
// finite, naming the point and the axis; `name` is what the message calls the points.
template <class Scalar>
Box<Scalar> bounding_box(const PointsView<Scalar>& points, const char* name = "points");

// A domain whose period along `axis` is upper - lower where periodic[axis] is set. The other axes
// are unbounded: lower and upper are not used there. The default domain is periodic nowhere.
template <class Scalar>
struct PeriodicDomain {
  std::array<Scalar, max_dimension> lower{}, upper{};
  std::array<bool, max_dimension> periodic{};

  bool any() const { return periodic[0] || periodic[1] || periodic[2]; }
  Scalar period(int axis) const { return upper[axis] - lower[axis]; }

  // The periodic image of a coordinate that lies in [lower, upper).
  Scalar wrap(Scalar coordinate, int axis) const {
    if (!periodic[axis]) return coordinate;
    const Scalar length = period(axis);
    Scalar wrapped = coordinate - std::floor((coordinate - lower[axis]) / length) * length;
    if (wrapped < lower[axis]) wrapped = lower[axis];  // rounding, just below the border
    if (wrapped >= upper[axis]) wrapped = lower[axis];
    return wrapped;
  }

  // Throws InvalidArgument unless every periodic axis has finite lower < upper.
  void validate(int dimension) const {
    for (int d = 0; d < max_dimension; ++d) {
      if (!periodic[d]) continue;
      detail::require(d < dimension, "periodic axis", d, "must be an axis of the points");
      detail::require(std::isfinite(lower[d]) && std::isfinite(upper[d]) && lower[d] < upper[d],
                      "period of the domain", upper[d] - lower[d], "must be positive and finite");
    }
  }
};

extern template Box<float> bounding_box(const PointsView<float>&, const char*);
extern template Box<double> bounding_box(const PointsView<double>&, const char*);

}  // namespace recon
