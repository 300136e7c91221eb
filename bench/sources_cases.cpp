// Sources: many calls on one index against one call, an update against a new start, and products with
// and without checks against a plain loop over the entries.
#include <cmath>
#include <limits>
#include <optional>

#include "cloud.hpp"
#include "lab.hpp"

namespace recon_bench {
namespace {

constexpr std::size_t calls = 20;
constexpr double calls_goal = 1.3, update_goal = 0.5, trusted_goal = 1, checked_goal = 1.25;

template <int D>
using Points = recon::PointList<double, D>;

// An operator as a plain loop has it, in the order of rows of the operator itself.
struct PlainRows {
  std::vector<std::int64_t> offsets{0};
  std::vector<std::uint32_t> target, index;
  std::vector<double> values;

  // Targets in the order `in_order`, in which they follow each other in space.
  PlainRows(const recon::CsrOperator<double>& matrix, std::span<const std::uint32_t> in_order)
      : target(in_order.begin(), in_order.end()) {
    for (const std::uint32_t t : target) {
      for (std::size_t i = 0; i < matrix.row(t).size(); ++i) {
        index.push_back(matrix.row(t).particle(i));
        values.push_back(matrix.row(t).value(i));
      }
      offsets.push_back(static_cast<std::int64_t>(index.size()));
    }
  }

