// FLIP in a particle code of one's own (Brackbill, Ruppel 1986; with the forces of the material
// point method, Sulsky, Chen, Schreyer 1994): the particles are a struct of that code, the grid's
// arrays are its own too, and recon has the functions of the grid, the sums into nodes and the way
// back.
//
//     nodes      m_i = sum_p S_ip m_p ,  m_i v_i = sum_p S_ip m_p v_p ,  f_i = sum_p V_p p_p G_ip
//     particles  v_p += dt sum_i S_ip f_i / m_i ,  x_p += dt sum_i S_ip (v_i + dt f_i / m_i)
//
// A drop with the pressure p = K (1 - V / V_0), which is pressed together and flies. sum_i S_ip = 1
// and sum_i G_ip = 0, so that its momentum stays what it was: the program checks this, and that the
// drop has got smaller and swung back.
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "recon/transfer/scatter.hpp"

struct Particle {
  std::array<double, 2> x, v;
  double mass, volume;
};
int main() {
  const recon::CartesianGrid<2> grid({0, 0}, {2, 1}, 0.05);
  const recon::SplineFunctions<2> functions;
  const double edge = 0.025, stiffness = 1, dt = 0.005;
  std::vector<Particle> particles;
  for (double x = 0.3125; x < 0.7; x += edge)
    for (double y = 0.3125; y < 0.7; y += edge)
      if (std::hypot(x - 0.5, y - 0.5) < 0.2)
        particles.push_back({{x, y}, {1.2 - 0.4 * x, 0.3 - 0.4 * y}, edge * edge, edge * edge});
  const auto place = [&](std::size_t p) { return particles[p].x; };
  const auto momentum = [&](int d) {
    double sum = 0;
    for (const Particle& p : particles) sum += p.mass * p.v[d];
    return sum;
  };
  const double before[] = {momentum(0), momentum(1)};
  const double at_rest = edge * edge * static_cast<double>(particles.size());
  double least = 1, volume = 1;  // of what it is at rest

  for (int step = 0; step < 100; ++step) {
    std::vector<double> mass(grid.size());
    std::vector<std::array<double, 2>> velocity(grid.size()), acceleration(grid.size());
    recon::scatter(grid, functions, particles.size(), place, [&](std::size_t n, const auto& at) {
      const Particle& p = particles[n];
      at.add(mass, p.mass);
      at.add(velocity, std::array{p.mass * p.v[0], p.mass * p.v[1]});
      const double push = p.volume * stiffness * (1 - p.volume / (edge * edge));
      at.add_gradient(acceleration, Eigen::Matrix2d{{push, 0}, {0, push}});
    });
    for (std::size_t i = 0; i < grid.size(); ++i)
      for (int d = 0; d < 2 && mass[i] > 0; ++d) {
        acceleration[i][d] /= mass[i];
        velocity[i][d] = velocity[i][d] / mass[i] + dt * acceleration[i][d];
      }
    recon::gather(grid, functions, particles.size(), place, [&](std::size_t n, const auto& at) {
      const auto v = at.value(velocity), a = at.value(acceleration);
      const double growth = 1 + dt * at.gradient(velocity).trace();
      Particle& p = particles[n];
      for (int d = 0; d < 2; ++d) p.v[d] += dt * a[d], p.x[d] += dt * v[d];
      p.volume *= growth;
    });
    volume = 0;
    for (const Particle& p : particles) volume += p.volume / at_rest;
    least = std::min(least, volume);
  }

  std::printf("momentum (%.15f, %.15f)\n", momentum(0), momentum(1));
  std::printf("volume %.3f, at least %.3f of what it is at rest\n", volume, least);
  const double lost = std::hypot(momentum(0) - before[0], momentum(1) - before[1]);
  return lost < 1e-13 && least < 0.98 && volume > 0.99 && volume < 1.1 ? 0 : 1;
}
