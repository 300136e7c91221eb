// What the rules say about measured numbers.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "claim_list.hpp"

namespace recon::program {

// What one run of a study has measured.
struct Measured {
  std::vector<std::pair<std::string, double>> numbers;
  std::string note;      // why it stopped; empty: it did not
  bool refused = false;  // the program cannot make this run: it shows nothing

  void add(const std::string& name, double value) { numbers.emplace_back(name, value); }
  // NaN for a number that the run does not have.
  double value(const std::string& name) const;
};

struct RunKey {
  std::string variant, method;
  int grid = 0;
  auto operator<=>(const RunKey&) const = default;
};
using StudyResults = std::map<RunKey, Measured>;

// One number that a rule was asked about.
struct RuleCheck {
  std::string name;  // "32 to 64", "64"
  double value = 0;
  bool kept = false;
};

// A part of a claim for one series: a quantity of a method in a variant.
struct Judgement {
  std::string series, rule;
  double lower = 0, upper = 0;
  std::vector<RuleCheck> checks;  // none: not all runs have been made
  bool alone = false;             // none, because all runs that it is compared with stopped
  bool kept() const;              // all of them
  bool some() const;
};

enum class Verdict { holds, partly, fails, unknown };
std::string name_of(Verdict verdict);

// The orders of convergence between neighbouring grids, NaN where a number is missing or not
// positive.
std::vector<double> orders(const std::vector<int>& grids, const std::vector<double>& errors);

// Judges the parts of a claim by the runs on these grids; a part with grids of its own takes those
// of them that are among `grids` or, where `any` says so, all of them. Where a run ended and the one
// that it is compared with stopped, there is nothing to compare with, and no check: stopping is
// judged by "breaks", "diverges" and "survives", not by what is smaller than a number that is none.
std::vector<Judgement> judge(const Claim& claim, const std::map<std::string, Rule>& rules,
                             const StudyResults& results, const std::vector<int>& grids, bool any);

// "holds" where all judgements are kept on all grids, "does not reproduce" where none is kept on
// any, "holds partly" between; unknown where runs are missing, or all judgements are alone.
Verdict verdict_of(const std::vector<Judgement>& judgements);

}  // namespace recon::program
