#include "judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace recon::program {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The numbers of one quantity on some grids, and whether the runs stopped.
struct Series {
  std::vector<double> values;
  std::vector<bool> stopped;

  // What is said about the k-th grid, or about it and the one before, needs a number of a run that
  // stopped.
  bool lacks(std::size_t k, bool pair) const {
    const auto none = [&](std::size_t j) { return stopped[j] && std::isnan(values[j]); };
    return none(k) || (pair && none(k - 1));
  }
};

// Nothing where a run has not been made.
std::optional<Series> series(const StudyResults& results, const std::string& variant,
                             const std::string& method, const std::string& of,
                             const std::vector<int>& grids) {
  Series made;
  for (const int grid : grids) {
    const auto run = results.find({variant, method, grid});
    if (run == results.end() || run->second.refused) return {};
    made.values.push_back(run->second.value(of));
    made.stopped.push_back(!run->second.note.empty());
  }
  return made;
}

bool within(const Rule& rule, double value) {
  return value >= rule.lower && value <= rule.upper;
}

std::string pair_name(const std::vector<int>& grids, std::size_t finer) {
  return std::to_string(grids[finer - 1]) + " to " + std::to_string(grids[finer]);
}

std::vector<RuleCheck> check(const Rule& rule, const Part& part, const std::vector<int>& grids,
                             const Series& own, const Series& other) {
  std::vector<RuleCheck> checks;
  const std::vector<double>& values = own.values;
  const std::size_t n = grids.size();
  const bool compares = rule.kind == "difference" || (rule.kind == "ratio" && !part.to);
  if (rule.kind == "order" || rule.kind == "difference" || rule.kind == "falls") {
    if (n < 2) return checks;
    std::vector<double> numbers = orders(grids, values);
    if (rule.kind == "difference") {
      const std::vector<double> others = orders(grids, other.values);
      for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] -= others[k];
    }
    if (rule.kind == "falls")
      for (std::size_t k = 0; k + 1 < n; ++k) numbers[k] = values[k + 1] / values[k];
    const std::size_t first = rule.kind == "falls" || n < 3 ? 0 : n - 3;  // the two finest pairs
    for (std::size_t k = first; k + 1 < n; ++k) {
      if (compares && other.lacks(k + 1, true) && !own.lacks(k + 1, true)) continue;
      bool kept = within(rule, numbers[k]);
      // The coarsest run must have ended: what never runs does not diverge.
      if (rule.stops && std::isnan(values[k + 1]) && std::isfinite(values[0])) kept = true;
      checks.push_back({pair_name(grids, k + 1), numbers[k], kept});
    }
    return checks;
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (compares && other.lacks(k, false) && !own.lacks(k, false)) continue;
    double number = values[k];
    if (rule.kind == "ratio") number /= part.to ? *part.to : other.values[k];
    bool kept = within(rule, number);
    if (rule.kind == "printed")  // the unit, and the rounding of the last bit
      kept = std::abs(number - part.printed) <= part.unit * (1 + 1e-9);
    if (rule.kind == "breaks") kept = number == 1;
    checks.push_back({std::to_string(grids[k]), number, kept});
  }
  return checks;
}

}  // namespace

double Measured::value(const std::string& name) const {
  for (const auto& [each, value] : numbers)
    if (each == name) return value;
  return nan;
}

bool Judgement::kept() const {
  return !checks.empty() &&
         std::all_of(checks.begin(), checks.end(), [](const RuleCheck& each) { return each.kept; });
}
bool Judgement::some() const {
  return std::any_of(checks.begin(), checks.end(), [](const RuleCheck& each) { return each.kept; });
}

std::string name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::holds:
      return "holds";
    case Verdict::partly:
      return "holds partly";
    case Verdict::fails:
      return "does not reproduce";
    case Verdict::unknown:
      break;
  }
  return "cannot be judged";
}

std::vector<double> orders(const std::vector<int>& grids, const std::vector<double>& errors) {
  std::vector<double> found;
  for (std::size_t k = 1; k < grids.size(); ++k) {
    const bool known = errors[k - 1] > 0 && errors[k] > 0;
    found.push_back(known ? std::log(errors[k - 1] / errors[k]) /
                                std::log(static_cast<double>(grids[k]) / grids[k - 1])
                          : nan);
  }
  return found;
}

std::vector<Judgement> judge(const Claim& claim, const std::map<std::string, Rule>& rules,
                             const StudyResults& results, const std::vector<int>& grids, bool any) {
  std::vector<Judgement> judgements;
  for (const Part& part : claim.parts) {
    const Rule& rule = rules.at(part.rule);
    std::vector<int> on = part.grids.empty() ? grids : part.grids;
    if (!part.grids.empty() && !any)
      std::erase_if(
          on, [&](int grid) { return std::find(grids.begin(), grids.end(), grid) == grids.end(); });
    for (const std::string& variant : part.variants)
      for (const std::string& method : part.methods)
        for (const std::string& of : part.of) {
          Judgement made;
          made.series = (variant.empty() ? "" : variant + ", ") + method + ": " + of;
          made.rule = part.rule;
          made.lower = rule.lower;
          made.upper = rule.upper;
          if (rule.kind == "printed") {
            made.lower = part.printed - part.unit;
            made.upper = part.printed + part.unit;
          }
          const std::string other_method = part.than.empty() ? method : part.than;
          const std::string other_variant = part.than_variant.empty() ? variant : part.than_variant;
          const std::string other_of = part.than_of.empty() ? of : part.than_of;
          const bool compares =
              other_method != method || other_variant != variant || other_of != of;
          if (compares)
            made.rule += ", against " + (other_variant != variant ? other_variant + ", " : "") +
                         other_method + (other_of != of ? ": " + other_of : "");
          const auto values = series(results, variant, method, of, on);
          const auto others = series(results, other_variant, other_method, other_of, on);
          if (values && others && !on.empty()) {
            made.checks = check(rule, part, on, *values, *others);
            made.alone = compares && made.checks.empty() && (rule.kind == "ratio" || on.size() > 1);
          }
          judgements.push_back(std::move(made));
        }
  }
  return judgements;
}

Verdict verdict_of(const std::vector<Judgement>& judgements) {
  std::size_t all = 0, kept = 0, some = 0;
  for (const Judgement& each : judgements) {
    if (each.alone) continue;
    if (each.checks.empty()) return Verdict::unknown;
    ++all;
    kept += each.kept();
    some += each.some();
  }
  if (all == 0) return Verdict::unknown;
  return kept == all ? Verdict::holds : some > 0 ? Verdict::partly : Verdict::fails;
}

}  // namespace recon::program
