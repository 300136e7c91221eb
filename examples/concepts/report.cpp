// The report: what a neighbourhood determines is kept, and the rest is said.
//
// Five targets ask for degree 2 in the plane (6 terms: a constant, two slopes, three curvatures).
// The data are u = 1 + x + 2 y + x y. On the line the value is right, 18.68, though nothing is
// known beside it; in the circle it is, too: the term that is lost, x^2 + y^2, is none of u.
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>

int main() {
  std::vector<std::array<double, 2>> particles;
  const auto add = [&](double x, double y) { particles.push_back({x, y}); };
  for (const auto& [x, y] : recon::jittered_points<double, 2>(5, 0.3, 1))
    add(x, y);                                                                 // about (0.5, 0.5)
  for (int i = 0; i < 7; ++i) add(10 + 0.1 * i, 0.2 * i);                      // on a slanting line
  for (int i = 0; i < 8; ++i) add(20 + std::cos(0.7 * i), std::sin(0.7 * i));  // on a circle
  add(30, 0), add(30.5, 0.4);                                                  // two alone
  std::vector<double> u;
  for (const auto& [x, y] : particles) u.push_back(1 + x + 2 * y + x * y);
  const std::vector<std::array<double, 2>> targets{
      {0.5, 0.5}, {10.3, 0.6}, {20, 0}, {30.2, 0.2}, {40, 0}};
  const char* names[] = {"a cloud", "a line", "a circle", "two particles", "nothing"};

  const auto fit = recon::reconstruct(recon::points_of(particles), recon::points_of(targets),
                                      {.degree = 2, .neighbours = recon::Radius{1.5}});
  const Eigen::MatrixXd value = fit.apply(recon::field_of(u));
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const recon::FitReport& report = fit.report()[t];
    std::printf(
        "%-13s %2u particles, rank %d = %d + %d + %d, degree %2d, slopes in %d, %s: u = "
        "%.3f\n",
        names[t], report.neighbours, report.rank, report.kept[0], report.kept[1], report.kept[2],
        report.degree, report.gradient_rank, std::string(name_of(report.status)).c_str(),
        std::abs(value(t, 0)));
  }
  std::printf("%zu of %zu targets are not of full degree\n",
              fit.report().size() - fit.report().summary().full, fit.report().size());
}

// Output
// a cloud       25 particles, rank 6 = 1 + 2 + 3, degree  2, slopes in 2, full: u = 2.750
// a line         7 particles, rank 3 = 1 + 1 + 1, degree  0, slopes in 1, reduced: u = 18.680
// a circle       8 particles, rank 5 = 1 + 2 + 2, degree  1, slopes in 2, reduced: u = 21.000
// two particles  2 particles, rank 2 = 1 + 1 + 0, degree  0, slopes in 1, reduced: u = 36.927
// nothing        0 particles, rank 0 = 0 + 0 + 0, degree -1, slopes in 0, no_support: u = nan
// 4 of 5 targets are not of full degree
