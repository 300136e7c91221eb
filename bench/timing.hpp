// Contests: several ways to do one thing, timed in turn, A B C A B C ..., by Google Benchmark.
//
// A machine that is busy or changes its clock slows all contestants of a round alike. So what
// counts is the ratio of two times of the same round, and of these the median; beside it stand the
// least times. The number of rounds follows from a budget of seconds, so that a run takes as long
// on a slow machine as on a fast one.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "context.hpp"

namespace recon_bench {

struct Contestant {
  std::string name;
  std::function<void()> run;           // what is timed
  std::function<void()> prepare = {};  // before each run, not timed
};

// The times of one contestant, in seconds per run, one of each round.
class Times {
 public:
  std::vector<double> seconds;

  double best() const;    // NaN where there are none
  double median() const;  // NaN where there are none
};

// How many times faster `subject` is than `reference`: the median over the rounds.
double speedup(const Times& subject, const Times& reference);

double median_of(std::vector<double> values);  // NaN of none

class Stopwatch {
 public:
  explicit Stopwatch(const Context& context);
  ~Stopwatch();

  // Each contestant runs once to warm up, then in every round. Times in the contestants' order. For
  // contests that are shorter or longer than usual: a factor of the budget, and a bound on the
  // least number of rounds.
  std::vector<Times> run(const std::string& contest, const std::vector<Contestant>& contestants,
                         double budget_factor = 1, int rounds_suffice = 1000);

  // Google Benchmark's JSON of all runs so far.
  void write_json(const std::filesystem::path& file) const;

 private:
  struct Runs;
  std::unique_ptr<Runs> runs_;
  double budget_;
  int fewest_rounds_, most_rounds_;
};

// One line on the standard error.
void progress(const std::string& text);

}  // namespace recon_bench
