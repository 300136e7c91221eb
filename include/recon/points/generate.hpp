// Point sets to test with: regular, jittered, random, and the degenerate ones that break fits.
//
// All lie in the unit cube unless said otherwise. They are functions of their arguments alone (a
// fixed generator written here, not the standard library's distributions, whose values differ
// between libraries), so a failure found on one machine is found on all.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace recon {

// A list of points of dimension D; points_of(list) views it.
template <class Scalar, int D>
using PointList = std::vector<std::array<Scalar, D>>;

// splitmix64 (Steele, Lea, Flood 2014): small, fast, and the same everywhere.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  // Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }

 private:
  std::uint64_t state_;
};

// n^D points at the centres of the cells of a regular grid of n cells per axis.
template <class Scalar, int D>
PointList<Scalar, D> regular_points(std::size_t n) {
  PointList<Scalar, D> points;
  std::size_t total = 1;
  for (int d = 0; d < D; ++d) total *= n;
  points.reserve(total);
  for (std::size_t i = 0; i < total; ++i) {
    std::array<Scalar, D> x;
    std::size_t rest = i;
    for (int d = 0; d < D; ++d, rest /= n)
      x[d] = (static_cast<Scalar>(rest % n) + Scalar(0.5)) / static_cast<Scalar>(n);
    points.push_back(x);
  }
  return points;
}

// The regular_points, each moved by up to `amount` cells along each axis (0.5:
// anywhere in its cell).
template <class Scalar, int D>
PointList<Scalar, D> jittered_points(std::size_t n, double amount, std::uint64_t seed) {
  RandomNumbers random(seed);
  auto points = regular_points<Scalar, D>(n);
  for (auto& x : points)
    for (Scalar& c : x)
      c += static_cast<Scalar>(random.uniform(-amount, amount) / static_cast<double>(n));
  return points;
}

// Random points, independent and uniform in the unit cube.
template <class Scalar, int D>
PointList<Scalar, D> random_points(std::size_t count, std::uint64_t seed) {
  RandomNumbers random(seed);
  PointList<Scalar, D> points(count);
  for (auto& x : points)
    for (Scalar& c : x) c = static_cast<Scalar>(random.uniform());
  return points;
}

// Random points squeezed towards the centre of the cube by the factor `thickness` along the last
// `flat_axes` axes: 0 gives points exactly on a plane or a line, 1e-3 almost so.
template <class Scalar, int D>
PointList<Scalar, D> flat_points(std::size_t count, int flat_axes, double thickness,
                                 std::uint64_t seed) {
  auto points = random_points<Scalar, D>(count, seed);
  for (auto& x : points)
    for (int d = D - flat_axes; d < D; ++d)
      x[d] = static_cast<Scalar>(0.5 + thickness * (static_cast<double>(x[d]) - 0.5));
  return points;
}

// Random points on the line from one corner of the cube to the opposite one.
template <class Scalar, int D>
PointList<Scalar, D> diagonal_points(std::size_t count, std::uint64_t seed) {
  RandomNumbers random(seed);
  PointList<Scalar, D> points(count);
  for (auto& x : points) x.fill(static_cast<Scalar>(random.uniform()));
  return points;
}

// Random points on a sphere (in 2-D a circle, in 1-D two points) of the given radius about the
// centre of the unit cube.
template <class Scalar, int D>
PointList<Scalar, D> sphere_points(std::size_t count, double radius, std::uint64_t seed) {
  RandomNumbers random(seed);
  PointList<Scalar, D> points;
  while (points.size() < count) {
    double x[D], norm2 = 0;  // uniform direction: a point of the ball, brought to its surface
    for (double& c : x) {
      c = random.uniform(-1, 1);
      norm2 += c * c;
    }
    if (norm2 > 1 || norm2 < 1e-4) continue;
    std::array<Scalar, D> point;
    for (int d = 0; d < D; ++d)
      point[d] = static_cast<Scalar>(0.5 + radius * x[d] / std::sqrt(norm2));
    points.push_back(point);
  }
  return points;
}

// Random points in `clusters` balls of the given radius, at random places: many near, most far.
template <class Scalar, int D>
PointList<Scalar, D> clustered_points(std::size_t count, std::size_t clusters, double radius,
                                      std::uint64_t seed) {
  RandomNumbers random(seed);
  const auto centres = random_points<Scalar, D>(clusters, random.next());
  PointList<Scalar, D> points(count);
  for (std::size_t i = 0; i < count; ++i)
    for (int d = 0; d < D; ++d)
      points[i][d] = static_cast<Scalar>(static_cast<double>(centres[i % clusters][d]) +
                                         radius * random.uniform(-1, 1));
  return points;
}

// Each of `count` random points `copies` times.
template <class Scalar, int D>
PointList<Scalar, D> duplicated_points(std::size_t count, std::size_t copies, std::uint64_t seed) {
  const auto once = random_points<Scalar, D>(count, seed);
  PointList<Scalar, D> points;
  for (std::size_t c = 0; c < copies; ++c) points.insert(points.end(), once.begin(), once.end());
  return points;
}

// A dense cloud with holes, such as a flow around obstacles has: jittered_points of n^D cells (by
// 0.3 of a cell) without those in `holes` balls of the given radius at random places.
template <class Scalar, int D>
PointList<Scalar, D> points_with_holes(std::size_t n, std::size_t holes, double radius,
                                       std::uint64_t seed) {
  RandomNumbers random(seed);
  const auto centres = random_points<Scalar, D>(holes, random.next());
  PointList<Scalar, D> points;
  for (const auto& x : jittered_points<Scalar, D>(n, 0.3, random.next())) {
    bool outside = true;
    for (const auto& centre : centres) {
      double square = 0;
      for (int d = 0; d < D; ++d) {
        const double offset = static_cast<double>(x[d]) - static_cast<double>(centre[d]);
        square += offset * offset;
      }
      outside = outside && square > radius * radius;
    }
    if (outside) points.push_back(x);
  }
  return points;
}

// A heap on the bottom of the cube: jittered_points of n^D cells (by 0.3 of a cell) below a surface
// whose height falls from 0.9 to 0.1 along the first axis. The box of the points is half empty.
template <class Scalar, int D>
PointList<Scalar, D> heap_points(std::size_t n, std::uint64_t seed) {
  PointList<Scalar, D> points;
  for (const auto& x : jittered_points<Scalar, D>(n, 0.3, seed))
    if (static_cast<double>(x[D - 1]) < 0.1 + 0.8 * std::pow(1 - static_cast<double>(x[0]), 2))
      points.push_back(x);
  return points;
}

// Random points with the first coordinate in [1/2, 1): a target at x < 1/2 sees them on one side.
template <class Scalar, int D>
PointList<Scalar, D> one_sided_points(std::size_t count, std::uint64_t seed) {
  auto points = random_points<Scalar, D>(count, seed);
  for (auto& x : points) x[0] = (1 + x[0]) / 2;
  return points;
}

}  // namespace recon
