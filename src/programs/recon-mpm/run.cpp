// recon-mpm run PROBLEM: one run, with frames, a ledger and checkpoints.
#include "recon/runs/run.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "problem_options.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/json.hpp"
#include "programs/common/launch.hpp"
#include "programs/common/progress.hpp"
#include "programs/common/started.hpp"
#include "programs/common/text.hpp"
#include "recon/io/picture.hpp"
#include "recon/io/read.hpp"
#include "run_on.hpp"
#include "stop_signals.hpp"

namespace recon::program {
namespace {

namespace fs = std::filesystem;

struct RunCommand {
  ProblemOptions problem;
  std::string out, restart, device;
  bool overwrite = false, quiet = false, json = false;
};

void print_line(const char* name, const std::string& text) {
  std::printf("%-14s %s\n", name, text.c_str());
}

std::string momentum(const std::array<double, 3>& p, int dimension) {
  std::string text = "(" + number(p[0]);
  for (int d = 1; d < dimension; ++d) text += ", " + number(p[d]);
  return text + ")";
}

template <int D>
void print_summary(const mpm::ProblemFile<D>& file, const mpm::RunResult& result, double seconds,
                   const std::string& folder) {
  const mpm::Problem<D>& problem = file.problem;
  const mpm::Ledger &first = result.first, &last = result.last;
  print_line("problem", file.title.empty() ? "untitled" : file.title);
  print_line("method", problem.method.name + ", " + std::to_string(D) + "-D, " +
                           counted(result.forecast.particles, "particle") + ", cells of " +
                           number(problem.grid.h()));
  print_line("time", number(result.time) + " after " +
                         counted(static_cast<std::size_t>(result.steps), "step") + " in " +
                         number(seconds, 3) + " s");
  if (result.longest_step > 0) {
    std::string text = number(result.shortest_step) + " to " + number(result.longest_step);
    if (problem.time.rule == mpm::StepRule::adaptive)
      text += ", the shortest for particle " + std::to_string(result.limiting_particle);
    print_line("step", text);
  }
  print_line("mass", number(first.mass) + " -> " + number(last.mass));
  print_line("momentum", momentum(first.momentum, D) + " -> " + momentum(last.momentum, D));
  if (D > 1) {
    const auto angular = [](const mpm::Ledger& ledger) {
      return D == 2 ? number(ledger.angular[2]) : momentum(ledger.angular, 3);
    };
    print_line("angular", angular(first) + " -> " + angular(last));
  }
  print_line("map defect", number(result.largest_momentum_defect, 3) +
                               " at most, of momentum between particles and nodes");
  print_line("energy", number(first.total()) + " -> " + number(last.total()) + " (kinetic " +
                           number(last.kinetic) + ", strain " + number(last.strain) + ")");
  // The balance, where something does work.
  if (last.work != 0 && std::isfinite(last.work))
    print_line("work", number(last.work) + " of external forces; the balance of energy is " +
                           number(last.balance() - first.balance(), 3) + " off");
  print_line("energy error", "interpolation " + number(last.interpolation_error, 3) +
                                 ", algorithmic " + number(last.algorithmic_error, 3));
  if (result.rest) {
    const std::string ratios = "force out of balance " + number(result.rest->unbalanced, 3) +
                               ", kinetic over strain energy " + number(result.rest->kinetic, 3);
    if (result.rest->reached)
      print_line("rest", "reached: " + ratios);
    else
      print_line("rest",
                 std::string(result.stopped ? "not yet" : "NOT REACHED by the end of [time]") +
                     ": " + ratios + "; tolerance " + number(*problem.time.rest));
  }
  if (result.unfitted > 0)
    print_line("unfitted", "up to " + counted(result.unfitted, "node") +
                               " of a step had no data for a fit: mass-weighted instead");
  const auto print_mass = [&](const char* name, const std::optional<mpm::NegativeMass>& found) {
    if (!found) return;
    const auto at = problem.grid.position(found->node);
    std::string text = number(found->mass) + " of node " + std::to_string(found->node) + " at (";
    for (int d = 0; d < D; ++d) text += (d ? ", " : "") + number(at[d]);
    print_line(name, text + ") in step " + std::to_string(found->step));
  };
  print_mass("negative mass", result.negative_mass);
  print_mass("sign of mass", result.sign_change);
  if (result.sign_change)
    print_line("", "changed there: the mass passed through zero, so the results cannot be trusted");
  if (const auto& spread = result.spread)
    print_line("ranks", std::to_string(spread->ranks) + ", with " + std::to_string(spread->least) +
                            " to " + counted(spread->most, "particle") + " and " +
                            std::to_string(spread->copies) + " copies at the end, " +
                            number(spread->bytes_per_step / 1e3, 3) + " kB sent in a step");
  print_line("files", folder + ": " + counted(result.frames, "frame") + ", ledger.csv" +
                          (file.probes.empty() ? "" : ", probes.csv") + ", checkpoint.h5");
}

Json vector_array(const std::array<double, 3>& v, int dimension) {
  return Json::array_of(std::span(v).first(static_cast<std::size_t>(dimension)));
}

Json ledger_object(const mpm::Ledger& ledger, int dimension) {
  Json object = Json::object().set("mass", ledger.mass);
  object.set("momentum", vector_array(ledger.momentum, dimension));
  if (dimension == 2) object.set("angular", ledger.angular[2]);
  if (dimension == 3) object.set("angular", vector_array(ledger.angular, 3));
  object.set("kinetic", ledger.kinetic).set("strain", ledger.strain);
  object.set("energy", ledger.total());
  object.set("interpolation_error", ledger.interpolation_error);
  object.set("algorithmic_error", ledger.algorithmic_error);
  return object.set("work", ledger.work).set("balance", ledger.balance());
}

template <int D>
Json summary_object(const mpm::ProblemFile<D>& file, const mpm::RunResult& result, double seconds,
                    const std::string& folder) {
  const mpm::Problem<D>& problem = file.problem;
  Json object = Json::object();
  object.set("problem", file.title).set("method", problem.method.name).set("dimension", D);
  object.set("particles", result.forecast.particles).set("cell", problem.grid.h());
  Json expected = Json::object().set("steps", result.forecast.steps);
  expected.set("step", result.forecast.step.dt).set("memory", result.forecast.memory);
  expected.set("nodes", result.forecast.nodes);
  object.set("expected", expected.set("warnings", Json::array_of(result.forecast.warnings)));
  object.set("time", result.time).set("steps", result.steps).set("seconds", seconds);
  object.set("shortest_step", result.shortest_step).set("longest_step", result.longest_step);
  const bool adaptive = problem.time.rule == mpm::StepRule::adaptive && result.longest_step > 0;
  object.set("limiting_particle", adaptive ? Json(result.limiting_particle) : Json());
  object.set("first", ledger_object(result.first, D)).set("last", ledger_object(result.last, D));
  object.set("map_defect", result.largest_momentum_defect).set("unfitted", result.unfitted);
  const auto mass = [&](const std::optional<mpm::NegativeMass>& found) {
    if (!found) return Json();
    Json one = Json::object().set("step", found->step).set("node", found->node);
    return one.set("mass", found->mass);
  };
  object.set("negative_mass", mass(result.negative_mass));
  object.set("sign_change", mass(result.sign_change));
  Json rest;
  if (result.rest) {
    rest = Json::object().set("reached", result.rest->reached);
    rest.set("unbalanced", result.rest->unbalanced).set("kinetic", result.rest->kinetic);
    rest.set("tolerance", *problem.time.rest);
  }
  object.set("rest", rest);
  Json ranks;
  if (const auto& spread = result.spread) {
    ranks = Json::object().set("count", spread->ranks).set("least_particles", spread->least);
    ranks.set("most_particles", spread->most).set("copies", spread->copies);
    ranks.set("bytes_per_step", spread->bytes_per_step);
  }
  object.set("ranks", ranks);
  object.set("folder", folder).set("frames", result.frames);
  return object.set("stopped", result.stopped);
}

// Energies over time, from the ledger.
void draw_energies(const fs::path& ledger, const fs::path& picture, const std::string& title) {
  const ParticleTable table = read_particles(ledger);
  LinePlot plot;
  plot.title = title;
  plot.x_label = "time";
  plot.y_label = "energy";
  for (const char* name : {"kinetic", "strain", "total"})
    plot.curves.push_back({name, table.column("time"), table.column(name), CurveStyle::line});
  draw(picture, plot);
}

// As a shell reads it as one word.
std::string shell_word(const std::string& text) {
  const bool plain = text.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789_-+=./,:@%") == std::string::npos;
  if (plain && !text.empty()) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

// What to add to the command to go on from a checkpoint.
std::string go_on(const RunCommand& options, const fs::path& checkpoint) {
  return "the same command with --restart " + shell_word(checkpoint.string()) +
         (options.restart.empty() ? "" : " in the place of the one it has");
}

// Latest checkpoint of a run: none yet, or time and step.
struct Saved {
  bool any = false;
  double time = 0;
  std::int64_t steps = 0;
};

// What may help after a failure, as far as it can be done.
std::string advice(const RunCommand& options, const mpm::TimeOptions& time, double courant,
                   const fs::path& checkpoint, const Saved& saved) {
  std::string text;
  if (saved.any) {
    const bool fixed = time.rule == mpm::StepRule::fixed;
    text = checkpoint.string() + " holds its state at time " + number(saved.time) + ", step " +
           std::to_string(saved.steps) +
           ". To try from there with steps half as long: " + go_on(options, checkpoint) +
           " and --set " +
           (fixed ? "time.step=" + number(time.step / 2, 12)
                  : "time.courant=" + number(courant / 2, 12)) +
           ".\n";
  }
  return text +
         "Another method, grid or boundary needs a run from the start, with --overwrite or " +
         "another --out.";
}

// Does a run; what ends it comes with what can be done about it.
template <int D>
void with_advice(const RunCommand& options, const mpm::Problem<D>& problem,
                 const fs::path& checkpoint, const Saved& saved,
                 const std::function<void()>& run_it) {
  const mpm::TimeOptions& time = problem.time;
  const double courant = time.courant.value_or(problem.method.default_courant(D));
  try {
    run_it();
  } catch (const InvalidArgument& refusal) {
    const std::string what = "the run cannot begin: " + std::string(refusal.what());
    const std::string& about = refusal.argument();
    throw ProgramError(wrong_input, about.ends_with("memory") || about.ends_with("steps")
                                        ? what +
                                              "; [limits] memory and steps in the problem file say "
                                              "what it may take"
                                        : what);
  } catch (const mpm::Failure& failure) {
    throw ProgramError(internal_error, "the run stopped: " + std::string(failure.what()) + "\n" +
                                           advice(options, time, courant, checkpoint, saved));
  } catch (const mpm::OtherRun& error) {
    throw ProgramError(
        no_output, error.path().string() + ": is of another run" +
                       (fs::exists(checkpoint)
                            ? "; --restart " + shell_word(checkpoint.string()) + " goes on with it,"
                            : ";") +
                       " --overwrite replaces it, --out chooses another folder");
  } catch (const mpm::NoRestart& error) {
    throw ProgramError(wrong_input, error.what());
  } catch (const FileError& error) {
    throw ProgramError(no_output, error.what());
  }
}

// Ends with 128 and the number of the signal, if any process has seen one.
void fail_stopped(const Everyone& everyone, const std::string& what) {
  everyone.together([&] {
    const auto signal = static_cast<int>(everyone.greatest(StopSignals::seen()));
    if (signal != 0) throw ProgramError(static_cast<ExitCode>(128 + signal), what);
  });
}

template <int D>
void run(const RunCommand& options, mpm::ProblemFile<D>&& given, const Launch& launch) {
  // The particles are the run's alone.
  mpm::Particles<D> particles = std::exchange(given.problem.particles, {});
  const mpm::ProblemFile<D> file = given;
  given.problem.particles = std::move(particles);

  const fs::path problem_path = options.problem.file;
  const std::string name = problem_path.stem().string();
  mpm::RunOptions run_options;
  run_options.folder = options.out.empty() ? name + "_" + file.problem.method.name : options.out;
  run_options.name = name;
  run_options.restart = options.restart;
  run_options.overwrite = options.overwrite;
  constexpr std::size_t whole = 1000000;
  Progress progress("time " + number(file.problem.time.end), whole, options.quiet);
  std::size_t shown = 0;
  run_options.progress = [&](double time, std::int64_t, const mpm::TimeStep&) {
    const auto now = static_cast<std::size_t>(time / file.problem.time.end * whole);
    if (now > shown) progress.advance(now - shown);
    shown = std::max(shown, now);
  };
  run_options.begins = [&](const mpm::Forecast& forecast) {
    if (!options.json)
      print_line("expected", counted(forecast.particles, "particle") + ", " +
                                 counted(forecast.nodes, "node") + ", about " +
                                 number(forecast.steps) + " steps of " + number(forecast.step.dt) +
                                 ", " + number(forecast.memory / 1e6, 3) + " MB");
    std::fflush(stdout);
    for (const std::string& warning : forecast.warnings)
      std::fprintf(stderr, "warning: %s\n", warning.c_str());
  };
  const fs::path checkpoint = run_options.folder / "checkpoint.h5";
  Saved saved;
  run_options.saved = [&](double time, std::int64_t steps) { saved = {true, time, steps}; };
  run_options.stop = [] { return StopSignals::seen() != 0; };
  const Everyone& everyone = launch.everyone();
  mpm::RunResult result;
  everyone.together([&] {
    with_advice(options, file.problem, checkpoint, saved,
                [&] { result = run_on(launch, std::move(given), run_options); });
  });
  const std::string folder = run_options.folder.string();
  Json summary = summary_object(file, result, progress.seconds(), folder);
  if (options.json && (result.stopped || !file.output.ledger)) print_json(summary);
  if (!options.json) print_summary(file, result, progress.seconds(), folder);
  if (result.stopped)
    fail_stopped(everyone, "stopped at time " + number(saved.time) + ", step " +
                               std::to_string(saved.steps) +
                               ". To go on: " + go_on(options, checkpoint));
  if (!file.output.ledger || started().rank > 0) return;
  const fs::path picture = run_options.folder / "energy.png";
  std::string why_none;
  try {
    draw_energies(run_options.folder / "ledger.csv", picture,
                  name + ", " + file.problem.method.name);
  } catch (const FileError& error) {  // no gnuplot: the numbers are there all the same
    why_none = error.what();
  }
  if (options.json)
    print_json(summary.set("picture", why_none.empty() ? Json(picture.string()) : Json()));
  else
    print_line("picture", why_none.empty() ? picture.string() : "none: " + why_none);
}

}  // namespace

Command add_run(CLI::App& app, const Launch& launch) {
  auto* command = app.add_subcommand("run", "one run: frames for ParaView, a ledger, checkpoints");
  auto options = std::make_shared<RunCommand>();
  options->problem.add_to(*command, true);
  command->add_option("--out", options->out, "folder for the results (default: PROBLEM_METHOD)")
      ->type_name("FOLDER");
  command
      ->add_option("--restart", options->restart,
                   "a checkpoint.h5 of the same problem to go on from")
      ->type_name("FILE");
  command
      ->add_option("--device", options->device,
                   "where the steps are made: cpu, or gpu for methods that have a form for one")
      ->type_name("DEVICE")
      ->check(one_of({"cpu", "gpu"}));
  command->add_flag("--overwrite", options->overwrite, "replace the results of another run");
  command->add_flag("--quiet", options->quiet, "no progress");
  add_json_option(*command, options->json, "Options");
  return [options, &launch] {
    const Everyone& everyone = launch.everyone();
    std::optional<mpm::AnyProblem> problem;
    std::vector<std::string> more;
    if (!options->device.empty()) more.push_back("device=" + options->device);
    everyone.together([&] {
      const fs::path path = options->problem.file;
      if (launch.has_ranks() && fs::exists(path) && !fs::is_regular_file(path))
        fail_input(path.string() + ": is no ordinary file, of which every rank could read all");
      problem = options->problem.read(more);
      std::visit([&](const auto& file) { require_device(launch, file.device); }, *problem);
    });
    fail_stopped(everyone, "stopped before the run has begun; nothing was written");
    std::visit(
        [&](auto& file) {
          if (started().by_launcher) file.problem.threads = threads_of_a_rank(file.problem.threads);
          run(*options, std::move(file), launch);
        },
        *problem);
  };
}

}  // namespace recon::program
