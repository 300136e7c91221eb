// From particles to a grid and back: values with one operator, forces with its transpose.
//
// A particle code often needs both directions. The transpose of the map that makes nodal values of
// particle data takes nodal forces to particles with the same weights, so that the power is the
// same on both sides:
//     sum over nodes f . (A v)  =  sum over particles (A^T f) . v
// The program checks this, and that a linear velocity field arrives exactly, and prints the
// numbers.
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

#include "recon/points/generate.hpp"

struct Particle {
  std::array<double, 2> x;
  std::array<double, 2> v;
};

int main() {
  std::vector<Particle> particles;
  for (const auto& x : recon::jittered_points<double, 2>(40, 0.3, 1))
    particles.push_back({x, {1 + x[1], 3 - 2 * x[0]}});  // a linear field

  recon::StructuredGrid<double> grid{
      .dimension = 2, .origin = {0, 0}, .spacing = {0.05, 0.05}, .counts = {21, 21, 1}};
  const auto nodes = grid.nodes();
  const auto points = recon::points_of(particles, &Particle::x);
  const auto fit =
      recon::reconstruct(points, nodes.view(), {.degree = 1, .neighbours = recon::Radius{0.1}});

  const auto velocity = recon::field_of(particles, &Particle::v);
  const Eigen::MatrixXd nodal_velocity = fit.apply(velocity);
  double error = 0;
  for (std::size_t n = 0; n < grid.size(); ++n)
    error = std::max(error, std::abs(nodal_velocity(n, 0) - (1 + nodes.view()(n, 1))));

  Eigen::MatrixXd nodal_force(grid.size(), 2);
  for (std::size_t n = 0; n < grid.size(); ++n)
    nodal_force.row(n) << std::sin(7.0 * nodes.view()(n, 0)), std::cos(5.0 * nodes.view()(n, 1));
  const Eigen::MatrixXd force = fit.apply_transpose(recon::field_of(nodal_force));

  const double nodal_power = (nodal_force.array() * nodal_velocity.array()).sum();
  double power = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    power += force(p, 0) * particles[p].v[0] + force(p, 1) * particles[p].v[1];

  std::printf("linear field at the nodes: largest error %.1e\n", error);
  std::printf("power of the nodal forces %.12f, of the particle forces %.12f\n", nodal_power,
              power);
  std::printf("%zu of %zu nodes reproduce linear fields\n", fit.report().summary().full,
              fit.report().size());
  return error < 1e-12 && std::abs(power - nodal_power) < 1e-10 ? 0 : 1;
}
