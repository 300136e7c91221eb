// Functionals: what one may ask of the reconstructed field, each an operator on particle data.
//
// All are made in one go and add up. The field is the stream of a vortex, v = (-y, x) (1 - r^2):
// its divergence is 0, its curl 2 - 4 r^2; the local polynomials of degree 3 contain it.
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>

using F = recon::Functional;

int main() {
  const auto particles = recon::random_points<double, 2>(800, 5);
  std::vector<std::array<double, 2>> v;
  for (const auto& [x, y] : particles) {
    const double s = 1 - x * x - y * y;
    v.push_back({-y * s, x * s});
  }
  const std::vector<std::array<double, 2>> target{{0.6, 0.3}};  // r^2 = 0.45

  const auto fit =
      recon::reconstruct(recon::points_of(particles), recon::points_of(target), {.degree = 3});
  const auto [value, laplacian, divergence, curl, strain, average, mixed] =
      fit.operators(F::value, F::laplacian, F::divergence, F::curl, F::strain_rate,
                    F::cell_average({0.2, 0.2}), F::partial(2, 1));
  const auto field = recon::field_of(v);
  const Eigen::MatrixXd e = strain.apply(field);
  std::printf("value (%.4f, %.4f), mean over a cell (%.4f, %.4f)\n", value.apply(field)(0, 0),
              value.apply(field)(0, 1), average.apply(field)(0, 0), average.apply(field)(0, 1));
  std::printf("divergence %.4f, curl %.4f, strain rates %.4f %.4f %.4f\n",
              std::abs(divergence.apply(field)(0, 0)), curl.apply(field)(0, 0), e(0, 0), e(0, 1),
              e(0, 2));
  std::printf("Laplacian of vx %.4f, of x and y thrice: %.4f\n", laplacian.apply(field)(0, 0),
              mixed.apply(field)(0, 0));
  std::printf("one step of diffusion: vx %.4f\n", (value + 0.01 * laplacian).apply(field)(0, 0));
}

// Output
// value (-0.1650, 0.3300), mean over a cell (-0.1610, 0.3220)
// divergence 0.0000, curl 0.2000, strain rates 0.3600 -0.2700 -0.3600
// Laplacian of vx 2.4000, of x and y thrice: 2.0000
// one step of diffusion: vx -0.1410
