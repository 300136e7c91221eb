// The clouds, targets and the field of the accuracy studies.
//
// The field is smooth, of size 1, with gradients up to pi:
//     u(x) = prod_d sin(pi x_d + (d + 1) / 2)
// so that an error of 1e-3 is a thousandth of the field, and a spacing h has pi h
// radians per particle.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "recon/points/generate.hpp"

namespace recon_bench {

template <class Scalar, std::size_t D>
double field(const std::array<Scalar, D>& x) {
  double u = 1;
  for (std::size_t d = 0; d < D; ++d)
    u *= std::sin(std::numbers::pi * static_cast<double>(x[d]) + 0.5 * static_cast<double>(d + 1));
  return u;
}

template <class Scalar, std::size_t D>
std::array<double, D> field_gradient(const std::array<Scalar, D>& x) {
  std::array<double, D> gradient;
  gradient.fill(std::numbers::pi);
  for (std::size_t a = 0; a < D; ++a)
    for (std::size_t d = 0; d < D; ++d) {
      const double angle =
          std::numbers::pi * static_cast<double>(x[d]) + 0.5 * static_cast<double>(d + 1);
      gradient[a] *= a == d ? std::cos(angle) : std::sin(angle);
    }
  return gradient;
}

enum class CloudKind { regular, jittered, random, clustered, one_sided, plane, line };

constexpr const char* name_of(CloudKind kind) {
  constexpr const char* names[] = {"regular",   "jittered",          "random",          "clustered",
                                   "one-sided", "flattened (plane)", "flattened (line)"};
  return names[static_cast<int>(kind)];
}

// Particles, and targets at which their field is wanted.
template <class Scalar, int D>
struct Setting {
  recon::PointList<Scalar, D> points, targets;
  double spacing = 0;  // volume per particle to the power 1 / D, a length
};

template <int D>
recon::PointList<double, D> inner_targets(std::size_t count, std::uint64_t seed) {
  auto targets = recon::random_points<double, D>(count, seed);
  for (auto& x : targets)
    for (double& c : x) c = 0.1 + 0.8 * c;
  return targets;
}

// A cloud with about 1 / per_axis between particles. Targets lie inside; for the one-sided cloud on
// its border and up to half a spacing outside; for the flattened ones within the flat cloud.
//   clustered   groups of 5 particles in a fifth of the room that they have
//   one-sided   random, in half of the cube
//   flattened   random, squeezed to 1e-3 of the width along one axis (plane) or all but one (line)
template <int D>
Setting<double, D> make_setting(CloudKind kind, std::size_t per_axis, std::size_t target_count) {
  using namespace recon;
  std::size_t count = 1;
  for (int d = 0; d < D; ++d) count *= per_axis;
  const double spacing = 1.0 / static_cast<double>(per_axis);
  Setting<double, D> s{{}, inner_targets<D>(target_count, 11), spacing};
  const int flat = kind == CloudKind::line ? D - 1 : 1;
  switch (kind) {
    case CloudKind::regular:
      s.points = regular_points<double, D>(per_axis);
      break;
    case CloudKind::jittered:
      s.points = jittered_points<double, D>(per_axis, 0.3, 12);
      break;
    case CloudKind::random:
      s.points = random_points<double, D>(count, 13);
      break;
    case CloudKind::clustered:
      s.points =
          clustered_points<double, D>(count, count / 5, 0.1 * spacing * std::pow(5, 1.0 / D), 14);
      break;
    case CloudKind::one_sided: {
      s.points = one_sided_points<double, D>(count / 2, 15);
      RandomNumbers random(16);
      for (auto& x : s.targets) x[0] = 0.5 - 0.5 * spacing * random.uniform();
      break;
    }
    case CloudKind::plane:
    case CloudKind::line:
      count = 1;
      for (int d = 0; d < D - flat; ++d) count *= per_axis;
      s.points = flat_points<double, D>(count, flat, 1e-3, 17);
      for (auto& x : s.targets)
        for (int d = D - flat; d < D; ++d) x[d] = 0.5 + 1e-3 * (x[d] - 0.5);
      break;
  }
  return s;
}

template <class Scalar, int D>
recon::PointList<Scalar, D> rounded(const recon::PointList<double, D>& points) {
  recon::PointList<Scalar, D> out(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int d = 0; d < D; ++d) out[i][d] = static_cast<Scalar>(points[i][d]);
  return out;
}

template <class Scalar, std::size_t D>
std::vector<Scalar> field_at(const std::vector<std::array<Scalar, D>>& points) {
  std::vector<Scalar> u;
  for (const auto& x : points) u.push_back(static_cast<Scalar>(field(x)));
  return u;
}

// The support radius in which a random cloud of this spacing has `count` neighbours on average.
template <int D>
double radius_for(std::size_t count, double spacing) {
  constexpr double unit_ball[] = {2, std::numbers::pi, 4 * std::numbers::pi / 3};
  return spacing * std::pow(static_cast<double>(count) / unit_ball[D - 1], 1.0 / D);
}

}  // namespace recon_bench
