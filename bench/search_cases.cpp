// The searches of recon against each other: building and asking, k nearest and radius, targets in
// order and at random, 2-D and 3-D.
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "cloud.hpp"
#include "lab.hpp"
#include "recon/neighbourhood/brute_force.hpp"
#include "recon/neighbourhood/cell_grid.hpp"
#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/neighbourhood/r_tree.hpp"

namespace recon_bench {
namespace {

constexpr recon::SearchMethod methods[] = {
    recon::SearchMethod::automatic, recon::SearchMethod::kd_tree, recon::SearchMethod::r_tree,
    recon::SearchMethod::cell_grid, recon::SearchMethod::brute_force};
constexpr const char* method_names[] = {"automatic", "kd_tree", "r_tree", "cell_grid",
                                        "brute_force"};
constexpr std::size_t few_targets = 200;  // for brute force
constexpr double budget = 0.4;

bool same(const recon::NeighbourList<double>& a, const recon::NeighbourList<double>& b) {
  return a.offsets == b.offsets && a.indices == b.indices && a.support == b.support;
}

// The radius of a ball (disc) that holds k of n uniform points on average.
double radius_of(int dimension, std::size_t k, std::size_t n) {
  const double volume = static_cast<double>(k) / static_cast<double>(n);
  return dimension == 3 ? std::cbrt(volume * 3 / (4 * std::numbers::pi))
                        : std::sqrt(volume / std::numbers::pi);
}

template <int D>
recon::PointList<double, D> grid_targets(std::size_t count) {
  auto n = static_cast<std::size_t>(std::lround(std::pow(static_cast<double>(count), 1.0 / D)));
  auto points = recon::regular_points<double, D>(n);
  for (auto& x : points)
    for (double& c : x) c = 0.1 + 0.8 * c;
  return points;
}

// Microseconds to build each search; by its name.
template <int D>
std::map<std::string, double> time_building(Lab& lab, const recon::PointCloud<double>& points) {
  std::optional<recon::KdTree<double, D>> kd_tree;
  std::optional<recon::RTree<double, D>> r_tree;
  std::optional<recon::CellGrid<double, D>> cell_grid;
  std::optional<recon::BruteForce<double, D>> brute_force;
  const auto build = [&](auto& search, const char* name) {
    return Contestant{name, [&] { search.emplace(points); }, [&] { search.reset(); }};
  };
  const std::vector<Contestant> all{build(kd_tree, "kd_tree"), build(r_tree, "r_tree"),
                                    build(cell_grid, "cell_grid"),
                                    build(brute_force, "brute_force")};
  const auto times = lab.stopwatch.run("search/build/" + std::to_string(D) + "-D", all, budget);
  std::map<std::string, double> seconds;
  for (std::size_t i = 0; i < all.size(); ++i) seconds[all[i].name] = times[i].best();
  return seconds;
}

// All methods on one question; brute force on a few of the targets.
template <int D>
void time_question(Lab& lab, const recon::PointCloud<double>& points,
                   const recon::PointList<double, D>& at, const recon::NeighbourRule& rule,
                   const std::vector<std::string>& labels, std::map<std::string, double>& build,
                   Table& table) {
  const recon::PointList<double, D> some(
      at.begin(), at.begin() + static_cast<std::ptrdiff_t>(std::min(few_targets, at.size())));
  const recon::PointCloud<double> targets(recon::points_of(at)), few(recon::points_of(some));
  std::vector<recon::NeighbourList<double>> found(std::size(methods));
  std::vector<Contestant> all;
  for (std::size_t m = 0; m < std::size(methods); ++m) {
    recon::NeighbourOptions options;
    options.search = methods[m];
    options.threads = lab.context.threads;
    const auto& where = methods[m] == recon::SearchMethod::brute_force ? few : targets;
    all.push_back(
        {method_names[m],
         [&, m, options] { found[m] = find_neighbours(points, where, rule, {}, options); },
         [&, m] { found[m] = {}; }});
    all.back().run();
  }
  const std::string name = labels[0] + "/" + labels[1] + "/" + labels[2];
  bool good = true;
  for (std::size_t m = 1; m + 1 < std::size(methods); ++m)
    good = lab.checks.hold(same(found[m], found[0]),
                           name + ": " + method_names[m] + " finds other neighbours") &&
           good;
  auto& reference = found.back();  // of the first targets only
  const auto entries = static_cast<std::size_t>(reference.offsets.back());
  good = lab.checks.hold(entries <= found[0].indices.size() &&
                             std::equal(reference.indices.begin(), reference.indices.end(),
                                        found[0].indices.begin()),
                         name + ": brute force finds other neighbours") &&
         good;
  const double mean = static_cast<double>(found[0].indices.size()) / static_cast<double>(at.size());
  std::vector<Times> times(all.size());
  if (good) times = lab.stopwatch.run("search/" + name, all, budget);
  for (std::size_t m = 0; m < all.size(); ++m) {
    const double total = times[m].best();
    const double alone = build.count(all[m].name) ? build[all[m].name] : std::nan("");
    const double asked = static_cast<double>(m + 1 < all.size() ? targets.size() : few.size());
    table.add({labels[0], labels[1], labels[2], all[m].name, number(mean), number(asked),
               good ? number(total * 1e3) : wrong_answer, number(alone * 1e3),
               number((total - alone) / asked * 1e6), number(total / asked * 1e6)});
  }
}

template <int D>
void time_dimension(Lab& lab, const CloudSize& size, std::size_t k, Table& table) {
  const std::string dimension = std::to_string(D) + "-D";
  progress("searches, " + dimension);
  const Cloud<double, D> cloud(size);
  const recon::PointCloud<double> points(cloud.from());
  auto build = time_building<D>(lab, points);
  const recon::NeighbourRule rules[] = {recon::Nearest{k},
                                        recon::Radius{radius_of(D, k, size.sources)}};
  const auto grid = grid_targets<D>(size.targets);
  for (const auto& rule : rules) {
    const std::string question =
        std::holds_alternative<recon::Nearest>(rule) ? "nearest k=" + std::to_string(k) : "radius";
    time_question<D>(lab, points, cloud.targets, rule, {dimension, question, "random"}, build,
                     table);
    time_question<D>(lab, points, grid, rule, {dimension, question, "grid"}, build, table);
  }
}

}  // namespace

Section run_search(Lab& lab) {
  const CloudSize size{lab.choose(cloud_size.sources, 50000, smoke_cloud_size.sources),
                       lab.choose(cloud_size.targets, 25000, smoke_cloud_size.targets)};
  Section section{
      "Searches",
      std::to_string(size.sources) + " sources of the cloud; " + std::to_string(size.targets) +
          " targets at random, and as many on a regular grid in its order. `total` is "
          "the "
          "whole call of find_neighbours on gathered points, `build` the construction of the "
          "search "
          "alone, "
          "and `query` the difference per target (the cell grid may choose other cells for a "
          "radius, "
          "so "
          "there it is an estimate). Brute force is asked for the first " +
          std::to_string(few_targets) +
          " targets only. All methods must give the same list to the bit before they are timed.",
      {},
      {}};
  Table table("search", {"dimension", "rule", "targets", "method", "neighbours", "asked",
                         "total ms", "build ms", "query us per target", "total us per target"});
  time_dimension<3>(lab, size, 20, table);
  time_dimension<2>(lab, size, 12, table);
  section.tables = {table};
  return section;
}

}  // namespace recon_bench
