// Periodic domains: particles see each other across the border, by all their images.
//
// cos(2 pi x) at 20 particles in the unit interval, fitted with degree 2 at the border itself and
// within. Without the domain the particles at x = 0 lie on one side only; with it the border is a
// place like any other, and a target outside the interval is the one within.
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

int main() {
  std::vector<double> x, u;
  for (int p = 0; p < 20; ++p) {
    x.push_back((p + 0.5 + 0.3 * std::sin(5.0 * p)) / 20);
    u.push_back(std::cos(2 * std::numbers::pi * x.back()));
  }
  const std::vector<double> targets{0, 0.4, 1, 2.4};  // in [0, 1) these are 0, 0.4, 0, 0.4

  recon::Options options{.degree = 2, .neighbours = recon::Radius{0.2}, .max_distance = 2};
  const auto open = recon::reconstruct(recon::points_of(x), recon::points_of(targets), options);
  options.domain = {.lower = {0}, .upper = {1}, .periodic = {true}};
  const auto closed = recon::reconstruct(recon::points_of(x), recon::points_of(targets), options);

  const Eigen::MatrixXd without = open.apply(recon::field_of(u));
  const Eigen::MatrixXd with = closed.apply(recon::field_of(u));
  for (std::size_t t = 0; t < targets.size(); ++t)
    std::printf("x = %.2f: open %7.4f of %2u particles, periodic %7.4f of %2u\n", targets[t],
                without(t, 0), open.report()[t].neighbours, with(t, 0),
                closed.report()[t].neighbours);
}

// Output
// x = 0.00: open  1.0029 of  4 particles, periodic  0.9989 of  8
// x = 0.40: open -0.8075 of  8 particles, periodic -0.8075 of  8
// x = 1.00: open  1.0016 of  4 particles, periodic  0.9989 of  8
// x = 2.40: open     nan of  0 particles, periodic -0.8075 of  8