  void apply(const std::vector<double>& u, std::vector<double>& out) const {
    for (std::size_t row = 0; row < target.size(); ++row) {
      double sum = 0;
      for (std::int64_t e = offsets[row]; e < offsets[row + 1]; ++e) sum += values[e] * u[index[e]];
      out[target[row]] = sum;
    }
  }
};

template <int D>
void time_setting(Lab& lab, const CloudSetting& setting, Table& index, Table& products) {
  progress("sources, " + setting.name());
  const int threads = lab.context.threads;
  const CloudSize size{lab.choose(200000, 100000, 2000), lab.choose(20000, 20000, 1000)};
  const Cloud<double, D> cloud(size);
  Cloud<double, D> moved = cloud;
  recon::RandomNumbers random(3);
  const double h = std::pow(static_cast<double>(size.sources), -1.0 / D);
  for (auto& x : moved.sources)
    for (double& c : x) c += 0.1 * h * random.uniform(-1, 1);
  std::vector<Points<D>> parts(calls);
  for (std::size_t t = 0; t < cloud.targets.size(); ++t)
    parts[t * calls / cloud.targets.size()].push_back(cloud.targets[t]);
  const recon::Options options{.degree = setting.degree,
                               .neighbours = recon::Nearest{setting.k},
                               .solver = recon::Solver::moment_matrix,
                               .threads = threads};

  // Checked first: parts equal the whole, an update equals a new start.
  recon::Sources sources(cloud.from(), {.threads = threads});
  recon::Reconstruction fit = recon::reconstruct(sources, cloud.to(), options);
  const auto u = recon::field_of(cloud.u);
  const Eigen::MatrixXd whole = fit.apply(u);
  Eigen::Index first = 0;
  bool good = true;
  for (const auto& part : parts) {
    const auto of_part = recon::reconstruct(sources, recon::points_of(part), options).apply(u);
    good = good && of_part == whole.middleRows(first, of_part.rows());
    first += of_part.rows();
  }
  sources.update(moved.from());
  fit.update(cloud.to());
  good = good && fit.apply(u) == recon::reconstruct(moved.from(), cloud.to(), options).apply(u);
  if (!lab.checks.hold(good, "sources, " + setting.name() + ": other results")) {
    index.add({setting.name(), wrong_answer, "", "", "", "", ""});
    return;
  }

  std::optional<recon::Reconstruction> made;
  bool here = false;
  const std::vector<Contestant> contest{
      {"one_call", [&] { made.emplace(recon::reconstruct(cloud.from(), cloud.to(), options)); },
       [&] { made.reset(); }},
      {"calls",
       [&] {
         const recon::Sources kept(cloud.from(), {.threads = threads});
         for (const auto& part : parts)
           made.emplace(recon::reconstruct(kept, recon::points_of(part), options));
       },
       [&] { made.reset(); }},
      {"calls_of_points",
       [&] {
         for (const auto& part : parts)
           made.emplace(recon::reconstruct(cloud.from(), recon::points_of(part), options));
       },
       [&] { made.reset(); }},
      {"update", [&] {
         here = !here;
         sources.update(here ? cloud.from() : moved.from());
         fit.update(cloud.to());
       }}};
  const auto times = lab.stopwatch.run("sources/" + setting.name(), contest);
  const auto ratio = [&](std::size_t i) { return speedup(times[0], times[i]); };
  index.add({setting.name(), number(times[0].best() * 1e3), number(times[1].best() * 1e3),
             number(ratio(1)), number(ratio(2)), number(times[3].best() * 1e3), number(ratio(3))});
  lab.summary.at_most(setting.name(), "20 calls on one Sources against one call, ms",
                      times[1].best() * 1e3, times[0].best() * 1e3, ratio(1), calls_goal);
  lab.summary.at_most(setting.name(), "update of Sources and fit against new ones, ms",
                      times[3].best() * 1e3, times[0].best() * 1e3, ratio(3), update_goal);

  // One thread, so that a plain loop is one.
  recon::Options alone = options;
  alone.threads = 1;
  const recon::Reconstruction one = recon::reconstruct(cloud.from(), cloud.to(), alone);
  const recon::Sources of_targets(cloud.to());  // an order in space, of targets
  const PlainRows plain(one.values(), of_targets.order());
  std::vector<double> a(cloud.targets.size()), b(a), c(a);
  plain.apply(cloud.u, a);
  one.apply(u, recon::field_of(b));
  double worst = 0;
  for (std::size_t t = 0; t < a.size(); ++t) worst = std::max(worst, std::abs(a[t] - b[t]));
  if (!lab.checks.hold(worst < 1e-12, "products, " + setting.name() + ": other results")) return;
  const std::vector<Contestant> race{
      {"plain", [&] { plain.apply(cloud.u, a); }},
      {"trusted", [&] { one.apply(u, recon::field_of(b), recon::trusted); }},
      {"checked", [&] { one.apply(u, recon::field_of(c)); }}};
  const auto laps = lab.stopwatch.run("products/" + setting.name(), race, 0.5);
  const double targets = static_cast<double>(a.size());
  products.add({setting.name(), number(laps[0].best() / targets * 1e9),
                number(laps[1].best() / targets * 1e9), number(speedup(laps[0], laps[1])),
                number(laps[2].best() / targets * 1e9), number(speedup(laps[0], laps[2]))});
  lab.summary.at_most(setting.name(), "trusted product against a plain loop, ns per target",
                      laps[1].best() / targets * 1e9, laps[0].best() / targets * 1e9,
                      speedup(laps[0], laps[1]), trusted_goal);
  lab.summary.at_most(setting.name(), "checked product against a plain loop, ns per target",
                      laps[2].best() / targets * 1e9, laps[0].best() / targets * 1e9,
                      speedup(laps[0], laps[2]), checked_goal);
}

}  // namespace

Section run_sources(Lab& lab) {
  Section section{
      "Sources: an index that is kept",
      "The sources of the cloud and 20,000 targets (moment matrix). `one call` is "
      "reconstruct(points, targets); `20 calls` make Sources and ask them for a twentieth of the "
      "targets at a time, `of points` without Sources; `update` moves every particle by up to a "
      "tenth of the spacing, then updates Sources and fit. Below: values of one component on one "
      "thread, "
      "against a plain loop over the same entries in an order of space.",
      {},
      {}};
  Table index("sources", {"cloud", "one call ms", "20 calls ms", "20 calls / one",
                          "of points / one", "update ms", "update / one"});
  Table products("products", {"cloud", "plain ns", "trusted ns", "trusted / plain", "checked ns",
                              "checked / plain"});
  for (const CloudSetting& setting : cloud_settings) {
    if (setting.dimension == 3)
      time_setting<3>(lab, setting, index, products);
    else
      time_setting<2>(lab, setting, index, products);
  }
  section.tables = {index, products};
  return section;
}

}  // namespace recon_bench
