// The cost per target from ten thousand targets to ten million: it should not grow.
#include <algorithm>
#include <cmath>
#include <optional>

#include "cloud.hpp"
#include "lab.hpp"
#include "pictures.hpp"

namespace recon_bench {
namespace {

constexpr CloudSetting setting{3, 2, 20};
constexpr double flat_goal = 1.25;
constexpr std::size_t full_sizes[] = {10000, 100000, 1000000, 10000000};
constexpr std::size_t smoke_sizes[] = {1000, 2000};
constexpr std::size_t sources_per_target = 2;
constexpr std::size_t few_rounds_from = 1000000;  // targets: two rounds, for they take long
constexpr int few_rounds = 2;
// Seconds for one size, beyond which it is skipped.
constexpr double longest_full = 200, longest_quick = 15;

constexpr const char* stages[] = {"search", "construct", "apply", "all"};

// Least seconds of each stage.
std::vector<double> time_size(Lab& lab, std::size_t targets) {
  const Cloud<double, 3> cloud(CloudSize{sources_per_target * targets, targets});
  const ReconCall call{.degree = setting.degree,
                       .k = static_cast<std::size_t>(setting.k),
                       .threads = lab.context.threads,
                       .solver = recon::Solver::moment_matrix};
  recon::NeighbourList<double> list, copy;
  std::optional<recon::Reconstruction> fit;
  std::vector<double> out(targets), reference(targets);
  const auto apply = [&] { fit->apply(recon::field_of(cloud.u), recon::field_of(out)); };
  // In this order each finds what the one before left; copies of the list are freed at once, for
  // the largest takes gigabytes.
  const std::vector<Contestant> all{
      {"search", [&] { list = call.find(cloud); },
       [&] {
         fit.reset();
         list = {};
       }},
      {"construct", [&] { fit.emplace(call.construct(cloud, std::move(copy))); },
       [&] {
         fit.reset();
         copy = list;
       }},
      {"apply", apply},
      {"all",
       [&] {
         fit.emplace(call.reconstruct(cloud));
         apply();
       },
       [&] { fit.reset(); }}};
  // The answer first: from points, and with the list of a search of its own.
  all[0].run();
  copy = list;
  all[1].run();
  apply();
  reference = out;
  all[3].prepare();
  all[3].run();
  double worst = 0;
  for (std::size_t t = 0; t < targets; ++t)
    if (fit->report()[t].status == recon::FitStatus::full)
      worst = std::max(worst, std::isfinite(out[t]) ? std::abs(out[t] - reference[t]) : 1e300);
  const std::string name = "scaling, " + std::to_string(targets) + " targets";
  // Both do the same arithmetic, up to the order of equally near neighbours.
  if (!lab.checks.within(worst / 1e-9, name + ": from points and with a given list")) return {};
  const auto times = lab.stopwatch.run("scaling/" + std::to_string(targets), all, 0.5,
                                       targets >= few_rounds_from ? few_rounds : 1000);
  std::vector<double> seconds;
  for (const Times& one : times) seconds.push_back(one.best());
  return seconds;
}

}  // namespace

Section run_scaling(Lab& lab) {
  Section section{
      "The cost per target, by size",
      "Sources are twice as many as targets, both in random order; 3-D, degree 2, k = 20, "
      "moment_matrix. Least microseconds per target.",
      {},
      {}};
  Table table("scaling", {"targets", "search us", "construct us", "apply us", "all us"});
  std::vector<std::size_t> sizes(std::begin(full_sizes), std::end(full_sizes));
  if (lab.context.quick) sizes.pop_back();
  if (lab.context.smoke) sizes.assign(std::begin(smoke_sizes), std::end(smoke_sizes));
  recon::LinePlot plot = log_log_plot("Cost per target", "targets", "microseconds per target");
  for (const char* stage : stages) plot.curves.emplace_back().name = stage;

  double last = 0;  // seconds per target
  bool complete = true;
  for (const std::size_t targets : sizes) {
    // Once to check, once to warm up, and the rounds.
    const double estimate = last * static_cast<double>(targets) * (2 + few_rounds);
    std::vector<std::string> row{number(static_cast<double>(targets))};
    std::vector<double> seconds;
    if (estimate > (lab.context.quick ? longest_quick : longest_full)) {
      section.text += "\n\n" + row[0] + " targets: skipped, about " + number(estimate) + " s.";
      complete = false;
    } else {
      progress("scaling, " + row[0] + " targets");
      seconds = time_size(lab, targets);
      complete = complete && !seconds.empty();
    }
    for (std::size_t i = 0; i < std::size(stages); ++i) {
      const double us =
          seconds.empty() ? std::nan("") : seconds[i] / static_cast<double>(targets) * 1e6;
      row.push_back(number(us));
      plot.curves[i].x.push_back(static_cast<double>(targets));
      plot.curves[i].y.push_back(us);
    }
    table.add(row);
    if (!seconds.empty())
      last = (seconds[0] + seconds[1] + seconds[3]) / static_cast<double>(targets);
  }
  for (std::size_t i = 0; i < std::size(stages); ++i) {
    const auto& us = plot.curves[i].y;
    const double least = *std::min_element(us.begin(), us.end());
    const double most = *std::max_element(us.begin(), us.end());
    const double ratio = complete ? most / least : std::nan("");
    const std::string name = std::string(stages[i]) + ": most against least us per target, " +
                             table.rows()[0][0] + " to " + table.rows().back()[0] + " targets";
    if (i + 1 == std::size(stages))
      lab.summary.at_most(setting.name(), name, most, least, ratio, flat_goal);
    else
      lab.summary.note(setting.name(), name, most, least, ratio);
  }
  section.tables = {table};
  draw_picture(lab.context, section, "scaling", plot);
  return section;
}

}  // namespace recon_bench
