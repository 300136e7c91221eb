// recon-mpm verify: the claims of the publications, measured.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "bending.hpp"
#include "claims.hpp"
#include "commands.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/progress.hpp"
#include "programs/common/text.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/run.hpp"
#include "recon/studies/errors.hpp"
#include "verification.hpp"

namespace recon::program {
namespace {

namespace fs = std::filesystem;

using Options = VerifyOptions;

std::string order_text(double order) {
  return std::isnan(order) ? "fails" : number(order, 3);
}

class Report {
 public:
  explicit Report(const Options& options)
      : options_(options), progress_("verify", total(), options.quiet) {}

  void add(const Claim& claim) {
    if (!wanted(claim.figure)) return;
    const auto& cells = options_.full ? claim.full_cells : claim.cells;
    std::vector<double> times{0.25, 0.375, 1};
    const auto rows = mpm::converge(
        [&](std::span<const std::string> more) {
          return load(claim.problem, claim.settings, more);
        },
        {claim.methods, cells, times});
    progress_.advance(1);
    double end = 0;
    for (const auto& row : rows) end = std::max(end, row.time);

    int kept = 0;
    std::string broken;
    for (const Expectation& expected : claim.expected) {
      const double order =
          mpm::slope(rows, expected.method, expected.field, claim.norm, claim.time * end);
      const bool holds = expected.at_least ? order >= expected.order : !(order > expected.order);
      kept += holds;
      if (!holds)
        broken += (broken.empty() ? "" : "; ") + expected.method + " " + expected.field + ": " +
                  order_text(order) + " where " + (expected.at_least ? "at least " : "at most ") +
                  number(expected.order, 3) + " was expected";
    }
    const std::string verdict = verdict_of(kept, static_cast<int>(claim.expected.size()));
    verdicts_.push_back({claim.figure, claim.statement, verdict});
    text_ += "## " + claim.figure + ": " + verdict + "\n\nClaim: " + claim.statement + "\n\n" +
             (broken.empty() ? "" : "Not as claimed: " + broken + ".\n\n") + "`" + claim.problem +
             ".toml`";
    for (const std::string& setting : claim.settings) text_ += ", `" + setting + "`";
    text_ += ", cells";
    for (const int n : cells) text_ += " " + std::to_string(n);
    text_ += ", norm " + claim.norm + ". Orders fitted to all grids:\n\n";
    text_ +=
        "| method | time | displacement | velocity | density | stress |\n"
        "| --- | --- | --- | --- | --- | --- |\n";
    for (const std::string& method : claim.methods)
      for (const double part : times) {
        text_ += "| " + method + " | " + (part == 1 ? "T" : part == 0.25 ? "T/4" : "3T/8");
        for (const char* field : mpm::error_fields)
          text_ += " | " + order_text(mpm::slope(rows, method, field, claim.norm, part * end));
        text_ += " |\n";
      }
    std::string failures;
    for (const auto& row : rows)
      if (!row.failure.empty() && row.field == "displacement" && row.norm == "l2" &&
          row.time == end)
        failures +=
            "- " + row.method + ", " + std::to_string(row.cells) + " cells: " + row.failure + "\n";
    text_ += "\n" + (failures.empty() ? "" : failures + "\n");
    text_ += picture(options_, claim.figure, plot_of(claim, rows, end));
  }

  void add(const Account& account) {
    if (!wanted(account.figure)) return;
    text_ += "## " + account.figure + "\n\n" + account.statement + "\n\n" +
             "| method | momentum defect of the map, most | change of momentum | error of angular "
             "momentum | lowest and highest total energy | energy at the end |\n"
             "| --- | --- | --- | --- | --- | --- |\n";
    LinePlot energies, momenta;
    energies.title = account.figure + ": energy";
    momenta.title = account.figure + ": sum of m |v|";
    energies.x_label = momenta.x_label = "time";
    energies.y_label = "energy";
    momenta.y_label = "momentum";
    for (const std::string& method : account.methods) {
      const std::string settings[] = {"method.name=" + method};
      std::visit([&](const auto& file) { run(file, method, energies, momenta); },
                 load(account.problem, account.settings, settings));
      progress_.advance(1);
    }
    text_ +=
        "\nMomenta are parts of the largest sum of m |v|, energies parts of the first total; "
        "angular "
        "momentum is compared with that of the exact motion, or of the start, as part of the "
        "start's.\n\n";
    text_ += picture(options_, account.figure + " energy", energies);
    text_ += picture(options_, account.figure + " momentum", momenta);
  }

