// One reconstruction measured: how far it is from the field, how exact, at what price.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "accuracy_clouds.hpp"
#include "recon/basis/monomials.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/points/point_cloud.hpp"
#include "recon/recon.hpp"

namespace recon_bench {

struct Accuracy {
  double rms_value = 0, max_value = 0;        // errors, the field being of size 1
  double rms_gradient = 0, max_gradient = 0;  // errors of the gradient's components, 1/length
  double residual = 0;       // largest |sum phi_p xi_p^alpha - delta| up to the reported degree
  double amplification = 0;  // largest sum |phi_p|
  double noise = 0;          // rms of sqrt(sum phi_p^2): what is left of independent noise
  double reduced = 0, no_support = 0, handed_over = 0;  // per cent of the targets
  double neighbours = 0;                                // mean
  double bytes = 0;                                     // of operator and reports, per target
};

// The running sums behind an Accuracy, fed with one row of shape functions at a time.
template <class Scalar, int D>
class RowTally {
 public:
  explicit RowTally(const recon::PointList<Scalar, D>& points) : points_(points) {}

  // The row of a target at x with support rho, exact up to `degree`. Returns the residual.
  double add(const std::array<Scalar, D>& x, double rho, std::span<const Scalar> phi,
             std::span<const recon::ParticleIndex> particles, int degree) {
    using Terms = recon::Monomials<D, 4>;
    std::array<long double, Terms::size> moments{};
    long double value = 0, magnitude = 0, squares = 0;
    for (std::size_t i = 0; i < phi.size(); ++i) {
      const auto& at = points_[particles[i]];
      std::array<long double, D> xi;
      for (int d = 0; d < D; ++d)
        xi[d] = (static_cast<long double>(at[d]) - static_cast<long double>(x[d])) / rho;
      std::array<long double, Terms::size> terms;
      Terms::evaluate(xi, terms.data());
      const long double p = phi[i];
      for (int j = 0; j < Terms::begin(degree + 1); ++j) moments[j] += p * terms[j];
      value += p * static_cast<Scalar>(field(at));
      magnitude += std::abs(p);
      squares += p * p;
    }
    moments[0] -= 1;
    double residual = 0;
    for (int j = 0; j < Terms::begin(degree + 1); ++j) {
      const double miss = static_cast<double>(std::abs(moments[j]));
      residual = miss <= residual ? residual : miss;  // keeps a NaN
    }
    const double error = std::abs(static_cast<double>(value) - field(x));
    sum_.residual = residual <= sum_.residual ? sum_.residual : residual;
    sum_.rms_value += error * error;
    sum_.max_value = error <= sum_.max_value ? sum_.max_value : error;
    sum_.amplification = std::max(sum_.amplification, static_cast<double>(magnitude));
    sum_.noise += static_cast<double>(squares);
    ++rows_;
    return residual;
  }

  Accuracy result() const {
    Accuracy a = sum_;
    const double rows = static_cast<double>(std::max<std::size_t>(rows_, 1));
    a.rms_value = std::sqrt(sum_.rms_value / rows);
    a.noise = std::sqrt(sum_.noise / rows);
    return a;
  }

 private:
  const recon::PointList<Scalar, D>& points_;
  Accuracy sum_;
  std::size_t rows_ = 0;
};

// The rounding that a fit with this report may show; see tests/support/invariants.hpp.
template <class Scalar>
double allowed_residual(const recon::FitReport& report) {
  const double loss = report.solver == recon::Solver::moment_matrix
                          ? 1 / static_cast<double>(report.smallest_pivot)
                          : 1;
  return 8.0 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * (4 + report.rank) *
         std::max(1.0, static_cast<double>(report.amplification)) * loss;
}

// The numbers of a value operator, row by row in the order of the targets.
template <class Scalar>
std::vector<Scalar> numbers_of(const recon::CsrOperator<Scalar>& op) {
  std::vector<Scalar> numbers;
  for (std::size_t t = 0; t < op.rows(); ++t)
    for (std::size_t i = 0; i < op.row(t).size(); ++i) numbers.push_back(op.row(t).value(i));
  return numbers;
}

[[noreturn]] inline void fail(const std::string& name, const std::string& what) {
  throw std::runtime_error("accuracy, " + name + ": " + what);
}

template <class Scalar>
recon::NeighbourList<Scalar> neighbours_of(const auto& points, const auto& targets,
                                           const recon::Options& options) {
  using recon::points_of;
  const recon::PointCloud<Scalar> particles(points_of(points));
  return recon::find_neighbours(particles, recon::PointCloud<Scalar>(points_of(targets)),
                                *options.for_points(particles.dimension()).neighbours);
}

// Errors and exactness over all targets that have a value. Throws std::runtime_error where a target
// does not reproduce what its report says.
template <class Scalar, int D>
Accuracy accuracy_of(const std::string& name, const Setting<Scalar, D>& s,
                     const recon::Options& options,
                     recon::Derivative kind = recon::Derivative::exact) {
  const auto fit =
      recon::reconstruct(recon::points_of(s.points), recon::points_of(s.targets), options);
  const auto& op = fit.values();
  const auto u = field_at(s.points);
  const auto gradient = fit.gradient(kind).apply(recon::field_of(u));
  RowTally<Scalar, D> tally(s.points);
  std::vector<Scalar> phi;
  std::vector<recon::ParticleIndex> particles;
  double squares = 0, largest = 0;
  std::size_t rows = 0;
  for (std::size_t t = 0; t < s.targets.size(); ++t) {
    const recon::FitReport& report = fit.report()[t];
    if (report.rank == 0) continue;
    const auto row = op.row(t);
    phi.clear();
    particles.clear();
    for (std::size_t i = 0; i < row.size(); ++i) {
      phi.push_back(row.value(i));
      particles.push_back(row.particle(i));
    }
    const double residual =
        tally.add(s.targets[t], static_cast<double>(fit.support(t)), phi, particles, report.degree);
    if (!(residual <= allowed_residual<Scalar>(report)))
      fail(name, "target " + std::to_string(t) + " misses a polynomial of degree at most " +
                     std::to_string(report.degree) + " by " + std::to_string(residual));
    const auto expected = field_gradient(s.targets[t]);
    for (int d = 0; d < D; ++d) {
      const double error =
          std::abs(static_cast<double>(gradient(static_cast<Eigen::Index>(t), d)) - expected[d]);
      squares += error * error / D;
      largest = std::max(largest, error);
    }
    ++rows;
  }
  Accuracy a = tally.result();
  a.rms_gradient = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(rows, 1)));
  a.max_gradient = largest;
  const auto& summary = fit.report().summary();
  const double per_cent = 100.0 / static_cast<double>(s.targets.size());
  a.reduced = per_cent * static_cast<double>(summary.reduced);
  a.no_support = per_cent * static_cast<double>(summary.no_support);
  a.handed_over = per_cent * static_cast<double>(summary.handed_over);
  a.neighbours = summary.mean_neighbours;
  const double entries = static_cast<double>(op.entries()) / static_cast<double>(s.targets.size());
  a.bytes = entries * (sizeof(Scalar) + sizeof(recon::ParticleIndex)) + sizeof(std::int64_t) +
            sizeof(Scalar) + sizeof(recon::FitReport);
  return a;
}

