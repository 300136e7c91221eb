#include "report.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "programs/common/text.hpp"
#include "recon/core/error.hpp"
#include "recon/studies/errors.hpp"
#include "study_results.hpp"

namespace recon::program {
namespace {

namespace fs = std::filesystem;

std::string shown(double value) {
  return std::isnan(value) ? "-" : number(value, 3);
}

// In a cell of a table a bar would end it.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '|' ? "\\|" : std::string(1, c);
  return safe;
}

std::string bounds(double lower, double upper) {
  if (std::isinf(lower)) return "at most " + number(upper, 4);
  if (std::isinf(upper)) return "at least " + number(lower, 4);
  if (lower == upper) return number(lower, 4);
  return number(lower, 4) + " to " + number(upper, 4);
}

// What a driver run judges is on the page of the driver, all else on that of reconstruction.
bool is_reconstruction(const Document& document, const Claim& claim) {
  if (claim.study.empty()) return true;
  const std::string& kind = document.study(claim.study).kind;
  return kind == "shepard" || kind == "reconstruction" || kind == "linear functions" ||
         kind == "polynomials" || kind == "solver cost";
}

std::string verdict_text(const Judged& judged) {
  return name_of(judged.verdict) + (judged.why.empty() ? "" : " (" + cell(judged.why) + ")");
}

// How many claims of each source have which verdict.
std::string overview(const Report& report) {
  std::string text =
      "| source | claims | hold | hold partly | do not reproduce | cannot be judged | figures, "
      "tables "
      "and sections | of them without a claim |\n| --- | --- | --- | --- | --- | --- | --- | --- "
      "|\n";
  for (const Document& document : report.list.documents) {
    int counts[4] = {}, all = 0;
    for (const Judged& each : report.claims)
      if (each.document == &document) ++counts[static_cast<int>(each.verdict)], ++all;
    std::size_t without = 0;
    for (const Without& each : document.without) without += each.at.size();
    text += "| " + document.source + " | " + std::to_string(all);
    for (const int count : counts) text += " | " + std::to_string(count);
    text +=
        " | " + std::to_string(document.numbers.size()) + " | " + std::to_string(without) + " |\n";
  }
  return text + "\n";
}

std::string rules_table(const ClaimList& list) {
  std::string text = "| rule | what is judged | bounds |\n| --- | --- | --- |\n";
  const std::map<std::string, std::string> kinds{
      {"order", "order on each of the two finest pairs of grids"},
      {"difference", "difference of two orders on each of the two finest pairs"},
      {"value", "number on each grid"},
      {"ratio", "number over another on each grid"},
      {"printed", "number less the printed one"},
      {"falls", "number over that on the next coarser grid, all pairs"},
      {"breaks",
       "the run stops because a volume is no longer positive, and so with half the step"}};
  for (const auto& [name, rule] : list.rules) {
    std::string range = bounds(rule.lower, rule.upper);
    if (rule.kind == "printed") range = "one unit of the last digit";
    if (rule.kind == "breaks") range = "it does";
    if (rule.stops) range += ", or the run stops, but not on the coarsest grid";
    text += "| " + name + " | " + kinds.at(rule.kind) + " | " + range + " |\n";
  }
  return text + "\n";
}

std::string claims_table(const Report& report, const Document& document) {
  std::string text = "| where | claim | verdict | differs |\n| --- | --- | --- | --- |\n";
  for (const Judged& each : report.claims) {
    if (each.document != &document) continue;
    std::string differs;
    const auto add = [&](const std::string& where, const std::string& verdict) {
      if (!verdict.empty() && verdict != name_of(each.verdict))
        differs += (differs.empty() ? "" : "; ") + where + ": " + verdict;
    };
    add("quick", each.quick);
    add("finer grids", each.finer);
    add("at T/4", each.quarter);
    add("at 3T/8", each.three_eighths);
    text += "| " + Document::place(*each.claim) + " | " + cell(each.claim->says) + " | " +
            verdict_text(each) + " | " + differs + " |\n";
  }
  return text + "\n";
}

std::string judgement_table(const Judged& judged) {
  std::string text = "| series | rule | bounds | measured | |\n| --- | --- | --- | --- | --- |\n";
  for (const Judgement& each : judged.judgements) {
    std::string measured;
    for (const RuleCheck& check : each.checks)
      measured += (measured.empty() ? "" : "; ") +
                  (each.checks.size() > 1 ? check.name + ": " : "") + shown(check.value);
    if (measured.empty())
      measured = each.alone ? "stopped, all that it is compared with" : "not run";
    text += "| " + cell(each.series) + " | " + cell(each.rule) + " | " +
            bounds(each.lower, each.upper) + " | " + measured + " | " +
            (each.checks.empty() ? ""
             : each.kept()       ? "yes"
             : each.some()       ? "in part"
                                 : "no") +
            " |\n";
  }
  return text + "\n";
}

// The grids that have runs.
std::vector<int> grids_of(const StudyResults& results) {
  std::set<int> grids;
  for (const auto& [key, run] : results) grids.insert(key.grid);
  return {grids.begin(), grids.end()};
}

// Errors on all grids, and the order to the grid before.
std::string error_table(const Study& study, const StudyResults& results) {
  const std::vector<int> grids = grids_of(results);
  std::string head = "| run | error | time", line = "| --- | --- | ---";
  for (const int grid : grids) {
    head += " | " + std::to_string(grid);
    line += " | ---";
  }
  std::string text = head + " |\n" + line + " |\n";
  for (const RunKey& first : runs_on(study, {0}))
    for (const char* field : mpm::error_fields)
      for (const auto& [suffix, time] : {std::pair("", "T"), {" T/4", "T/4"}, {" 3T/8", "3T/8"}}) {
        std::vector<double> errors;
        for (const int grid : grids) {
          const auto run = results.find({first.variant, first.method, grid});
          errors.push_back(run == results.end() ? std::nan("")
                                                : run->second.value(std::string(field) + suffix));
        }
        // Results that were measured before there was this field do not have it.
        const auto is_missing = [](double error) { return std::isnan(error); };
        if (field == std::string("grid_velocity") &&
            std::all_of(errors.begin(), errors.end(), is_missing))
          continue;
        const std::vector<double> found = orders(grids, errors);
        text += "| " + (first.variant.empty() ? "" : first.variant + ", ") + first.method + " | " +
                field + " | " + time;
        for (std::size_t k = 0; k < grids.size(); ++k)
          text += " | " + shown(errors[k]) +
                  (k > 0 && !std::isnan(found[k - 1]) ? " (" + or_dash(found[k - 1], "%.2f") + ")"
                                                      : "");
        text += " |\n";
      }
  return text + "\n";
}

std::string run_name(const RunKey& key) {
  return (key.variant.empty() ? "" : key.variant + ", ") + key.method;
}

// A row for each method and variant, a column for each grid.
std::string grid_table(const Study& study, const StudyResults& results,
                       const std::string& quantity) {
  const std::vector<int> grids = grids_of(results);
  std::string head = "| ", line = "| ---";
  for (const int grid : grids) {
    head += " | " + std::to_string(grid);
    line += " | ---";
  }
  std::string text = head + " |\n" + line + " |\n";
  for (const RunKey& first : runs_on(study, {0})) {
    std::string row = "| " + run_name(first);
    bool any = false;
    for (const int grid : grids) {
      const auto run = results.find({first.variant, first.method, grid});
      const double value = run == results.end() ? std::nan("") : run->second.value(quantity);
      any = any || !std::isnan(value);
      row += " | " + shown(value);
    }
    if (any) text += row + " |\n";
  }
  return text;
}

// A row for each run, a column for each quantity.
std::string number_table(const Study& study, const StudyResults& results) {
  std::vector<std::string> names;
  for (const auto& [key, run] : results)
    for (const auto& [name, value] : run.numbers)
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  const std::vector<int> grids = grids_of(results);
  std::string head = "| run | cells", line = "| --- | ---";
  for (const std::string& name : names) {
    head += " | " + cell(name);
    line += " | ---";
  }
  std::string text = head + " |\n" + line + " |\n";
  for (const RunKey& key : runs_on(study, grids)) {
    const auto run = results.find(key);
    if (run == results.end()) continue;
    text += "| " + run_name(key) + " | " + std::to_string(key.grid);
    for (const std::string& name : names) text += " | " + shown(run->second.value(name));
    text += " |\n";
  }
  return text + "\n";
}

// The runs that did not come to their end, and those that were refused from the beginning.
std::string stops(const StudyResults& results) {
  std::string all;
  for (const bool refused : {false, true}) {
    std::string text;
    for (const auto& [key, run] : results)
      if (!run.note.empty() && run.refused == refused)
        text += "- " + run_name(key) + ", " + std::to_string(key.grid) + ": " + run.note + "\n";
    if (!text.empty()) all += (refused ? "Refused:\n\n" : "Stopped:\n\n") + text + "\n";
  }
  return all;
}

// Of a study: those that its runs have drawn.
std::string pictures(const Report& report, const Study& study, const StudyResults& results) {
  std::string text;
  if (report.folder.empty()) return text;
  std::vector<std::string> names{study.name};
  for (const RunKey& key : runs_on(study, grids_of(results)))
    for (const char* title :
         {"energy", "displacement", "velocity", "stress", "axis", "places", "height"})
      names.push_back(picture_name(study, key) + "_" + title);
  for (const std::string& name : names)
    if (fs::exists(fs::path(report.folder) / (name + ".png")))
      text += "![" + name + "](verification/" + name + ".png)\n\n";
  return text;
}

std::string study_head(const Study& study) {
  std::string text = "### Study: " + study.name + "\n\n";
  std::string what;
  if (!study.problem.empty()) what = "`" + study.problem + ".toml`";
  for (const std::string& each : study.settings) what += (what.empty() ? "`" : ", `") + each + "`";
  const auto list = [](const std::vector<int>& grids) {
    std::string words;
    for (const int grid : grids) words += " " + std::to_string(grid);
    return words;
  };
  what += (what.empty() ? "grids" : "; grids") + list(study.paper);
  if (!study.finer.empty()) what += ", and finer:" + list(study.finer);
  if (!study.norm.empty()) what += "; norm " + study.norm;
  return text + (study.about.empty() ? "" : study.about + "\n\n") + what + ".\n\n";
}

std::string study_section(const Report& report, const Document& document, const Study& study) {
  const auto found = report.results.find(study.name);
  const StudyResults none, &results = found == report.results.end() ? none : found->second;
  std::string claims;
  for (const Judged& each : report.claims) {
    if (each.document != &document || each.claim->study != study.name) continue;
    claims += "**" + Document::place(*each.claim) + ": " + verdict_text(each) + ".** " +
              each.claim->says + "\n\n" + judgement_table(each);
  }
  if (claims.empty()) return "";
  std::string text = study_head(study) + claims;
  if (results.empty()) return text;
  text += study.kind == "convergence" ? error_table(study, results) : number_table(study, results);
  return text + stops(results) + pictures(report, study, results);
}

std::string reconstruction_table(const Report& report) {
  std::string text = "| where | claim | verdict | measured |\n| --- | --- | --- | --- |\n";
  for (const Judged& each : report.claims) {
    if (!is_reconstruction(*each.document, *each.claim)) continue;
    std::string measured;
    for (const Judgement& judgement : each.judgements) {
      measured += (measured.empty() ? "" : "; ") + judgement.series + " ";
      for (std::size_t k = 0; k < judgement.checks.size(); ++k)
        measured += (k > 0 ? ", " : "") + shown(judgement.checks[k].value);
    }
    text += "| " + each.document->source + ", " + Document::place(*each.claim) + " | " +
            cell(each.claim->says) + " | " + name_of(each.verdict) + " | " +
            cell(measured.empty() ? each.claim->why : measured) + " |\n";
  }
  return text;
}

// Words of a mark: "NAME; key: value".
std::string word_of(const std::string& mark, const std::string& key) {
  const std::size_t at = mark.find("; " + key + ": ");
  if (at == std::string::npos) return "";
  const std::size_t from = at + key.size() + 4;
  return mark.substr(from, mark.find(';', from) - from);
}

std::string between_marks(const std::string& mark, const Report& report) {
  if (mark == "claims") return reconstruction_table(report);
  const auto unknown = [&](const std::string& what) {
    recon::detail::throw_invalid("mark of a page", mark, what);
  };
  if (mark.starts_with("claims: ")) {
    for (const Document& document : report.list.documents)
      if (document.source == mark.substr(8)) return claims_table(report, document);
    unknown("names an unknown source");
  }
  const std::string name = mark.substr(7, mark.find(';') - 7);  // after "study: "
  const auto found = report.results.find(name);
  if (found == report.results.end()) unknown("names a study without results");
  const Study* study = nullptr;
  for (const Document& document : report.list.documents)
    for (const Study& each : document.studies)
      if (each.name == name) study = &each;
  if (const std::string of = word_of(mark, "of"); !of.empty())
    return grid_table(*study, found->second, of);
  StudyResults results = found->second;
  const std::string grid = word_of(mark, "grid");
  if (!grid.empty())
    std::erase_if(results, [&](const auto& run) { return std::to_string(run.first.grid) != grid; });
  return number_table(*study, results) + stops(results);
}

}  // namespace