  void add(const Snapshot& snapshot) {
    if (!wanted(snapshot.figure)) return;
    HeatMap map;
    map.title = snapshot.figure;
    map.colour_label = snapshot.quantity == "speed" ? "speed" : snapshot.quantity + " error";
    map.columns = static_cast<int>(snapshot.methods.size() == 1 ? snapshot.times.size()
                                                                : snapshot.methods.size());
    std::string largest;
    for (const double part : snapshot.times)
      for (const std::string& method : snapshot.methods) {
        const std::string settings[] = {"method.name=" + method};
        std::visit([&](const auto& file) { add_panel(snapshot, file, method, part, map, largest); },
                   load(snapshot.problem, snapshot.settings, settings));
        progress_.advance(1);
      }
    text_ += "## " + snapshot.figure + "\n\n" + snapshot.statement + " Largest values: " + largest +
             ".\n\n" + picture(options_, snapshot.figure, map);
  }

  void add(const BendingPart& part) {
    if (!wanted(part.figure)) return;
    Findings found = part.measure(options_, progress_);
    text_ += found.text;
    for (Verdict& verdict : found.verdicts) verdicts_.push_back(std::move(verdict));
  }

  void finish() const {
    std::string all =
        "# Verification\n\nWritten by `recon-mpm verify" +
        std::string(options_.full ? " --full" : "") +
        "`. An order is the slope of log(error) over log(h), fitted to all grids; "
        "\"second order\" asks for 1.75, \"does not converge\" for at most 0.5. T is a "
        "full period, at which errors of first order may cancel: T/4 and 3T/8 are "
        "beside it.\n\n| figure | claim | verdict |\n| --- | --- | --- |\n";
    for (const Verdict& v : verdicts_)
      all += "| " + v.figure + " | " + v.statement + " | " + v.verdict + " |\n";
    all += "\n" + text_;
    if (options_.out.empty()) {
      std::fputs(all.c_str(), stdout);
      return;
    }
    AtomicFile file(fs::path(options_.out) / "verification.md");
    file.write(all);
    file.commit();
    for (const Verdict& v : verdicts_)
      std::printf("%-18s %s: %s\n", v.verdict.c_str(), v.figure.c_str(), v.statement.c_str());
  }

 private:
  bool wanted(const std::string& figure) const {
    return figure.find(options_.only) != std::string::npos;
  }
  std::size_t total() const {
    std::size_t count = 0;
    for (const Claim& claim : claims()) count += wanted(claim.figure);
    for (const Account& account : accounts())
      count += wanted(account.figure) * account.methods.size();
    for (const Snapshot& snapshot : snapshots())
      count += wanted(snapshot.figure) * snapshot.methods.size() * snapshot.times.size();
    for (const BendingPart& part : bending_parts()) count += wanted(part.figure) * part.runs;
    return count;
  }

  static LinePlot plot_of(const Claim& claim, const std::vector<mpm::ConvergenceRow>& rows,
                          double end) {
    LinePlot plot;
    plot.title = claim.figure;
    plot.x_label = "cell size";
    plot.y_label = "error / error of the coarsest grid, " + claim.norm;
    plot.log_x = plot.log_y = true;
    plot.reference_slope = 2;
    for (const std::string& method : claim.methods)
      for (const char* field : mpm::error_fields) {
        Curve curve{claim.methods.size() > 1 ? method + " " + field : field,
                    {},
                    {},
                    CurveStyle::line_and_markers};
        for (const auto& row : rows)
          if (row.method == method && row.field == field && row.norm == claim.norm &&
              row.time == end) {
            curve.x.push_back(row.h);
            curve.y.push_back(row.error);
          }
        const double largest = curve.y.empty() ? 1 : curve.y.front();
        for (double& y : curve.y) y /= largest;
        if (!std::isnan(largest)) plot.curves.push_back(curve);
      }
    return plot;
  }

  // The size of a quantity at the particles, spread over a grid that is three times as fine as
  // theirs by Shepard's mean; nothing where no particle is near.
  template <int D>
  static void add_panel(const Snapshot& snapshot, const mpm::ProblemFile<D>& file,
                        const std::string& method, double part, HeatMap& map,
                        std::string& largest) {
    if constexpr (D == 2) {
      const mpm::Problem<D>& problem = file.problem;
      mpm::Simulation<D> simulation(problem);
      HeatMapPanel panel;
      panel.title = method + " at " + number(part * problem.time.end, 3);
      try {
        mpm::run_until(simulation, part * problem.time.end);
      } catch (const mpm::Failure& stop) {
        largest += (largest.empty() ? "" : ", ") + method + " " + stop.what();
        return;
      }
      const mpm::Particles<D>& particles = simulation.particles();
      std::vector<double> size(particles.size());
      for (std::size_t p = 0; p < size.size(); ++p) {
        if (snapshot.quantity == "speed") {
          size[p] = particles.v[p].norm();
          continue;
        }
        size[p] = mpm::error_of(simulation, *file.exact, p, snapshot.quantity);
      }
      const double h = problem.grid.h();
      const auto points = points_of(particles.x);
      panel.grid = covering_grid(bounding_box(points, "particles"), h / 6);
      const auto nodes = panel.grid.nodes();
      const Reconstruction fit =
          reconstruct(points, nodes.view(), {.degree = 0, .neighbours = Radius{0.45 * h}});
      panel.values.resize(panel.grid.size());
      fit.apply(field_of(size), field_of(panel.values));
      for (const auto& x : particles.x) panel.dots.push_back({x[0], x[1]});
      largest += (largest.empty() ? "" : ", ") + panel.title + " " +
                 number(*std::max_element(size.begin(), size.end()), 3);
      map.panels.push_back(std::move(panel));
    } else {
      (void)snapshot, (void)file, (void)method, (void)part, (void)map, (void)largest;
    }
  }

