// recon-gpu: recon::cuda on the GPU of this machine, checked against the library on the processor,
// and timed. Writes <out>/report.md, and prints it.
//
//   recon-gpu [<out>]     out/gpu by default
//
// A million targets among two million random particles, in the workloads of README.md, in double
// and float; moments at the nodes of a grid (grid_case.hpp); and fewer targets in clouds that the moment matrix cannot fit. Every fiftieth target is
// compared with recon::reconstruct(): its neighbours, its report, the numbers of its row and of its
// gradient, by what rounding may do to them, 64 eps a / s with the amplification a >= 1 and the
// smallest pivot s of its report. The exit status is 1 where numbers differ by more, neighbours or
// reports differ at more than one in a hundred thousand targets, or a second run has other bits; and
// 77 where there is no GPU.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "flops.hpp"
#include "grid_case.hpp"
#include "recon/cuda/reconstruct.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/make_view.hpp"

namespace {

using recon_gpu::fetch, recon_gpu::Machine, recon_gpu::OnGpu, recon_gpu::percent,
    recon_gpu::time_of;

struct Workload {
  std::string name;
  recon::Options options;
  std::size_t particles, targets;
  double thickness;  // of the cloud along its last axis
};

struct Checked {
  std::size_t targets = 0, other_neighbours = 0, other_reports = 0, by_the_other_solver = 0;
  double of_rounding = 0;  // the largest difference, in units of what rounding may do
  bool same_bits = true;
  bool good() const {
    const std::size_t few = 1 + targets / 100'000;
    return of_rounding <= 1 && same_bits && other_neighbours <= few && other_reports <= few;
  }
};

template <int D, class T>
using PointVector = std::vector<std::array<T, D>>;

template <int D, class T>
PointVector<D, T> points_in(std::size_t count, unsigned seed, double margin, double thickness) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> in(margin, 1 - margin);
  PointVector<D, T> points(count);
  for (auto& x : points)
    for (std::size_t d = 0; d < D; ++d)
      x[d] = static_cast<T>(in(random) * (d + 1 == D ? thickness : 1));
  return points;
}

// Infinite where one of them alone is NaN (a slope of data that have none is one on both sides).
double difference(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) == std::isnan(b) ? 0 : HUGE_VAL;
  return std::abs(a - b);
}

// Compares every fiftieth target with the library.
template <int D, class T>
Checked check(recon::cuda::Reconstruction<D, T>& fit, const PointVector<D, T>& points,
              const PointVector<D, T>& targets, const recon::Options& options) {
  Checked result;
  const recon::cuda::CsrRows rows = fit.rows();
  const auto entries = static_cast<std::size_t>(fit.entries());
  const auto gradient = fit.gradient();
  const auto offsets = fetch(rows.offsets, rows.rows + 1);
  const auto columns = fetch(rows.columns, entries), target_of = fetch(rows.target_of, rows.rows);
  const auto values = fetch(fit.values(), entries), slopes = fetch(gradient.values(), entries * D);
  const auto reports = fetch(fit.reports(), rows.rows);

  std::vector<std::size_t> row_of(rows.rows);
  for (std::size_t r = 0; r < rows.rows; ++r) row_of[target_of[r]] = r;
  PointVector<D, T> some;
  std::vector<std::size_t> numbers;
  for (std::size_t t = 0; t < targets.size(); t += 50) {
    some.push_back(targets[t]);
    numbers.push_back(t);
  }
  const recon::PointsView<T> at = recon::points_of(points), seen = recon::points_of(some);
  const recon::BasicSources<T> sources(at);
  const recon::BasicReconstruction<T> library(sources, seen, options);
  const recon::CsrOperator<T> of_slopes = library.gradient();
  for (std::size_t i = 0; i < some.size(); ++i) {
    const std::size_t t = numbers[i], row = row_of[t];
    const recon::FitReport &here = reports[t], &there = library.report()[i];
    ++result.targets;
    const bool same_report = here.status == there.status && here.neighbours == there.neighbours &&
                             here.kept == there.kept && here.degree == there.degree &&
                             here.gradient_rank == there.gradient_rank;
    result.other_reports += !same_report;
    result.by_the_other_solver += here.solver != there.solver;
    const auto expected = library.values().row(i);
    const auto expected_slopes = of_slopes.row(i);
    const auto first = static_cast<std::size_t>(offsets[row]);
    const std::size_t count = static_cast<std::size_t>(offsets[row + 1]) - first;
    std::vector<std::size_t> ours(count), theirs(expected.size());
    for (std::size_t e = 0; e < count; ++e) ours[e] = e;
    for (std::size_t e = 0; e < theirs.size(); ++e) theirs[e] = e;
    std::sort(ours.begin(), ours.end(), [&](std::size_t a, std::size_t b) {
      return columns[first + a] < columns[first + b];
    });
    std::sort(theirs.begin(), theirs.end(), [&](std::size_t a, std::size_t b) {
      return expected.particle(a) < expected.particle(b);
    });
    bool same = count == theirs.size();
    for (std::size_t e = 0; e < count && same; ++e)
      same = columns[first + ours[e]] == expected.particle(theirs[e]);
    if (!same) {
      ++result.other_neighbours;
      continue;
    }
    if (!same_report) continue;
    double largest = 0, apart = 0, largest_slope = 0, apart_slope = 0;
    for (std::size_t e = 0; e < count; ++e) {
      const std::size_t f = first + ours[e];
      const auto value = static_cast<double>(expected.value(theirs[e]));
      largest = std::fmax(largest, std::abs(value));
      apart = std::max(apart, difference(static_cast<double>(values[f]), value));
      for (int d = 0; d < D; ++d) {
        const auto slope = static_cast<double>(expected_slopes.value(theirs[e], d));
        const auto own = static_cast<double>(slopes[f * D + static_cast<std::size_t>(d)]);
        largest_slope = std::fmax(largest_slope, std::abs(slope));
        apart_slope = std::max(apart_slope, difference(own, slope));
      }
    }
    const double bound = 64 * static_cast<double>(std::numeric_limits<T>::epsilon()) *
                         std::max(1.0, static_cast<double>(there.amplification)) /
                         std::max(1e-300, static_cast<double>(there.smallest_pivot));
    const auto of_bound = [bound](double off, double size) {
      return off == 0 ? 0 : off / (bound * size);
    };
    result.of_rounding = std::max(
        {result.of_rounding, of_bound(apart, largest), of_bound(apart_slope, largest_slope)});
  }
  return result;
}