std::string picture_name(const Study& study, const RunKey& key) {
  std::string name = study.name + "_" + (key.variant.empty() ? "" : key.variant + "_") +
                     key.method + "_" + std::to_string(key.grid);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

bool wanted(const ClaimList& list, const Document& document, const Claim& claim,
            const std::string& only) {
  if (only.empty()) return true;
  for (const Document& each : list.documents)
    for (const Study& study : each.studies)
      if (study.name == only) return claim.study == only;
  for (const std::string& at : claim.at)
    if ((document.source + ", " + at).find(only) != std::string::npos) return true;
  return claim.says.find(only) != std::string::npos;
}

std::string listing(const ClaimList& list, const std::string& only) {
  std::string text;
  for (const Document& document : list.documents)
    for (const std::string& number : document.numbers) {
      const auto here = [&](const std::vector<std::string>& at) {
        return std::find(at.begin(), at.end(), number) != at.end();
      };
      const std::string start = document.source + ", " + number + ": ";
      for (const Without& each : document.without)
        if (here(each.at) && start.find(only) != std::string::npos)
          text += start + "no claim: " + each.why + "\n";
      for (const Claim& claim : document.claims)
        if (here(claim.at) && wanted(list, document, claim, only))
          text += start + claim.says + "\n";
    }
  return text;
}

std::string filled_page(const std::string& page, const Report& report) {
  std::string text;
  const std::string open = "<!-- ", close = " -->\n", end = "<!-- end -->";
  std::size_t at = 0;
  for (std::size_t from; (from = page.find(open, at)) != std::string::npos;) {
    const std::size_t to = page.find(close, from);
    const std::string mark =
        to == std::string::npos ? "" : page.substr(from + open.size(), to - from - open.size());
    const bool ours =
        mark == "claims" || mark.starts_with("claims: ") || mark.starts_with("study: ");
    const std::size_t stop = ours ? page.find(end, to) : std::string::npos;
    if (stop == std::string::npos) {
      text += page.substr(at, from + open.size() - at);
      at = from + open.size();
      continue;
    }
    text += page.substr(at, to + close.size() - at) + between_marks(mark, report);
    at = stop;
  }
  return text + page.substr(at);
}

std::string verification_page(const Report& report) {
  std::string text =
      "# Verification\n\nWritten by `recon-mpm verify" + std::string(report.full ? " --full" : "") +
      "` from the list of claims in [claims](claims), which has every figure, table and section of "
      "the three publications (`recon-mpm verify --list`), what eigenvalues of a step say "
      "([dispersion.md](dispersion.md)), and benchmarks of other codes "
      "([benchmarks.md](benchmarks.md)).\n\n" +
      (report.only.empty() ? ""
                           : "Only what was asked for stands here: `--only '" + report.only +
                                 "'`; without it, this page has all claims.\n\n") +
      overview(report) + "A verdict is that of the rules below on the grids of the source" +
      (report.full ? "" : ", as far as the quick verification has them") +
      ". Claims about orders are made at T, a whole period, at which errors of first order may "
      "cancel; what the same rules say at T/4 and 3T/8, on finer grids and in the quick "
      "verification stands beside, where it differs.\n\n";
  for (const Document& document : report.list.documents)
    text += "## Claims of " + document.source + "\n\n" + claims_table(report, document);
  text +=
      "## How claims are judged\n\nA part of a claim holds where its rule is kept on all grids or "
      "pairs, and in part where it is on some. A claim holds where all parts do, does not "
      "reproduce where no part does on any grid, and holds partly in between. A run that stopped "
      "has no numbers, and keeps no rule but \"diverges\" and \"breaks\"; a run that ended is not "
      "compared with one that stopped. The rules are in "
      "[claims/rules.toml](claims/rules.toml), which says what of them was changed after results "
      "were seen.\n\n" +
      rules_table(report.list);
  for (const Document& document : report.list.documents) {
    text += "## Measured: " + document.source + "\n\n";
    for (const Study& study : document.studies) text += study_section(report, document, study);
  }
  return text;
}

}  // namespace recon::program