  template <int D>
  void run(const mpm::ProblemFile<D>& file, const std::string& method, LinePlot& energies,
           LinePlot& momenta) {
    mpm::Simulation<D> simulation(file.problem);
    Curve kinetic{method + " kinetic", {}, {}, CurveStyle::line},
        strain = kinetic, total = kinetic,
        particles{method + " particles", {}, {}, CurveStyle::line}, nodes = particles;
    strain.name = method + " strain";
    total.name = method + " total";
    nodes.name = method + " nodes";
    std::optional<mpm::Ledger> start;
    mpm::Ledger now;
    double defect = 0, largest = 0;
    std::string failure;
    try {
      mpm::run_until(simulation, file.problem.time.end, [&] {
        now = mpm::account(simulation, start);
        if (!start) start = now;
        double of_particles = 0, of_nodes = 0;
        for (std::size_t p = 0; p < simulation.particles().size(); ++p)
          of_particles += simulation.particles().mass[p] * simulation.particles().v[p].norm();
        for (std::size_t i = 0; i < simulation.nodes().mass.size(); ++i)
          of_nodes += simulation.nodes().mass[i] * simulation.nodes().mapped[i].norm();
        defect = std::max(defect, mpm::distance(now.momentum, now.node_momentum));
        largest = std::max(largest, of_particles);
        for (Curve* curve : {&kinetic, &strain, &total, &particles, &nodes})
          curve->x.push_back(now.time);
        kinetic.y.push_back(now.kinetic);
        strain.y.push_back(now.strain);
        total.y.push_back(now.total());
        particles.y.push_back(of_particles);
        nodes.y.push_back(of_nodes);
      });
    } catch (const mpm::Failure& stop) {
      failure = stop.what();
    }
    // Of the exact motion where there is one (its body force turns the ring), else of the start.
    const double angular =
        file.exact ? exact_angular_momentum(simulation, *file.exact)[2] : start->angular[2];
    const auto [low, high] = std::minmax_element(total.y.begin(), total.y.end());
    const double first = total.y.front();
    text_ += "| " + method + " | " + number(defect / largest, 3) + " | " +
             number(mpm::distance(now.momentum, start->momentum) / largest, 3) + " | " +
             (std::abs(start->angular[2]) > 1e-9 * start->mass
                  ? number((now.angular[2] - angular) / start->angular[2], 3)
                  : "-") +
             " | " + number(*low / first, 4) + " .. " + number(*high / first, 4) + " | " +
             number(total.y.back() / first, 4) + " |" + (failure.empty() ? "" : " " + failure) +
             "\n";
    energies.curves.insert(energies.curves.end(), {kinetic, strain, total});
    momenta.curves.insert(momenta.curves.end(), {particles, nodes});
  }

  const Options& options_;
  Progress progress_;
  std::string text_;
  std::vector<Verdict> verdicts_;
};

void run(const Options& options) {
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(fs::path(options.out) / picture_folder, error);
    with_exit_code(no_output,
                   [&] { const AtomicFile probe(fs::path(options.out) / "verification.md"); });
  }
  Report report(options);
  for (const Claim& claim : claims()) report.add(claim);
  for (const Account& account : accounts()) report.add(account);
  for (const Snapshot& snapshot : snapshots()) report.add(snapshot);
  for (const BendingPart& part : bending_parts()) report.add(part);
  with_exit_code(no_output, [&] { report.finish(); });
}

}  // namespace

Command add_verify(CLI::App& app) {
  auto* command = app.add_subcommand("verify", "the claims of the publications, measured");
  auto options = std::make_shared<Options>();
  command->add_flag("--full", options->full, "finer grids; takes long");
  command->add_option("--only", options->only, "figures whose name contains this text")
      ->type_name("TEXT");
  command
      ->add_option("--out", options->out,
                   "folder for verification.md and verification/*.png (default: the terminal)")
      ->type_name("FOLDER");
  command->add_flag("--quiet", options->quiet, "no progress");
  return [options] { run(*options); };
}

}  // namespace recon::program