template <int D, class T>
bool run(const Workload& workload, const Machine& machine, std::ostream& report,
         std::ostream& fractions) {
  const auto points = points_in<D, T>(workload.particles, 1, 0, workload.thickness);
  const auto targets = points_in<D, T>(workload.targets, 2, 0.1, workload.thickness);
  const auto flat = [](const PointVector<D, T>& all) {
    std::vector<T> numbers;
    for (const auto& x : all) numbers.insert(numbers.end(), x.begin(), x.end());
    return numbers;
  };
  const std::size_t n = points.size(), m = targets.size();
  OnGpu<T> x(flat(points)), y(flat(targets)), out(m), back(n);
  std::vector<T> field;
  for (const auto& p : points)
    field.push_back(static_cast<T>(std::sin(3 * static_cast<double>(p[0]))));
  OnGpu<T> u(field);

  recon::cuda::Sources<D, T> sources({x.data(), n});
  recon::cuda::Reconstruction<D, T> fit(sources, {y.data(), m}, workload.options);
  fit.check();
  const auto entries = static_cast<std::size_t>(fit.entries());
  const auto before = fetch(fit.values(), entries);
  const double order = time_of([&] { sources.update({x.data(), n}); });
  fit.update({y.data(), m});
  const double find_and_fit = time_of([&] { fit.update({y.data(), m}); });
  const double apply = time_of([&] { fit.apply({u.data(), n}, {out.data(), m}); });
  auto gradient = fit.gradient();
  const double slopes = time_of([&] { fit.gradient(gradient); });
  fit.apply_transpose({out.data(), m}, {back.data(), n});
  const double transpose = time_of([&] { fit.apply_transpose({out.data(), m}, {back.data(), n}); });
  fit.check();
  const auto after = fetch(fit.values(), entries);

  Checked checked = check<D, T>(fit, points, targets, workload.options);
  checked.same_bits = std::memcmp(before.data(), after.data(), entries * sizeof(T)) == 0;
  std::size_t handed_over = 0;
  for (const recon::FitReport& each : fetch(fit.reports(), m))
    handed_over += each.solver != workload.options.solver;

  const double each = 1e9 / static_cast<double>(m), all = order + find_and_fit + apply;
  const char* precision = sizeof(T) == 8 ? "double" : "float";
  char line[512];
  std::snprintf(line, sizeof line, "| %s | %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %zu |\n",
                workload.name.c_str(), precision, all * each, order * each, find_and_fit * each,
                apply * each, slopes * each, transpose * each, handed_over);
  report << line;
  // What must be moved, and computed for the fits, at least: each number once.
  constexpr double size = sizeof(T), index = 4;
  const auto of = [](std::size_t count) { return static_cast<double>(count); };
  const double positions = (of(n) + of(m)) * D * size, fields = (of(n) + of(m)) * size,
               neighbours = of(entries) * index, numbers = of(entries) * size;
  const double fit_flops =
      of(m) * recon_bench::construct_flops(D, workload.options.degree, 1) +
      (of(entries) - of(m)) * (recon_bench::construct_flops(D, workload.options.degree, 2) -
                               recon_bench::construct_flops(D, workload.options.degree, 1));
  const double fit_bytes = positions + neighbours + numbers + of(m) * sizeof(recon::FitReport);
  std::snprintf(line, sizeof line, "| %s | %s | %s | %s | %s | %s | %s | %s |\n",
                workload.name.c_str(), precision,
                percent(of(n) * (2 * D * size + index) / order, machine.bytes).c_str(),
                percent(fit_bytes / find_and_fit, machine.bytes).c_str(),
                percent(fit_flops / find_and_fit, machine.peak<T>()).c_str(),
                percent((neighbours + numbers + fields) / apply, machine.bytes).c_str(),
                percent((positions + neighbours + numbers * D) / slopes, machine.bytes).c_str(),
                percent((neighbours + numbers + fields) / transpose, machine.bytes).c_str());
  fractions << line;
  std::snprintf(
      line, sizeof line,
      "%-28s %-6s %s: %zu targets compared, other neighbours %zu, other reports %zu, by the "
      "other solver %zu, numbers within %.3f of what rounding may do, %s\n",
      workload.name.c_str(), precision, checked.good() ? "good" : "NOT GOOD", checked.targets,
      checked.other_neighbours, checked.other_reports, checked.by_the_other_solver,
      checked.of_rounding,
      checked.same_bits ? "the same bits again" : "OTHER BITS in a second run");
  std::cout << line << std::flush;
  return checked.good();
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : "out/gpu";
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::puts("no GPU: recon::cuda was built, and not run");
    return 77;
  }
  try {
    const Machine machine = recon_gpu::this_machine();
    using recon::Nearest;
    constexpr recon::Solver mls = recon::Solver::moment_matrix, imls = recon::Solver::gram_schmidt;
    const std::size_t n = 2'000'000, m = 1'000'000;
    const auto begin = std::chrono::steady_clock::now();
    std::ostringstream table, fractions, grid;
    bool good = true;
    const auto both = [&](auto dimension, const Workload& workload) {
      good = run<dimension(), double>(workload, machine, table, fractions) && good;
      good = run<dimension(), float>(workload, machine, table, fractions) && good;
    };
    const std::integral_constant<int, 2> plane;
    const std::integral_constant<int, 3> space;
    both(space,
         {"3-D degree 2 k=20", {.degree = 2, .neighbours = Nearest{20}, .solver = mls}, n, m, 1});
    both(space, {"3-D degree 2 k=20, ten times more",
                 {.degree = 2, .neighbours = Nearest{20}, .solver = mls},
                 10 * n,
                 10 * m,
                 1});
    both(space,
         {"3-D degree 1 k=8", {.degree = 1, .neighbours = Nearest{8}, .solver = mls}, n, m, 1});
    both(plane,
         {"2-D degree 2 k=12", {.degree = 2, .neighbours = Nearest{12}, .solver = mls}, n, m, 1});
    both(plane,
         {"2-D degree 1 k=6", {.degree = 1, .neighbours = Nearest{6}, .solver = mls}, n, m, 1});
    both(space, {"3-D degree 2 k=20, IMLS",
                 {.degree = 2, .neighbours = Nearest{20}, .solver = imls},
                 n,
                 m,
                 1});
    both(space, {"3-D Shepard, a radius",
                 {.degree = 0, .neighbours = recon::Radius{0.013}, .solver = mls},
                 n,
                 m,
                 1});
    both(space, {"a thin sheet, degree 2 k=20",
                 {.degree = 2, .neighbours = Nearest{20}, .solver = mls},
                 200'000,
                 100'000,
                 1e-4});
    good = recon_gpu::run_grid<double>(machine, 50, grid) && good;
    good = recon_gpu::run_grid<float>(machine, 50, grid) && good;
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;

    std::filesystem::create_directories(folder);
    std::ostringstream text;
    text
        << "# recon::cuda on " << machine.name
        << "\n\nNanoseconds a target, the shortest of six runs: from positions on the GPU to "
           "values "
           "(order the particles, find and fit with all reports, apply to one field), its parts, "
           "and beside it gradients and a transposed product. A million targets among two million "
           "random particles, and ten times more; 100,000 among 200,000 in the sheet. Handed over: "
           "to Gram-Schmidt.\n\n"
           "| workload | | all | order | find and fit | apply | gradient | transpose | handed over "
           "|\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        << table.str()
        << "\nWhat must be moved and computed at least, each number once and the fits by their "
           "direct "
           "formulas, of what the driver says that the GPU can do: "
        << machine.bytes * 1e-12 << " TB/s, " << machine.flops[1] * 1e-12 << " (double) and "
        << machine.flops[0] * 1e-12
        << " (float) Tflop/s.\n\n| workload | | order, of bandwidth | find and fit, of bandwidth | "
           "of peak | apply, of bandwidth | gradient, of bandwidth | transpose, of bandwidth |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- |\n"
        << fractions.str()
        << "\nGrid velocity: moments of degree 1 and three components of a million particles at "
           "132,651 nodes (cubic B-splines, 8 particles in a cell), nanoseconds a particle.\n\n"
           "| | all | order | sums | of peak | solve | of bandwidth |\n"
           "| --- | --- | --- | --- | --- | --- | --- |\n"
        << grid.str() << "\n"
        << (good ? "All checks against the library on the processor were good"
                 : "CHECKS FAILED: what this machine computed is not what the library computes")
        << "; the whole took " << took.count() << " s.\n";
    std::ofstream(folder / "report.md") << text.str();
    std::cout << text.str();
    return good ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "recon-gpu: " << error.what() << "\n";
    return 1;
  }
}
