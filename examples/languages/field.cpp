// Particles to a field with gradient and report, and a run of the material point method: the same in C++, C, Fortran
// and Python, with the same output (field.output). The argument is a problem file.
#include <cmath>
#include <cstdio>
#include <recon/recon.hpp>
#include <recon/runs/read_problem.hpp>
#include <recon/runs/run.hpp>

int main(int, char** arguments) {
  std::vector<std::array<double, 2>> x, targets;
  std::vector<double> u;
  for (int i = 1; i <= 2000; ++i) {
    x.push_back({std::fmod(i * 0.7548776662466927, 1), std::fmod(i * 0.5698402909980532, 1)});
    u.push_back(x.back()[0] * (x.back()[0] + x.back()[1]));
  }
  for (int t = 0; t < 9; ++t) targets.push_back({0.25 * (1 + t % 3), 0.25 * (1 + t / 3)});

  const recon::Reconstruction fit =
      recon::reconstruct(recon::points_of(x), recon::points_of(targets),
                         {.degree = 1, .neighbours = recon::Radius{0.1}});
  const Eigen::MatrixXd value = fit.apply(recon::field_of(u));
  const Eigen::MatrixXd gradient = fit.gradient().apply(recon::field_of(u));
  double error = 0;
  for (int t = 0; t < 9; ++t)
    error = std::max(error, std::abs(value(t) - targets[t][0] * (targets[t][0] + targets[t][1])));
  std::printf("%zu of %zu targets with degree 1, largest error %.6f\n", fit.report().summary().full,
              fit.report().size(), error);
  std::printf("u(0.5, 0.5) = %.6f, gradient (%.6f, %.6f)\n", value(4), gradient(4, 0),
              gradient(4, 1));

  auto file = std::get<recon::mpm::ProblemFile<2>>(recon::mpm::read_problem(arguments[1]));
  recon::mpm::Simulation<2> disks(file.problem);
  recon::mpm::run_until(disks, 0.5);
  double energy = 0;
  for (std::size_t p = 0; p < disks.particles().size(); ++p)
    energy += 0.5 * disks.particles().mass[p] * disks.particles().v[p].squaredNorm();
  std::printf("%zu particles at t = %.2f, kinetic energy %.6f\n", disks.particles().size(),
              disks.time(), energy);
}