// What is timed. One thread: its processor time where the system tells, which does not count what
// other programs take; several threads: by the clock on the wall.
enum class Timer { one_thread, wall };

inline double seconds_now(Timer timer) {
#ifdef CLOCK_THREAD_CPUTIME_ID
  if (timespec now; timer == Timer::one_thread && clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) == 0)
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
#endif
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

// Seconds of the fastest of at least three runs, and of more while they last less than `budget`
// seconds together. prepare() makes, outside of the clock, what run() consumes.
template <class Prepare, class Run>
double fastest(Timer timer, double budget, Prepare&& prepare, Run&& run) {
  double best = std::numeric_limits<double>::infinity(), spent = 0;
  for (int i = 0; i < 3 || (spent < budget && i < 100); ++i) {
    auto input = prepare();
    const double begin = seconds_now(timer);
    run(input);
    const double seconds = seconds_now(timer) - begin;
    best = std::min(best, seconds);
    spent += seconds;
    if (spent > 4 * budget) break;
  }
  return best;
}
template <class Run>
double fastest(Timer timer, double budget, Run&& run) {
  return fastest(
      timer, budget, [] { return 0; }, [&](int) { run(); });
}

// Microseconds per target, neighbours given.
struct Cost {
  double construct = 0, gradient = 0, apply = 0;      // one thread
  double construct_parallel = 0, apply_parallel = 0;  // Context::threads
};

template <class Scalar, int D>
Cost cost_of(const Setting<Scalar, D>& s, recon::Options options, int threads, double budget) {
  const auto list = neighbours_of<Scalar>(s.points, s.targets, options);
  const auto u = field_at(s.points);
  std::vector<Scalar> values(s.targets.size());
  const double micro = 1e6 / static_cast<double>(s.targets.size());
  const auto points = recon::points_of(s.points);
  const auto targets = recon::points_of(s.targets);
  const auto times = [&](int count, double& construct, double& apply, double* gradient) {
    options.threads = count;
    const Timer timer = gradient ? Timer::one_thread : Timer::wall;
    construct = micro * fastest(
                            timer, budget, [&] { return list; },
                            [&](auto& given) {
                              recon::reconstruct(points, targets, std::move(given), options);
                            });
    const auto fit = recon::reconstruct(points, targets, list, options);
    apply = micro * fastest(timer, budget / 4,
                            [&] { fit.apply(recon::field_of(u), recon::field_of(values)); });
    if (gradient) *gradient = micro * fastest(timer, budget / 4, [&] { fit.gradient(); });
  };
  Cost cost;
  times(1, cost.construct, cost.apply, &cost.gradient);
  times(threads, cost.construct_parallel, cost.apply_parallel, nullptr);
  return cost;
}

// The first `count` targets of a setting.
template <class Scalar, int D>
Setting<Scalar, D> with_targets(const Setting<Scalar, D>& s, std::size_t count) {
  auto out = s;
  out.targets.resize(std::min(count, s.targets.size()));
  return out;
}

// What a developer calls the solvers; degree 0 is Shepard's mean whatever the solver.
inline std::string solver_name(recon::Solver solver, int degree = 1) {
  if (degree == 0) return "Shepard";
  switch (solver) {
    case recon::Solver::moment_matrix:
      return "MLS";
    case recon::Solver::gram_schmidt:
      return "IMLS";
    case recon::Solver::qr:
      return "QR";
    default:
      return "SVD";
  }
}
inline constexpr recon::Solver all_solvers[] = {recon::Solver::moment_matrix,
                                                recon::Solver::gram_schmidt, recon::Solver::qr,
                                                recon::Solver::svd};

}  // namespace recon_bench
