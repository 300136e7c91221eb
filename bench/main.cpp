// recon-bench: how fast and how accurate recon is, compared with what one would write by hand.
//
// Exit status: 0 done (aims that are missed are printed, and no failure), 1 a wrong answer or wrong
// usage, 2 results that could not be written.
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "lab.hpp"
#include "machine.hpp"
#include "recon/core/parallel.hpp"
#include "report.hpp"

#if __has_include("accuracy.hpp")
#include "accuracy.hpp"
#define RECON_BENCH_HAS_ACCURACY
#endif

namespace recon_bench {
namespace {

struct Part {
  const char* name;
  Section (*run)(Lab&);
};
constexpr Part parts[] = {{"cloud", run_cloud},     {"search", run_search},
                          {"apply", run_apply},     {"sources", run_sources},
                          {"grid", run_grid},       {"instruction_sets", run_instruction_sets},
                          {"scaling", run_scaling},
#ifdef RECON_BENCH_HAS_MPM
                          {"mpm", run_mpm},
#endif
                          {"memory", run_memory}};

struct Command {
  Context context;
  std::vector<std::string> only;
  std::string peers;
  bool check_options = false;

  bool wants(const std::string& part) const {
    return only.empty() || std::find(only.begin(), only.end(), part) != only.end();
  }
};

void parse(CLI::App& app, Command& command) {
  std::vector<std::string> names;
  for (const Part& part : parts) names.emplace_back(part.name);
  names.emplace_back("accuracy");
  command.context.threads = recon::default_threads();
  app.add_flag("--quick", command.context.quick, "Everything within two minutes");
  app.add_flag("--smoke", command.context.smoke,
               "Every case once on a tiny workload, for its checks only");
  app.add_option("--out", command.context.out, "Folder for the results")->capture_default_str();
  app.add_option("--threads", command.context.threads, "Threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--only", command.only, "Some parts only")->check(CLI::IsMember(names));
  app.add_flag("--check-options", command.check_options, "Only look at the options");
  app.add_option("--peers", command.peers, "A table of other programs, made by bench/peers.py")
      ->check(CLI::ExistingFile);
}

// A wrong option gets the valid ones.
int explain(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);
  std::string valid;
  for (const CLI::Option* option : app.get_options()) valid += " " + option->get_name();
  std::fprintf(stderr, "recon-bench: %s\nThe options are%s\n", error.what(), valid.c_str());
  return 1;
}

int run(Command& command) {
  Context& context = command.context;
  Draft draft(context.out);
  const std::filesystem::path out = context.out;
  context.out = draft.folder();

  const auto machine = machine_description(context.threads);
  for (const auto& [name, text] : machine)
    benchmark::AddCustomContext("recon-bench: " + name, text);
  Stopwatch stopwatch(context);
  Summary summary;
  Checks checks;
  Lab lab{context, stopwatch, summary, checks};

  std::vector<Section> sections;
  sections.push_back(run_peak(lab));
  for (const Part& part : parts)
    if (command.wants(part.name)) sections.push_back(part.run(lab));
      // The accuracy studies: the one place where they are called.
#ifdef RECON_BENCH_HAS_ACCURACY
  if (command.wants("accuracy") && !context.smoke) {
    progress("accuracy");
    try {
      for (Section& section : run_accuracy(context)) sections.push_back(std::move(section));
    } catch (const std::exception& error) {
      checks.hold(false, std::string("accuracy: ") + error.what());
    }
  }
#endif
  if (!command.peers.empty()) sections.push_back(run_peers(lab, command.peers));

  write_report(context, machine, summary, checks, sections);
  stopwatch.write_json(context.out / "speed.json");
  draft.publish();
  progress("done: " + std::to_string(summary.met()) + " of " + std::to_string(summary.aims()) +
           " aims met; " + std::to_string(checks.failures().size()) + " of " +
           std::to_string(checks.done()) + " answers wrong; results in " + out.string());
  std::printf("%s", summary.table().markdown().c_str());
  return checks.failures().empty() ? 0 : 1;
}

}  // namespace
}  // namespace recon_bench

int main(int argc, char** argv) {
  recon_bench::Command command;
  CLI::App app("How fast and how accurate recon is; report.md, tables, raw times and pictures.",
               "recon-bench");
  recon_bench::parse(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return recon_bench::explain(app, error);
  }
  if (command.check_options) return 0;
  int only_name = 1;
  benchmark::Initialize(&only_name, argv);
  try {
    return recon_bench::run(command);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "recon-bench: %s\n", error.what());
    return 2;
  }
}
