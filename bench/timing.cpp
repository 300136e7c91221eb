#include "timing.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <stdexcept>

namespace recon_bench {
namespace {

// Seconds for one contest, and rounds.
struct Effort {
  double budget;
  int fewest, most;
};
constexpr Effort full_effort{10, 5, 25}, quick_effort{1, 3, 9}, smoke_effort{0, 1, 1};

constexpr double shortest_sample = 5e-3;  // seconds: what is faster is run several times
constexpr long most_repeats = 10000;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class Collector : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) latest[run.run_name.function_name] = run;
  }
  std::map<std::string, Run> latest;
};

}  // namespace

double median_of(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

double Times::best() const {
  if (seconds.empty()) return std::numeric_limits<double>::quiet_NaN();
  return *std::min_element(seconds.begin(), seconds.end());
}

double Times::median() const {
  return median_of(seconds);
}

double speedup(const Times& subject, const Times& reference) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(subject.seconds.size(), reference.seconds.size()); ++i)
    ratios.push_back(reference.seconds[i] / subject.seconds[i]);
  return median_of(ratios);
}

struct Stopwatch::Runs {
  std::vector<benchmark::BenchmarkReporter::Run> list;
};

Stopwatch::Stopwatch(const Context& context) : runs_(std::make_unique<Runs>()) {
  const Effort effort = context.smoke ? smoke_effort : context.quick ? quick_effort : full_effort;
  budget_ = effort.budget;
  fewest_rounds_ = effort.fewest;
  most_rounds_ = effort.most;
}

Stopwatch::~Stopwatch() = default;

std::vector<Times> Stopwatch::run(const std::string& contest,
                                  const std::vector<Contestant>& contestants, double budget_factor,
                                  int rounds_suffice) {
  progress("  " + contest);
  std::vector<Times> times(contestants.size());
  std::vector<std::string> names;
  double round = 0;  // seconds
  benchmark::ClearRegisteredBenchmarks();
  for (const Contestant& contestant : contestants) {
    if (contestant.prepare) contestant.prepare();
    const double begin = now();
    contestant.run();
    const double once = now() - begin;
    const long repeats = budget_ > 0
                             ? std::clamp(static_cast<long>(shortest_sample / std::max(once, 1e-9)),
                                          1L, most_repeats)
                             : 1;
    round += once * static_cast<double>(repeats);
    names.push_back(contest + "/" + contestant.name);
    benchmark::RegisterBenchmark(names.back().c_str(),
                                 [&contestant](benchmark::State& state) {
                                   for (auto _ : state) {
                                     if (contestant.prepare) {
                                       state.PauseTiming();
                                       contestant.prepare();
                                       state.ResumeTiming();
                                     }
                                     contestant.run();
                                   }
                                 })
        ->Iterations(repeats)
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
  }
  const int fewest = std::min(fewest_rounds_, rounds_suffice);
  const int rounds =
      static_cast<int>(std::clamp(budget_ * budget_factor / std::max(round, 1e-9),
                                  static_cast<double>(fewest), static_cast<double>(most_rounds_)));
  for (int r = 0; r < rounds; ++r) {
    Collector collector;
    benchmark::RunSpecifiedBenchmarks(&collector, "all");
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      auto& run = collector.latest.at(names[i]);
      run.repetition_index = r;
      run.repetitions = rounds;
      times[i].seconds.push_back(run.real_accumulated_time / static_cast<double>(run.iterations));
      runs_->list.push_back(run);
    }
  }
  benchmark::ClearRegisteredBenchmarks();
  return times;
}

void Stopwatch::write_json(const std::filesystem::path& path) const {
  std::ofstream file(path);
  benchmark::JSONReporter reporter;
  reporter.SetOutputStream(&file);
  reporter.SetErrorStream(&file);
  reporter.ReportContext(benchmark::BenchmarkReporter::Context());
  if (!runs_->list.empty()) reporter.ReportRuns(runs_->list);
  reporter.Finalize();
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

void progress(const std::string& text) {
  static const double begin = now();
  std::fprintf(stderr, "[%5.1f s] %s\n", now() - begin, text.c_str());
}

}  // namespace recon_bench
