// A kept index: particles that move are copied and ordered anew into the memory that is there.
//
// Sources hold the cloud for any number of questions; an update moves it. What was made before is
// refused until it is updated itself, so that no answer mixes old places with new data. Tracers are
// carried around a centre by the velocity that the particles show them.
#include <recon/operators/kernel_sum.hpp>
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>

int main() {
  auto particles = recon::jittered_points<double, 2>(40, 0.3, 1);
  std::vector<std::array<double, 2>> tracers{{0.7, 0.5}, {0.5, 0.6}};
  const double dt = 0.01;
  const auto turn = [](const std::array<double, 2>& x) {
    return std::array{0.5 - x[1], x[0] - 0.5};
  };

  recon::Sources sources(recon::points_of(particles));
  auto fit = recon::reconstruct(sources, recon::points_of(tracers), {.degree = 2});
  int refused = 0;
  for (int step = 0; step < 157; ++step) {  // a quarter of a turn takes pi / 2
    std::vector<std::array<double, 2>> velocity;
    for (auto& x : particles) velocity.push_back(turn(x));
    const Eigen::MatrixXd v = fit.apply(recon::field_of(velocity));
    for (std::size_t t = 0; t < tracers.size(); ++t)
      for (int d = 0; d < 2; ++d) tracers[t][d] += dt * v(t, d);
    for (std::size_t p = 0; p < particles.size(); ++p)
      for (int d = 0; d < 2; ++d) particles[p][d] += dt * velocity[p][d];
    sources.update(recon::points_of(particles));
    try {
      fit.apply(recon::field_of(velocity));
    } catch (const recon::InvalidArgument&) {
      ++refused;
    }
    fit.update(recon::points_of(tracers));
  }
  const std::vector<double> one(particles.size(), 1.0);
  const Eigen::MatrixXd crowd = recon::kernel_sum(
      sources, recon::points_of(tracers), recon::field_of(one), recon::Weight::cubic_b_spline, 0.1);
  std::printf("tracers at (%.3f, %.3f) and (%.3f, %.3f); %d fits of old places refused\n",
              tracers[0][0], tracers[0][1], tracers[1][0], tracers[1][1], refused);
  std::printf("particles per area about the first: %.0f\n", crowd(0, 0));
}

// Output
// tracers at (0.500, 0.702) and (0.399, 0.500); 157 fits of old places refused
// particles per area about the first: 1598
