// Reconstruction in one dimension: Shepard's mean, moving least squares, orthogonal polynomials.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <sstream>

#include "measure.hpp"
#include "programs/common/text.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"

namespace recon::program {
namespace {

using Numbers = std::vector<double>;
using Function = double (*)(double);

constexpr int clouds = 20;  // of random points

Numbers fitted(const Numbers& points, const Numbers& nodes, const Options& options, Function u) {
  Numbers data, values(nodes.size());
  for (const double x : points) data.push_back(u(x));
  const auto fit = reconstruct(points_of(points), points_of(nodes), options);
  fit.apply(field_of(data), field_of(values));
  return values;
}

// Nodes of cells on [lower, upper].
Numbers nodes_of(int cells, double lower, double upper) {
  Numbers nodes;
  for (int i = 0; i <= cells; ++i) nodes.push_back(lower + (upper - lower) * i / cells);
  return nodes;
}

Numbers regular(int cells, int per_cell, double lower, double upper) {
  Numbers points;
  const int n = cells * per_cell;
  for (int p = 0; p < n; ++p) points.push_back(lower + (upper - lower) * (p + 0.5) / n);
  return points;
}

Numbers random_in_cells(int cells, int per_cell, std::uint64_t seed) {
  RandomNumbers random(seed);
  Numbers points;
  for (int c = 0; c < cells; ++c)
    for (int j = 0; j < per_cell; ++j) points.push_back((c + random.uniform()) / cells);
  return points;
}

double one(double) {
  return 1;
}
double same(double x) {
  return x;
}
double square(double x) {
  return x * x;
}

// The rows of the source's table 4.2 in which (sum phi x)^2 > sum phi x^2, whatever its rounding.
int impossible_rows() {
  constexpr std::array<double, 11> linear{-0.1370, 0.0105,  -0.0046, -0.0330, 0.0403, -0.0129,
                                          -0.0275, -0.0134, 0.0390,  -0.0119, 0.0797};
  constexpr std::array<double, 11> quadratic{0.1963,  0.0114,  -0.0273, -0.0250, 0.0104, -0.0090,
                                             -0.0187, -0.0187, 0.0472,  -0.1511, 0.1751};
  int rows = 0;
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double x = -1 + 0.2 * static_cast<double>(i);
    const double mean = x - linear[i], mean_square = x * x - quadratic[i];
    rows += mean * mean > mean_square + 2 * std::abs(mean) * 0.5e-4 + 0.5e-4;
  }
  return rows;
}

// Errors u - u^h of Shepard's mean with the hat function on [-1, 1], 4 points per cell; of random
// points the largest of 20 clouds, but inside the least of the 20 largest ones.
Measured shepard(const Request& request) {
  const bool random = request.method == "random";
  const Numbers nodes = nodes_of(request.grid, -1, 1);
  const Options options{.degree = 0,
                        .weight = Weight::linear_b_spline,
                        .form = WeightForm::tensor_product,
                        .neighbours = Radius{2.0 / request.grid}};
  Measured measured;
  const std::size_t last = nodes.size() - 1;
  constexpr std::pair<const char*, Function> functions[] = {
      {"1", one}, {"x", same}, {"x^2", square}};
  for (const auto& [name, u] : functions) {
    double all = 0, inside = random ? 1e300 : 0;
    Numbers errors;
    for (int cloud = 1; cloud <= (random ? clouds : 1); ++cloud) {
      Numbers points = regular(request.grid, 4, -1, 1);
      if (random) {
        points.clear();
        for (const auto& x : random_points<double, 1>(4 * static_cast<std::size_t>(request.grid),
                                                      static_cast<std::uint64_t>(cloud)))
          points.push_back(2 * x[0] - 1);
      }
      errors = fitted(points, nodes, options, u);
      for (std::size_t i = 0; i <= last; ++i) errors[i] = u(nodes[i]) - errors[i];
      double most = 0;
      for (std::size_t i = 0; i <= last; ++i) {
        all = std::max(all, std::abs(errors[i]));
        if (i > 0 && i < last) most = std::max(most, std::abs(errors[i]));
      }
      inside = random ? std::min(inside, most) : most;
    }
    const std::string text = name;
    measured.add(text + ", largest error", all);
    measured.add(text + ", largest error inside", inside);
    if (random) continue;
    measured.add(text + ", error at the left end", errors.front());
    measured.add(text + ", error inside", errors[last / 2]);
    measured.add(text + ", error at the right end", errors.back());
  }
  if (random) measured.add("table 4.2, rows that no fit can have", impossible_rows());
  return measured;
}

// Rms errors at all nodes, without the two ends, and where the support lies inside; sin(pi x) on
// [0, 1] with 4 points per cell, or sin x on [1, 4] with 2.
Measured reconstruction(const Request& request) {
  const bool gong = request.study.settings.front() == "sin(pi x)";
  const bool random = request.variant.name == "random";
  const double lower = gong ? 0 : 1, upper = gong ? 1 : 4, h = (upper - lower) / request.grid;
  const Function u = gong ? Function([](double x) { return std::sin(std::numbers::pi * x); })
                          : Function([](double x) { return std::sin(x); });
  Options options{.degree = 2, .neighbours = Radius{2 * h}};
  if (request.method == "degree 0") options.degree = 0;
  if (request.method == "degree 1") options.degree = 1;
  if (request.method == "imls") options.solver = Solver::gram_schmidt;
  if (request.method == "mls") options.solver = Solver::moment_matrix;
  if (request.method == "mpm")
    options = {.degree = 0, .weight = Weight::linear_b_spline, .neighbours = Radius{h}};
  const Numbers nodes = nodes_of(request.grid, lower, upper);
  double sums[3] = {}, counts[3] = {};
  for (int cloud = 1; cloud <= (random ? clouds : 1); ++cloud) {
    const Numbers points = random
                               ? random_in_cells(request.grid, 4, static_cast<std::uint64_t>(cloud))
                               : regular(request.grid, gong ? 4 : 2, lower, upper);
    const Numbers values = fitted(points, nodes, options, u);
    for (int i = 0; i <= request.grid; ++i) {
      const int border = std::min(i, request.grid - i);
      const double error =
          values[static_cast<std::size_t>(i)] - u(nodes[static_cast<std::size_t>(i)]);
      for (int set = 0; set < 3; ++set)
        if (border >= set) {
          sums[set] += error * error;
          counts[set] += 1;
        }
    }
  }
  Measured measured;
  measured.add("error", std::sqrt(sums[0] / counts[0]));
  measured.add("error but for the ends", std::sqrt(sums[1] / counts[1]));
  measured.add("error with full support", std::sqrt(sums[2] / counts[2]));
  return measured;
}

// The largest errors over 20 clouds for degree 1, and the least of the 20 for x + 1 at degree 0.
Measured linear_functions(const Request& request) {
  const Options options{.degree = request.method == "degree 1" ? 1 : 0,
                        .neighbours = Radius{2.0 / request.grid}};
  const Numbers nodes = nodes_of(request.grid, 0, 1);
  const bool exact = options.degree == 1;
  Measured measured;
  constexpr std::pair<const char*, Function> functions[] = {
      {"1.5", [](double) { return 1.5; }}, {"x + 1", [](double x) { return x + 1; }}};
  for (const auto& [name, u] : functions) {
    const bool least = !exact && u(0) != u(1);
    double found = least ? 1e300 : 0;
    for (int cloud = 1; cloud <= clouds; ++cloud) {
      Numbers points;
      for (const auto& x : random_points<double, 1>(4 * static_cast<std::size_t>(request.grid),
                                                    static_cast<std::uint64_t>(cloud)))
        points.push_back(x[0]);
      const Numbers values = fitted(points, nodes, options, u);
      double most = 0;
      for (std::size_t i = 0; i < nodes.size(); ++i)
        most = std::max(most, std::abs(values[i] - u(nodes[i])));
      found = least ? std::min(found, most) : std::max(found, most);
    }
    measured.add(std::string(name) + ", largest error", found);
  }
  return measured;
}

// Ranks of (1, x, x^2) on the points that the method's name lists, without a limit to leverage.
Measured polynomials(const Request& request) {
  Numbers points;
  std::istringstream words(request.method);
  for (double x = 0; words >> x;) points.push_back(x);
  const Numbers places = nodes_of(request.grid - 1, -1, 1);
  const auto fit = reconstruct(points_of(points), points_of(places),
                               {.degree = 2,
                                .neighbours = Radius{2.0},
                                .solver = Solver::gram_schmidt,
                                .tolerances = {.leverage = 1e300}});
  int least = 100, greatest = 0;
  double amplification = 0;
  for (const FitReport& report : fit.report().all()) {
    least = std::min(least, static_cast<int>(report.rank));
    greatest = std::max(greatest, static_cast<int>(report.rank));
    amplification = std::max(amplification, static_cast<double>(report.amplification));
  }
  Measured measured;
  measured.add("least rank", least);
  measured.add("greatest rank", greatest);
  measured.add("largest amplification of data errors", amplification);
  return measured;
}

Measured solver_cost(const Request& request) {
  const int n = request.grid;
  const Numbers points = regular(n, 2, 1, 4), nodes = nodes_of(n, 1, 4);
  const Options options{
      .degree = 2,
      .neighbours = Radius{2 * 3.0 / n},
      .solver = request.method == "imls" ? Solver::gram_schmidt : Solver::moment_matrix};
  double best = 1e300;
  for (int turn = 0; turn < 50; ++turn) {
    const auto start = std::chrono::steady_clock::now();
    const auto fit = reconstruct(points_of(points), points_of(nodes), options);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    best = std::min(best, time.count());
  }
  Measured measured;
  measured.add("time of a fit", best * 1e9 / (n + 1));
  return measured;
}

}  // namespace

std::span<const NamedMeasure> fit_measures() {
  static constexpr NamedMeasure all[] = {{"shepard", shepard},
                                         {"reconstruction", reconstruction},
                                         {"linear functions", linear_functions},
                                         {"polynomials", polynomials},
                                         {"solver cost", solver_cost}};
  return all;
}

}  // namespace recon::program
