// Kernel sums: how much lies at a place, per volume: density, number density, solid fraction.
//
// s(x) = sum_p a_p W(x - x_p), where W has the integral 1. Within the cloud s is the density; at
// its border half of the support is empty and s falls to half. Summed over a grid it is the mass.
#include <recon/operators/kernel_sum.hpp>
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cstdio>

int main() {
  const auto particles = recon::jittered_points<double, 2>(40, 0.1, 1);  // in the unit square
  const std::vector<double> mass(particles.size(), 3.0 / 1600);          // in all 3
  const recon::Sources sources(recon::points_of(particles));

  const std::vector<std::array<double, 2>> places{{0.5, 0.5}, {0, 0.5}, {0, 0}, {-0.2, 0.5}};
  const Eigen::MatrixXd density = recon::kernel_sum(
      sources, recon::points_of(places), recon::field_of(mass), recon::Weight::wendland_c4, 0.2);
  std::printf("density: inside %.2f, at an edge %.2f, at a corner %.2f, outside %.2f\n",
              density(0, 0), density(1, 0), density(2, 0), density(3, 0));

  const recon::StructuredGrid<double> grid{
      .dimension = 2, .origin = {-0.2, -0.2}, .spacing = {0.05, 0.05}, .counts = {29, 29, 1}};
  const auto nodes = grid.nodes();
  const Eigen::MatrixXd all = recon::kernel_sum(sources, nodes.view(), recon::field_of(mass),
                                                recon::Weight::wendland_c4, 0.2);
  std::printf("mass over a grid of spacing 0.05: %.3f\n", all.sum() * 0.05 * 0.05);
}

// Output
// density: inside 3.02, at an edge 1.50, at a corner 0.74, outside 0.00
// mass over a grid of spacing 0.05: 3.000
