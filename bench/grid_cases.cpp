// Reconstruction on a grid: speed, share of the peak, growth with the number of particles, memory.
#include "lab.hpp"

#if __has_include("recon/grid/grid_moments.hpp")

#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "flops.hpp"
#include "grid_workload.hpp"
#include "hand_grid.hpp"
#include "memory.hpp"

namespace recon_bench {
namespace {

constexpr double peak_goal = 0.3, growth_goal = 1.2, memory_goal = 0.1;
constexpr double float_goal = 1.5, threads_goal = 1.8, density_goal = 1.1, hand_goal = 2;

// The linear field at every node that reaches degree 1, in units of rounding times condition.
template <class Scalar>
double worst_error(const GridWorkload<Scalar>& workload, int components,
                   const recon::BasicGridReconstruction<Scalar>& fit) {
  constexpr double margin = 100;
  const double rounding = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  double worst = 0;
  for (std::size_t i = 0; i < workload.grid().size(); ++i) {
    if (fit.report()[i].degree < 1) continue;
    const auto index = workload.grid().index(i);
    std::array<Scalar, 3> x;
    for (int d = 0; d < 3; ++d) x[d] = workload.grid().coordinate(index[d], d);
    for (int c = 0; c < components; ++c) {
      const double exact = GridWorkload<Scalar>::linear(x, c);
      const double difference =
          std::abs(static_cast<double>(fit.values()(static_cast<Eigen::Index>(i), c)) - exact);
      const double tolerance = margin * terms(3, 1) * rounding * std::max(1.0, std::abs(exact)) *
                               std::max(1.0f, fit.report()[i].amplification) /
                               static_cast<double>(fit.report()[i].smallest_pivot);
      worst = std::isfinite(difference) ? std::max(worst, difference / tolerance) : 1e300;
    }
  }
  return worst;
}

// reconstruct() with the same particles, weight and support, on a workload that it can do quickly.
double worst_against_reconstruct(const GridSetting& setting, std::size_t cells, int threads) {
  const GridWorkload<double> workload(setting, cells, &GridWorkload<double>::curved);
  const auto fit = workload.reconstruct(threads);
  recon::Options options;
  options.degree = 1;
  options.weight = setting.weight;
  options.form = recon::WeightForm::tensor_product;
  options.neighbours = recon::Radius{0.5 * setting.nodes_per_axis / static_cast<double>(cells)};
  options.solver = recon::Solver::moment_matrix;
  const auto nodes = workload.grid().nodes();
  const recon::Reconstruction reference =
      recon::reconstruct(workload.points(), nodes.view(), options);
  const Eigen::MatrixXd values = reference.apply(workload.fields()[0]);
  double worst = 0;
  for (std::size_t i = 0; i < nodes.view().size(); ++i) {
    if (reference.report()[i].status != recon::FitStatus::full) continue;
    for (int c = 0; c < values.cols(); ++c) {
      const auto row = static_cast<Eigen::Index>(i);
      const double difference = std::abs(values(row, c) - fit.values()(row, c));
      const double tolerance = 1000 * std::numeric_limits<double>::epsilon() *
                               std::max(1.0, std::abs(values(row, c))) /
                               static_cast<double>(reference.report()[i].smallest_pivot);
      worst = std::isfinite(difference) ? std::max(worst, difference / tolerance) : 1e300;
    }
  }
  return worst;
}

// The velocities written by hand at all nodes, in units of rounding times condition.
double worst_against_hand(const GridWorkload<double>& workload,
                          const recon::GridReconstruction& fit, std::size_t cells, int threads) {
  const auto by_hand = hand_written::velocity_on_grid(workload.places(), workload.velocities(),
                                                      static_cast<int>(cells), threads);
  double worst = by_hand.size() == workload.grid().size() ? 0 : 1e300;
  for (std::size_t i = 0; i < by_hand.size() && worst < 1e300; ++i)
    for (int c = 0; c < 3; ++c) {
      const double ours = fit.values()(static_cast<Eigen::Index>(i), c);
      const double difference = std::abs(ours - by_hand[i][static_cast<std::size_t>(c)]);
      const double tolerance = 1000 * std::numeric_limits<double>::epsilon() *
                               std::max(1.0, std::abs(ours)) /
                               static_cast<double>(fit.report()[i].smallest_pivot);
      worst = std::isfinite(difference) ? std::max(worst, difference / tolerance) : 1e300;
    }
  return worst;
}

// Particle-node pairs, as the reports count them.
template <class Reports>
double pairs_of(const Reports& reports) {
  double pairs = 0;
  for (std::size_t i = 0; i < reports.size(); ++i) pairs += reports[i].neighbours;
  return pairs;
}

struct GridTable {
  Table times{
      "grid",
      {"workload", "particles", "call", "ms", "ns per particle", "time / reference", "reference"}};
};

void time_setting(Lab& lab, const GridSetting& setting, GridTable& tables) {
  progress(std::string("grid, ") + setting.name);
  const int threads = lab.context.threads;
  const std::size_t cells = lab.choose(50, 50, 8);
  const GridWorkload<double> wide(setting, cells);
  const GridWorkload<float> narrow(setting, cells);
  const std::string name = std::string("grid 3-D, ") + setting.name;
  using recon::InstructionSet;

  std::optional<recon::GridReconstruction> fit = wide.reconstruct(threads);
  std::optional<recon::GridReconstructionF> narrow_fit = narrow.reconstruct(threads);
  std::optional<recon::GridMoments> moments;
  bool good = lab.checks.within(worst_error(wide, setting.components, *fit), name + ", double");
  good =
      lab.checks.within(worst_error(narrow, setting.components, *narrow_fit), name + ", float") &&
      good;
  good = lab.checks.within(worst_against_reconstruct(setting, lab.choose(20, 12, 6), threads),
                           name + ", against reconstruct()") &&
         good;
  if (!good) {
    tables.times.add({name, "", wrong_answer, "", "", "", ""});
    return;
  }
  const double pairs = pairs_of(fit->report());
  const bool with_hand = setting.at_nodes;  // written for this workload alone
  if (with_hand && !lab.checks.within(worst_against_hand(wide, *fit, cells, threads),
                                      name + ", the one by hand"))
    return;

  std::vector<Contestant> all{
      {"reconstruct", [&] { fit = wide.reconstruct(threads); }, [&] { fit.reset(); }},
      {"moments", [&] { moments.emplace(wide.moments(threads)); }, [&] { moments.reset(); }},
      {"reconstruct_float", [&] { narrow_fit = narrow.reconstruct(threads); },
       [&] { narrow_fit.reset(); }}};
  if (threads > 1)
    all.push_back(
        {"reconstruct_one_thread", [&] { fit = wide.reconstruct(1); }, [&] { fit.reset(); }});
  for (const InstructionSet set : recon::available_instruction_sets())
    all.push_back({"reconstruct_" + std::string(name_of(set)),
                   [&, set] { fit = wide.reconstruct(threads, set); }, [&] { fit.reset(); }});
  const std::vector<std::array<double, 3>> velocity = wide.velocities();
  std::vector<std::array<double, 3>> by_hand;
  if (with_hand)
    all.push_back({"by hand",
                   [&] {
                     by_hand = hand_written::velocity_on_grid(wide.places(), velocity,
                                                              static_cast<int>(cells), threads);
                   },
                   [&] { by_hand = {}; }});
  const auto list = lab.stopwatch.run("grid/" + std::string(setting.name), all);
  std::map<std::string, Times> times;
  for (std::size_t i = 0; i < all.size(); ++i) times[all[i].name] = list[i];

  const double particles = static_cast<double>(wide.particles());
  const auto ns = [&](const std::string& call) { return times[call].best() / particles * 1e9; };
  const Times& plain = times["reconstruct"];
  for (const Contestant& one : all)
    tables.times.add({setting.name, number(particles), one.name,
                      number(times[one.name].best() * 1e3), number(ns(one.name)),
                      number(speedup(plain, times[one.name])), "reconstruct"});

  const double flops = pairs * grid_flops_per_pair(3, setting.components);
  const double rate = flops / times["moments"].best();
  lab.summary.at_least(name, "moments: GFLOP/s of the direct formulas against the peak", rate / 1e9,
                       lab.limits.flops_double / 1e9, rate / lab.limits.flops_double, peak_goal);
  if (with_hand)
    lab.summary.at_least(name, "grid, ns per particle against sums by hand", ns("reconstruct"),
                         ns("by hand"), speedup(plain, times["by hand"]), hand_goal);
  lab.summary.at_least(name, "grid, ns per particle: float against double", ns("reconstruct_float"),
                       ns("reconstruct"), speedup(times["reconstruct_float"], plain), float_goal);
  if (threads > 1)
    lab.summary.at_least(
        name, "grid, ns per particle: " + std::to_string(threads) + " threads against one",
        ns("reconstruct"), ns("reconstruct_one_thread"),
        speedup(plain, times["reconstruct_one_thread"]), threads_goal);
}

// Ten times as many particles, and the bytes that the call needs beyond what goes in and comes out.
void time_growth(Lab& lab, const GridSetting& setting, GridTable& tables) {
  const int threads = lab.context.threads;
  const std::string name = std::string("grid 3-D, ") + setting.name;
  const std::size_t sizes[] = {lab.choose(50, 50, 6), lab.choose(108, 80, 12)};  // cells per axis
  double per_particle[2], particles[2];
  for (int i = 0; i < 2; ++i) {
    progress("grid, " + std::string(setting.name) + ", " + std::to_string(sizes[i]) + "^3 cells");
    const GridWorkload<double> workload(setting, sizes[i]);
    std::optional<recon::GridReconstruction> fit;
    particles[i] = static_cast<double>(workload.particles());
    const HeapUse use = heap_use([&] { fit = workload.reconstruct(threads); });
    if (!lab.checks.within(worst_error(workload, setting.components, *fit),
                           name + ", " + number(particles[i]) + " particles"))
      return;
    const std::vector<Contestant> all{
        {"reconstruct", [&] { fit = workload.reconstruct(threads); }, [&] { fit.reset(); }}};
    const auto times = lab.stopwatch.run(
        "grid/" + std::string(setting.name) + "/" + number(particles[i]), all, 0.5, 3);
    per_particle[i] = times[0].best() / particles[i] * 1e9;
    tables.times.add({setting.name, number(particles[i]), "reconstruct",
                      number(times[0].best() * 1e3), number(per_particle[i]),
                      number(per_particle[i] / per_particle[0]), "the smaller one"});
    if (i == 0) {
      const double in = particles[0] * (3 + setting.components) * sizeof(double);
      const double out =
          static_cast<double>(workload.grid().size()) *
          (static_cast<double>(setting.components) * sizeof(double) + sizeof(recon::FitReport));
      const double beyond = static_cast<double>(use.peak) - static_cast<double>(use.after);
      lab.summary.at_most(name, "grid: MB beyond particles and results, against both", beyond / 1e6,
                          (in + out) / 1e6, beyond / (in + out), memory_goal);
    }
  }
  lab.summary.at_most(name,
                      "grid: ns per particle, " + number(particles[1]) + " against " +
                          number(particles[0]) + " particles",
                      per_particle[1], per_particle[0], per_particle[1] / per_particle[0],
                      growth_goal);
}

// As many particles in fewer cells, 1 to 125 in each, and as many as 8 in each spread unevenly.
void time_density(Lab& lab, const GridSetting& setting, Table& table) {
  const int threads = lab.context.threads;
  const std::size_t across = lab.choose(96, 96, 12);  // particles along an axis
  double at_8 = std::nan("");
  // Adds a row; the answer is its time per particle.
  const auto row = [&](const std::string& density, std::size_t per_axis, bool uneven) {
    progress("grid, " + std::string(setting.name) + ", " + density + " per cell");
    const GridWorkload<double> workload(setting, across / per_axis, &GridWorkload<double>::linear,
                                        per_axis, uneven);
    std::optional<recon::GridReconstruction> fit = workload.reconstruct(threads);
    if (!lab.checks.within(worst_error(workload, setting.components, *fit),
                           std::string(setting.name) + ", " + density + " per cell"))
      return std::nan("");
    const std::vector<Contestant> all{
        {"reconstruct", [&] { fit = workload.reconstruct(threads); }, [&] { fit.reset(); }}};
    const auto times = lab.stopwatch.run(
        "grid/" + std::string(setting.name) + "/" + density + " per cell", all, 0.5, 3);
    const double ns = times[0].best() / static_cast<double>(workload.particles()) * 1e9;
    if (std::isnan(at_8)) at_8 = ns;
    table.add({setting.name, density, std::to_string(workload.particles()), number(ns),
               number(ns / at_8)});
    return ns;
  };
  const std::string name = std::string("grid 3-D, ") + setting.name;
  row("8", 2, false);
  for (const std::size_t per_axis : {1, 3, 4, 5}) {
    const std::string density = std::to_string(per_axis * per_axis * per_axis);
    const double ns = row(density, per_axis, false);
    if (per_axis == 4)
      lab.summary.at_most(name, "grid: ns per particle, 64 per cell against 8", ns, at_8, ns / at_8,
                          density_goal);
  }
  const double uneven = row("8 on average, uneven", 2, true);
  lab.summary.note(name, "grid: ns per particle, spread unevenly against 8 in each cell", uneven,
                   at_8, uneven / at_8);
}

}  // namespace

Section run_grid(Lab& lab) {
  Section section{
      "Grids",
      "Jittered particles, 8 in each cell, in the order of a lattice; degree 1, tensor-product "
      "B-splines of natural width. The field is linear, so that every node is known. `reconstruct` "
      "is "
      "reconstruct_on_grid from views to values and reports, `moments` the construction of "
      "GridMoments. "
      "The share of the peak counts, for every pair of a particle and a node, " +
          number(grid_flops_per_pair(3, 3)) + " (3 components) or " +
          number(grid_flops_per_pair(3, 7)) +
          " (7) operations; see flops.hpp. Memory counts operator new at its most, less what stays "
          "as "
          "reports; the particles are 24 bytes and 8 per component.",
      {},
      {}};
  GridTable tables;
  for (const GridSetting& setting : grid_settings) time_setting(lab, setting, tables);
  for (const GridSetting& setting : grid_settings) time_growth(lab, setting, tables);
  Table density{
      "grid_density",
      {"workload", "particles per cell", "particles", "ns per particle", "against 8 per cell"}};
  for (const GridSetting& setting : grid_settings) time_density(lab, setting, density);
  section.tables = {tables.times, density};
  return section;
}

}  // namespace recon_bench

#else

namespace recon_bench {

Section run_grid(Lab&) {
  return {"Grids", "This version of recon has no reconstruction on grids.", {}, {}};
}

}  // namespace recon_bench

#endif
