// A program of another project: its own particles in its own struct, mapped to points with recon.
// Velocities are linear in space, and degree 1 reproduces them: exit status 0 if it did to 1e-12.
#include <array>
#include <cmath>
#include <cstdio>
#include <recon/recon.hpp>
#include <vector>

struct Grain {
  std::array<double, 3> position, velocity;
  double mass;
};

std::array<double, 3> velocity_at(const std::array<double, 3>& x) {
  return {1 + 2 * x[0] - x[1], 0.5 * x[2], 3 - x[0] + 0.25 * x[1] - 2 * x[2]};
}

int main() {
  const double h = 0.1;
  std::vector<Grain> grains;
  for (int i = 0; i < 1000; ++i) {
    const double a = i % 10, b = i / 10 % 10, c = i / 100;
    // A lattice, shaken so that no two neighbourhoods are alike.
    const std::array<double, 3> x = {h * (a + 0.3 * std::sin(7.0 * i)),
                                     h * (b + 0.3 * std::sin(11.0 * i)),
                                     h * (c + 0.3 * std::sin(13.0 * i))};
    grains.push_back({x, velocity_at(x), 1.0});
  }
  std::vector<std::array<double, 3>> nodes;
  for (int i = 0; i < 125; ++i)
    nodes.push_back({0.9 * (i % 5) / 4.0, 0.9 * (i / 5 % 5) / 4.0, 0.9 * (i / 25) / 4.0});

  auto points = recon::points_of(grains, &Grain::position);  // a view, no copy
  auto targets = recon::points_of(nodes);
  auto velocity = recon::field_of(grains, &Grain::velocity);

  recon::Reconstruction fit = recon::reconstruct(points, targets,
                                                 {.degree = 1,
                                                  .weight = recon::Weight::cubic_b_spline,
                                                  .neighbours = recon::Radius{2 * h},
                                                  .solver = recon::Solver::gram_schmidt});
  Eigen::MatrixXd v = fit.apply(velocity);  // a row per node
  Eigen::MatrixXd grad_v = fit.gradient().apply(velocity);
  Eigen::MatrixXd force = fit.apply_transpose(recon::field_of(v));

  double error = 0;
  for (std::size_t t = 0; t < nodes.size(); ++t)
    for (int c = 0; c < 3; ++c)
      error = std::fmax(error,
                        std::fabs(v(Eigen::Index(t), c) - velocity_at(nodes[t])[std::size_t(c)]));
  double gradient_error = 0;
  const double slopes[9] = {2, -1, 0, 0, 0, 0.5, -1, 0.25, -2};  // dvx/dx, dvx/dy, ...
  for (Eigen::Index t = 0; t < grad_v.rows(); ++t)
    for (int c = 0; c < 9; ++c)
      gradient_error = std::fmax(gradient_error, std::fabs(grad_v(t, c) - slopes[c]));
  // The shape functions at a node add up to 1, so what the nodes give is what the particles get.
  const double lost = (force.colwise().sum() - v.colwise().sum()).cwiseAbs().maxCoeff();

  std::printf("%zu nodes, %zu reduced; errors: value %.1e, gradient %.1e, transpose %.1e\n",
              nodes.size(), fit.report().reduced(), error, gradient_error, lost);
  const bool right = fit.report().reduced() == 0 && fit.report().no_support() == 0 &&
                     error <= 1e-12 && gradient_error <= 1e-10 && lost <= 1e-10;
  return right ? 0 : 1;
}
