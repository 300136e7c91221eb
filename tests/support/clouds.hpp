// The clouds every component must survive: even ones, and those that break fits and searches.
//
// At most about 200 points each, in or near the unit cube, the same on every machine
// (generate.hpp). "none" is empty: its PointCloud still has dimension D.
#pragma once

#include <string>
#include <vector>

#include "recon/points/generate.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::testing {

template <class Scalar, int D>
struct NamedCloud {
  std::string name;
  PointList<Scalar, D> points;
};

template <class Scalar, int D>
std::vector<NamedCloud<Scalar, D>> hostile_clouds() {
  constexpr std::size_t per_axis = D == 1 ? 40 : D == 2 ? 12 : 5;
  std::vector<NamedCloud<Scalar, D>> clouds{
      {"regular", regular_points<Scalar, D>(per_axis)},
      {"jittered", jittered_points<Scalar, D>(per_axis, 0.3, 1)},
      {"random", random_points<Scalar, D>(150, 2)},
      {"collinear along an axis", flat_points<Scalar, D>(60, D - 1, 0, 3)},
      {"on the diagonal", diagonal_points<Scalar, D>(60, 4)},
      {"duplicated", duplicated_points<Scalar, D>(30, 4, 5)},
      {"one-sided", one_sided_points<Scalar, D>(100, 6)},
      {"clustered at 1e-6", clustered_points<Scalar, D>(120, 5, 1e-6, 7)},
      {"on a sphere", sphere_points<Scalar, D>(100, 0.4, 8)},
      {"two points", random_points<Scalar, D>(2, 9)},
      {"single point", random_points<Scalar, D>(1, 10)},
      {"none", {}}};
  if constexpr (D >= 2) {
    clouds.push_back({"coplanar", flat_points<Scalar, D>(100, 1, 0, 11)});
    clouds.push_back({"almost flat", flat_points<Scalar, D>(100, 1, 1e-3, 12)});
  }
  return clouds;
}

template <class Scalar, std::size_t D>
PointCloud<Scalar> cloud_of(const std::vector<std::array<Scalar, D>>& points,
                            const PeriodicDomain<Scalar>& domain = {}) {
  return PointCloud<Scalar>(points_of(points), "points", domain);
}

}  // namespace recon::testing
