// Visibility: a particle behind a wall is no neighbour, however near.
//
// A thin plate at y = 0 for x < 0 parts two streams, v = 1 above and v = -1 below. A target just
// above the plate must not see what flows beneath it; one beyond the plate's edge sees both.
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cstdio>

using Point = std::array<double, 2>;

// Does the straight line between them cross the plate?
bool crosses_plate(const Point& a, const Point& b) {
  if ((a[1] > 0) == (b[1] > 0)) return false;
  return a[0] + (b[0] - a[0]) * a[1] / (a[1] - b[1]) < 0;
}

int main() {
  std::vector<Point> particles = recon::jittered_points<double, 2>(30, 0.3, 1);
  std::vector<double> v;
  for (Point& p : particles) {
    p = {2 * p[0] - 1, 2 * p[1] - 1};
    v.push_back(p[1] > 0 ? 1 : -1);
  }
  const std::vector<Point> targets{{-0.5, 0.05}, {-0.5, -0.05}, {0.5, 0.0}};

  recon::Options options{.degree = 1, .neighbours = recon::Radius{0.2}};
  const auto points = recon::points_of(particles), places = recon::points_of(targets);
  const Eigen::MatrixXd blind =
      recon::reconstruct(points, places, options).apply(recon::field_of(v));
  options.visible = [&](std::size_t target, std::size_t particle) {
    return !crosses_plate(targets[target], particles[particle]);
  };
  const Eigen::MatrixXd seen =
      recon::reconstruct(points, places, options).apply(recon::field_of(v));
  for (std::size_t t = 0; t < targets.size(); ++t)
    std::printf("(%4.1f, %5.2f): %6.3f through the plate, %6.3f with it\n", targets[t][0],
                targets[t][1], blind(t, 0), seen(t, 0));
}

// Output
// (-0.5,  0.05):  0.721 through the plate,  1.000 with it
// (-0.5, -0.05): -0.532 through the plate, -1.000 with it
// ( 0.5,  0.00):  0.042 through the plate,  0.042 with it
