// apply() against the memory bandwidth: an operator is read once, whatever one does.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "cloud.hpp"
#include "hand_written.hpp"
#include "lab.hpp"

namespace recon_bench {
namespace {

constexpr CloudSetting setting{3, 2, 20};
constexpr double time_goal = 1.5;  // times what the bytes take at the measured bandwidth
constexpr double threads_goal = 1.8;
constexpr double jitter = 0.4;

// Particles and targets in the order of a lattice, as a particle code keeps them, or shuffled.
Cloud<double, 3> lattice_cloud(std::size_t sources, std::size_t targets, bool shuffled) {
  auto from = recon::jittered_points<double, 3>(sources, jitter, source_seed);
  auto to = recon::jittered_points<double, 3>(targets, jitter, target_seed);
  const auto shuffle = [](auto& points) {
    recon::RandomNumbers random(source_seed);
    for (std::size_t i = points.size(); i > 1; --i)
      std::swap(points[i - 1], points[random.next() % i]);
  };
  if (shuffled) {
    shuffle(from);
    shuffle(to);
  }
  return {std::move(from), std::move(to)};
}

// What must pass between memory and processor: entries, row offsets, the field once, the result.
double bytes_to_move(const recon::CsrOperator<double>& matrix) {
  const double entry = sizeof(double) + sizeof(recon::ParticleIndex);
  return static_cast<double>(matrix.entries()) * entry +
         static_cast<double>(matrix.rows() + 1) * sizeof(std::int64_t) +
         static_cast<double>(matrix.rows() + matrix.columns()) * sizeof(double);
}

// What the operator holds, as the hand-written loop stores it: k entries per target.
struct Entries {
  hand_written::Neighbours<double> pattern;
  std::vector<double> values;
};

Entries entries_of(const recon::CsrOperator<double>& matrix) {
  Entries copy;
  copy.pattern = {setting.k,
                  hand_written::Array<std::uint32_t>(new std::uint32_t[matrix.entries()]), nullptr};
  copy.values.reserve(matrix.entries());
  for (std::size_t t = 0; t < matrix.rows(); ++t)
    for (std::size_t i = 0; i < matrix.row(t).size(); ++i) {
      copy.pattern.index[copy.values.size()] = matrix.row(t).particle(i);
      copy.values.push_back(matrix.row(t).value(i));
    }
  return copy;
}

// |apply - direct sum| in units of its rounding, at its worst.
double worst_difference(const Entries& entries, const std::vector<double>& u,
                        const std::vector<double>& out) {
  const auto k = static_cast<std::size_t>(setting.k);
  double worst = entries.values.size() == k * out.size() ? 0 : 1e300;
  for (std::size_t t = 0; t < out.size() && worst < 1e300; ++t) {
    double sum = 0, size = 0;
    for (std::size_t e = t * k; e < (t + 1) * k; ++e) {
      const double product = entries.values[e] * u[entries.pattern.index[e]];
      sum += product;
      size += std::abs(product);
    }
    const double tolerance = 64 * std::numeric_limits<double>::epsilon() * size;
    const double difference = std::abs(sum - out[t]) / std::max(tolerance, 1e-300);
    worst = std::isfinite(difference) ? std::max(worst, difference) : 1e300;
  }
  return worst;
}

void time_apply(Lab& lab, const std::string& name, const Cloud<double, 3>& cloud, Table& table) {
  progress("apply, " + name);
  const int threads = lab.context.threads;
  ReconCall call{.degree = setting.degree,
                 .k = static_cast<std::size_t>(setting.k),
                 .threads = threads,
                 .solver = recon::Solver::moment_matrix};
  const recon::Reconstruction fit = call.reconstruct(cloud);
  const recon::CsrOperator<double>& matrix = fit.values();
  std::vector<double> out(cloud.targets.size());
  fit.apply(recon::field_of(cloud.u), recon::field_of(out));
  const Entries entries = entries_of(matrix);
  if (!lab.checks.within(worst_difference(entries, cloud.u, out), "apply, " + name)) {
    table.add({name, wrong_answer, "", "", "", "", "", ""});
    return;
  }

  std::vector<Contestant> all{
      {"recon", [&] { fit.apply(recon::field_of(cloud.u), recon::field_of(out)); }},
      {"hand", [&] {
         hand_written::apply(entries.pattern, entries.values.data(), cloud.u.data(), out.size(),
                             out.data(), threads);
       }}};
  std::optional<recon::Reconstruction> alone;
  if (threads > 1) {
    call.threads = 1;
    alone.emplace(call.reconstruct(cloud));
    all.push_back({"recon_one_thread",
                   [&] { alone->apply(recon::field_of(cloud.u), recon::field_of(out)); }});
  }
  const auto times = lab.stopwatch.run("apply/" + name, all, 0.5);

  const double bytes = bytes_to_move(matrix), limit = bytes / lab.limits.bandwidth;
  const double targets = static_cast<double>(out.size());
  const double share = times[0].best() / limit;
  const double scaling = threads > 1 ? speedup(times[0], times[2]) : std::nan("");
  table.add({name, number(bytes / 1e6), number(limit / targets * 1e6),
             number(times[0].best() / targets * 1e6), number(times[1].best() / targets * 1e6),
             number(share), number(speedup(times[0], times[1])), number(scaling)});
  lab.summary.at_most(name, "apply: us per target against what its bytes take at full bandwidth",
                      times[0].best() / targets * 1e6, limit / targets * 1e6, share, time_goal);
  if (threads > 1 && name.find("random") == std::string::npos)
    lab.summary.at_least(
        name, "apply, us per target: " + std::to_string(threads) + " threads against one",
        times[0].best() / targets * 1e6, times[2].best() / targets * 1e6, scaling, threads_goal);
}

}  // namespace

Section run_apply(Lab& lab) {
  Section section{
      "Apply: against the memory bandwidth",
      "3-D, degree 2, k = 20, one component. `bytes` must move: 12 per entry, 8 per row for its "
      "offset and 8 for its result, 8 per particle; `limit` is what they take at the measured "
      "bandwidth, and `time / limit` should be near 1 (below it where the operator stays in a "
      "cache). "
      "In lattice order particles and targets follow each other in space; in random order every "
      "entry "
      "reads another cache line of the field, which the limit does not count.",
      {},
      {}};
  Table table("apply", {"workload", "bytes MB", "limit us", "recon us", "hand us", "time / limit",
                        "ratio to hand", std::to_string(lab.context.threads) + " threads / 1"});
  const CloudSize size = lab.context.smoke ? smoke_cloud_size : cloud_size;
  time_apply(lab, "3-D cloud k=20", Cloud<double, 3>(size), table);
  const std::size_t sources = lab.choose(160, 93, 12), targets = lab.choose(126, 74, 9);
  const std::string count = number(static_cast<double>(targets * targets * targets));
  time_apply(lab, count + " targets in lattice order", lattice_cloud(sources, targets, false),
             table);
  time_apply(lab, count + " targets in random order", lattice_cloud(sources, targets, true), table);
  section.tables = {table};
  return section;
}

}  // namespace recon_bench
