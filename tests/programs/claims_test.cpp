// The list of the publications' claims and the rules that judge them.
#ifdef RECON_MPM_PROGRAM

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "programs/recon-mpm/claim_list.hpp"
#include "programs/recon-mpm/judge.hpp"
#include "programs/run_program.hpp"
#include "recon/core/error.hpp"
#include "support/nan.hpp"

namespace recon::test {
namespace {

using namespace recon::program;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const ClaimList& claims() {
  static const ClaimList list = read_claims(claim_texts());
  return list;
}

// The list with one text in it replaced.
std::string refusal_with(const std::string& old_text, const std::string& new_text) {
  std::vector<ClaimText> texts = claim_texts();
  bool found = false;
  for (ClaimText& each : texts) {
    const std::size_t at = each.text.find(old_text);
    if (at == std::string::npos) continue;
    found = true;
    each.text.replace(at, old_text.size(), new_text);
    break;
  }
  EXPECT_TRUE(found) << old_text;
  try {
    read_claims(texts);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "accepted";
}

// Numbers of the three publications, counted in them: figures, tables, sections.
std::vector<std::string> numbers_of(const std::string& source) {
  std::vector<std::string> all;
  const auto add = [&](const std::string& kind, const std::string& chapter, int last) {
    for (int n = 1; n <= last; ++n) all.push_back(kind + chapter + std::to_string(n));
  };
  if (source == "Gong 2015") {
    add("figure ", "4.", 10);
    add("figure ", "5.", 8);
    add("figure ", "6.", 4);
    add("table ", "4.", 2);
    all.insert(all.end(), {"abstract", "section 1"});
    const int sections[] = {4, 5, 7, 6, 7, 4, 2};
    for (int chapter = 2; chapter <= 8; ++chapter)
      add("section ", std::to_string(chapter) + ".", sections[chapter - 2]);
    add("section ", "4.3.", 4);
  } else if (source == "Tran et al. 2019") {
    add("figure ", "", 58);
    add("table ", "", 4);
    all.insert(all.end(), {"abstract", "section 1", "section 5", "section 6", "section 7"});
    add("section ", "2.", 5);
    add("section ", "3.", 2);
    add("section ", "4.", 6);
  } else {
    add("figure ", "", 17);
    all.insert(all.end(),
               {"abstract", "section 1", "section 2", "section 4", "section 5", "appendix"});
    add("section ", "3.", 4);
    add("section ", "4.", 2);
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(Claims, EveryNumberOfThePublicationsIsInTheList) {
  std::size_t publications = 0;
  for (const Document& document : claims().documents) {
    if (document.source == "Waves and steps" || document.source == "Benchmarks") continue;
    ++publications;
    std::vector<std::string> numbers = document.numbers;
    std::sort(numbers.begin(), numbers.end());
    EXPECT_EQ(numbers, numbers_of(document.source)) << document.source;
  }
  EXPECT_EQ(publications, 3u);
}

TEST(Claims, ANumberHasAClaimOrAReason) {
  EXPECT_EQ(refusal_with("", ""), "accepted");
  EXPECT_THAT(refusal_with("at = [\"figure 7\", ", "at = ["),
              AllOf(HasSubstr("figure 7"), HasSubstr("either a claim or a reason")));
  EXPECT_THAT(refusal_with("at = [\"figure 4.8\", ", "at = ["), HasSubstr("figure 4.8"));
  EXPECT_THAT(refusal_with("at = [\"figure 7\", ", "at = [\"figure 7\", \"figure 9\", "),
              HasSubstr("figure 9"));
  EXPECT_THAT(refusal_with("at = [\"figure 7\", ", "at = [\"figure 7\", \"figure 59\", "),
              HasSubstr("figure 59"));
  EXPECT_THAT(refusal_with("why = \"future work\"", "why = \"\""), HasSubstr("without a reason"));
}

TEST(Claims, NamesMustExist) {
  EXPECT_THAT(refusal_with("{rule = \"does not converge\"", "{rule = \"converges not\""),
              HasSubstr("converges not"));
  EXPECT_THAT(refusal_with("kind = \"convergence\"\n", "kind = \"convergence\"\nkindd = 1\n"),
              HasSubstr("kindd"));
  EXPECT_THAT(refusal_with("methods = [\"mpm\"]}]", "methods = [\"mppm\"]}]"), HasSubstr("mppm"));
  EXPECT_THAT(refusal_with("grids = [8, 16, 32]}", "grids = [8, 16, 33]}"),
              HasSubstr("grid that is not run"));
  EXPECT_THAT(refusal_with("verdict = \"does not reproduce\"", "verdict = \"perhaps\""),
              HasSubstr("verdict and a reason"));
  EXPECT_THAT(refusal_with("study = \"wall\"\n", "study = \"walls\"\n"), HasSubstr("walls"));
}

// A claim about the quantity q of method m, beside that of method n.
Claim claim_by(const std::string& rule) {
  Part part;
  part.rule = rule;
  part.of = {"q"};
  part.methods = {"m"};
  part.variants = {""};
  const std::string& kind = claims().rules.at(rule).kind;
  if (kind == "difference" || kind == "ratio") part.than = "n";
  part.printed = 2;
  part.unit = 0.1;
  Claim claim;
  claim.parts = {part};
  return claim;
}

StudyResults runs(const std::vector<int>& grids, const std::vector<double>& m,
                  const std::vector<double>& n = {}) {
  StudyResults results;
  for (std::size_t k = 0; k < grids.size(); ++k) {
    results[{"", "m", grids[k]}].add("q", m[k]);
    results[{"", "n", grids[k]}].add("q", n.empty() ? 1 : n[k]);
  }
  return results;
}

Verdict judged(const std::string& rule, const std::vector<int>& grids, const std::vector<double>& m,
               const std::vector<double>& n = {}) {
  return verdict_of(judge(claim_by(rule), claims().rules, runs(grids, m, n), grids, true));
}

// Errors on 8, 16, 32 and 64 cells with one order.
std::vector<double> errors_of_order(double order) {
  std::vector<double> errors;
  for (const int cells : {8, 16, 32, 64}) errors.push_back(std::pow(cells, -order));
  return errors;
}

// What a rule says to the number itself: an order, a difference, a ratio, a value.
Verdict verdict_on(const Rule& rule, double number) {
  const std::vector<int> grids{8, 16, 32, 64};
  if (rule.kind == "order") return judged(rule.name, grids, errors_of_order(number));
  if (rule.kind == "difference")
    return judged(rule.name, grids, errors_of_order(1 + number), errors_of_order(1));
  if (rule.kind == "falls") return judged(rule.name, {8, 16}, {1, number});
  return judged(rule.name, {8}, {number});
}

TEST(Rules, HaveTwoSides) {
  for (const auto& [name, rule] : claims().rules) {
    if (rule.kind == "printed" || rule.kind == "breaks") continue;
    SCOPED_TRACE(name);
    const double width = std::isfinite(rule.upper - rule.lower) ? rule.upper - rule.lower : 1;
    const double step = std::max(1e-3 * width, 1e-13), some = std::min(width / 2, 0.01);
    if (std::isfinite(rule.lower)) {
      EXPECT_EQ(verdict_on(rule, rule.lower + some), Verdict::holds);
      // A ratio or a part of something is never negative.
      if (rule.lower != 0) {
        EXPECT_EQ(verdict_on(rule, rule.lower - step), Verdict::fails);
      }
    }
    if (std::isfinite(rule.upper)) {
      EXPECT_EQ(verdict_on(rule, rule.upper - some), Verdict::holds);
      EXPECT_EQ(verdict_on(rule, rule.upper + step), Verdict::fails);
    }
    EXPECT_EQ(judged(name, {8, 16, 32}, {nan, nan, nan}, {1, 1, 1}), Verdict::fails);
  }
}

TEST(Rules, TheTwoFinestPairsDecideOrders) {
  const std::vector<int> grids{8, 16, 32, 64};
  EXPECT_EQ(judged("second order", grids, {1, 1, 0.25, 0.0625}), Verdict::holds);
  EXPECT_EQ(judged("second order", grids, {1, 0.25, 0.125, 0.03125}), Verdict::partly);
  EXPECT_EQ(judged("second order", grids, {1, 0.25, 0.125, 0.0625}), Verdict::fails);
  EXPECT_EQ(judged("first order", grids, errors_of_order(1.84)), Verdict::fails);
  EXPECT_EQ(judged("between first and second order", grids, errors_of_order(2.01)), Verdict::fails);
}

TEST(Rules, OnlyDivergenceMayStop) {
  const std::vector<int> grids{8, 16, 32};
  EXPECT_EQ(judged("diverges", grids, {1, nan, nan}), Verdict::holds);
  EXPECT_EQ(judged("diverges", grids, {nan, nan, nan}), Verdict::fails);
  EXPECT_EQ(judged("diverges", grids, {1, 2, 4}), Verdict::holds);
  EXPECT_EQ(judged("diverges", grids, {4, 2, 1}), Verdict::fails);
  EXPECT_EQ(judged("does not converge", grids, {1, nan, nan}), Verdict::fails);
}

TEST(Rules, BreakingIsOneWayToStop) {
  EXPECT_EQ(judged("breaks", {8}, {1}), Verdict::holds);
  EXPECT_EQ(judged("breaks", {8}, {0}), Verdict::fails);
}

TEST(Rules, APrintedNumberHoldsWithinAUnitOfItsLastDigit) {
  EXPECT_EQ(judged("as printed", {8}, {2.1}), Verdict::holds);
  EXPECT_EQ(judged("as printed", {8}, {1.9}), Verdict::holds);
  EXPECT_EQ(judged("as printed", {8}, {2.11}), Verdict::fails);
  EXPECT_EQ(judged("as printed", {8}, {1.89}), Verdict::fails);
}

TEST(Rules, NothingIsJudgedByRunsThatAreMissing) {
  const Claim claim = claim_by("second order");
  StudyResults results = runs({8, 16, 32}, {1, 0.25, 0.0625});
  const auto on = [&](const std::vector<int>& grids) {
    return verdict_of(judge(claim, claims().rules, results, grids, true));
  };
  EXPECT_EQ(on({8, 16, 32}), Verdict::holds);
  EXPECT_EQ(on({8, 16, 32, 64}), Verdict::unknown);
  EXPECT_EQ(on({8}), Verdict::unknown);
  results[{"", "m", 32}].refused = true;
  EXPECT_EQ(on({8, 16, 32}), Verdict::unknown);
}

// A method that explodes is of a far lower order than one that converges, and breaks nothing of it.
TEST(Rules, AHigherOrderMayBeMuchHigher) {
  const std::vector<int> grids{8, 16, 32};
  EXPECT_EQ(judged("higher order", grids, {1, 0.25, 0.0625}, {1, 1e3, 1e6}), Verdict::holds);
  EXPECT_EQ(judged("higher order", grids, {1, 0.25, 0.0625}, {1, 0.25, 0.0625}), Verdict::fails);
}

// A run that ended is not compared with one that stopped; one that stopped is worse than nothing.
TEST(Rules, ComparisonsLeaveOutWhatStopped) {
  const std::vector<int> grids{8, 16, 32};
  const auto verdict = [&](const std::string& rule, StudyResults results) {
    for (auto& [key, run] : results)
      if (std::isnan(run.value("q"))) run.note = "stopped";
    return verdict_of(judge(claim_by(rule), claims().rules, results, grids, true));
  };
  EXPECT_EQ(verdict("smaller", runs(grids, {1, 1, 1}, {2, nan, nan})), Verdict::holds);
  EXPECT_EQ(verdict("smaller", runs(grids, {1, 1, 1}, {1, nan, nan})), Verdict::fails);
  EXPECT_EQ(verdict("smaller", runs(grids, {1, 1, nan}, {2, 2, nan})), Verdict::partly);
  EXPECT_EQ(verdict("smaller", runs(grids, {1, 1, 1}, {nan, nan, nan})), Verdict::unknown);
  EXPECT_EQ(verdict("higher order", runs(grids, {1, 0.25, 0.0625}, {1, 1, nan})), Verdict::holds);
  EXPECT_EQ(verdict("higher order", runs(grids, {1, 0.25, nan}, {1, 1, 1})), Verdict::partly);
  const std::vector<Judgement> alone = [&] {
    StudyResults results = runs(grids, {1, 1, 1}, {nan, nan, nan});
    for (auto& [key, run] : results)
      if (key.method == "n") run.note = "stopped";
    return judge(claim_by("smaller"), claims().rules, results, grids, true);
  }();
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_TRUE(alone[0].alone);
  // A number that an ended run does not have is no excuse.
  EXPECT_EQ(judged("smaller", grids, {1, 1, 1}, {nan, nan, nan}), Verdict::fails);
}

class Verify : public ProgramTest {
 protected:
  Verify() : ProgramTest("recon-mpm", RECON_MPM_PROGRAM) {}
};

TEST_F(Verify, ListsEveryNumber) {
  const std::string list = succeed("verify --list");
  for (const Document& document : claims().documents)
    for (const std::string& number : document.numbers)
      EXPECT_THAT(list, HasSubstr(document.source + ", " + number + ": "));
  EXPECT_THAT(succeed("verify --list --only 'figure 4.8'"),
              AllOf(HasSubstr("Gong 2015, figure 4.8: MPM does not converge"),
                    Not(HasSubstr("figure 4.9"))));
}

TEST_F(Verify, JudgesOneClaim) {
  const std::string page = succeed("verify --only 'figure 4.8' --quiet");
  EXPECT_THAT(page, AllOf(HasSubstr("MPM does not converge at large deformation"),
                          HasSubstr("| mpm: stress | does not converge |"),
                          HasSubstr("| Gong 2015 | 1 |")));
}

// What nothing in the list says is asked for by mistake.
TEST_F(Verify, AsksForWhatIsThere) {
  expect_failure("verify --only 'figure 99' --quiet", 1,
                 AllOf(HasSubstr("figure 99"), HasSubstr("--list")));
  expect_failure("verify --list --only 'figure 99'", 1, HasSubstr("figure 99"));
  expect_failure("verify --only 'Tran et al. 2019, figure 7' --quiet", 1,
                 AllOf(HasSubstr("no claim"), HasSubstr("drawings")));
  // The name of a study means that study alone, though other claims have its name in their words.
  const std::string list = succeed("verify --list --only wall");
  EXPECT_THAT(list,
              AllOf(HasSubstr("figure 56: A disk and a wall"), Not(HasSubstr("between walls"))));
}

const std::string polynomials = "verify --only polynomials --quiet --out out";
const std::string polynomials_file = "out/verification/results/polynomials.txt";

// What has been measured is not measured again, unless it is asked for.
TEST_F(Verify, KeepsResults) {
  EXPECT_THAT(succeed(polynomials + " --minutes 1e-9"), HasSubstr("cannot be judged"));
  EXPECT_THAT(succeed(polynomials), HasSubstr("holds"));
  EXPECT_THAT(succeed(polynomials + " --minutes 1e-9"), Not(HasSubstr("cannot be judged")));
  EXPECT_THAT(read("out/verification.md"), HasSubstr("Only what was asked for stands here"));
  const std::string kept = read(polynomials_file);
  EXPECT_THAT(succeed(polynomials + " --again"), Not(HasSubstr("holds partly")));
  EXPECT_EQ(read(polynomials_file), kept);
}

// `text` with the first `old` after `from` replaced.
std::string with(const std::string& text, const std::string& from, const std::string& old,
                 const std::string& other) {
  const std::size_t at = text.find(old, text.find(from));
  EXPECT_NE(at, std::string::npos) << from << " " << old;
  return text.substr(0, at) + other + text.substr(at + old.size());
}

// A result that was changed by hand is refused with the run and its line.
TEST_F(Verify, RefusesResultsThatWereChanged) {
  succeed(polynomials);
  const std::string kept = read(polynomials_file), run = "the run of -0.1 0.5 on 1000 ";
  const auto refused = [&](const std::string& text, const std::string& message) {
    write(polynomials_file, text);
    expect_failure(polynomials, 2, AllOf(HasSubstr("polynomials.txt:"), HasSubstr(message)));
  };
  refused(with(kept, "-0.1 0.5", "least rank\t2", "least rank\t1"),
          run + "is not as it was written");
  refused(with(kept, "-0.1 0.5", "least rank\t2", "least rank\ttwo"), run + "is no number");
  refused(with(kept, "-0.1 0.5", "\trun\t", "\truns\t"), run + "has no beginning");
  const std::size_t end = kept.find_last_of('\n', kept.size() - 2);
  refused(kept.substr(0, end + 1), "is not as it was written");  // a line less
  refused(kept + kept, "stands there twice");
  refused("no result\n", "no line of results");
  refused(with(kept, "-0.1 0.5", "\t1000\t", "\tmany\t"), "no line of results");
  // Not refused: a run of a method that the study does not have. It is left out.
  write(polynomials_file,
        kept + kept.substr(kept.find('\n') + 1, 16) + "\t\t-0.1 0.7\t1000\trun\t1\n");
  EXPECT_THAT(succeed(polynomials), Not(HasSubstr("holds partly")));
  EXPECT_THAT(read("out/verification.md"), Not(HasSubstr("-0.1 0.7")));
}

// A verification that is cut off goes on from the runs that it had made, and comes to the same.
TEST_F(Verify, GoesOnAfterItWasCutOff) {
  const std::string command = "verify --only bar_small --quiet --out ";
  succeed(command + "whole");
  shell("timeout -s KILL 0.1 '" + program() + "' " + command + "parts");
  shell("timeout -s KILL 0.2 '" + program() + "' " + command + "parts");
  succeed(command + "parts");
  const std::string results = "/verification/results/bar_small.txt";
  EXPECT_THAT(read("whole" + results), HasSubstr("impm"));
  EXPECT_EQ(read("parts" + results), read("whole" + results));
  EXPECT_EQ(read("parts/verification.md"), read("whole/verification.md"));
  // Of a file that has lost whole runs these are made again.
  const std::string all = read("whole" + results);
  std::string fewer;
  std::istringstream lines(all);
  for (std::string line; std::getline(lines, line);)
    if (line.find("\timpm\t32\t") == std::string::npos) fewer += line + "\n";
  ASSERT_LT(fewer.size(), all.size());
  write("whole" + results, fewer);
  succeed(command + "whole");
  EXPECT_EQ(read("whole" + results), all);
}

// The pages of the documentation are those of the results beside them: nothing is run here.
TEST_F(Verify, PagesSayWhatTheResultsSay) {
  namespace fs = std::filesystem;
  const fs::path docs = fs::path(RECON_SOURCE_DIR) / "docs", out = fs::path(folder()) / "docs";
  fs::create_directories(out / "verification");
  fs::copy(docs / "verification" / "results", out / "verification" / "results");
  for (const auto& entry : fs::directory_iterator(docs / "verification"))
    if (entry.path().extension() == ".png")  // that it is there is all that the page needs
      std::ofstream(out / "verification" / entry.path().filename());
  const std::vector<std::string> pages{"verification.md", "papers.md", "dispersion.md",
                                       "benchmarks.md"};
  const auto text = [](const fs::path& path) {
    std::ifstream file(path);
    std::stringstream all;
    all << file.rdbuf();
    return all.str();
  };
  for (const std::string& page : pages) fs::copy(docs / page, out / page);
  succeed("verify --full --quiet --minutes 1e-9 --out docs");
  for (const std::string& page : pages)
    EXPECT_EQ(text(out / page), text(docs / page))
        << page << ": recon-mpm verify --full --out docs";
}

}  // namespace
}  // namespace recon::test

#endif
