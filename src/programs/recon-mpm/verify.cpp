// recon-mpm verify: the claims of the publications, measured and judged.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>

#include "claim_list.hpp"
#include "commands.hpp"
#include "measure.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/progress.hpp"
#include "recon/io/atomic_file.hpp"
#include "report.hpp"
#include "study_results.hpp"

namespace recon::program {
namespace {

namespace fs = std::filesystem;

struct VerifyCommand {
  bool full = false, quiet = false, list = false, again = false;
  std::string out, only, results;
  int threads = 1;
  double minutes = 0;  // 0: no limit
};

// The folder of pictures and results beside the page.
constexpr const char* folder_name = "verification";

class Verification {
 public:
  explicit Verification(const VerifyCommand& options)
      : options_(options), list_(read_claims(claim_texts())), report_{list_, {}, {}} {
    report_.full = options.full;
    report_.only = options.only;
    if (!options.out.empty()) report_.folder = (fs::path(options.out) / folder_name).string();
    results_ = !options.results.empty() ? options.results
               : options.out.empty()    ? ""
                                        : (fs::path(report_.folder) / "results").string();
  }

  const ClaimList& list() const { return list_; }
  bool has_claims() const {
    return std::any_of(list_.documents.begin(), list_.documents.end(), [&](const Document& each) {
      return std::any_of(each.claims.begin(), each.claims.end(), [&](const Claim& claim) {
        return wanted(list_, each, claim, options_.only);
      });
    });
  }

  void make_folders() const {
    for (const std::string& folder : {report_.folder, results_})
      if (!folder.empty()) {
        std::error_code error;
        fs::create_directories(folder, error);
        with_exit_code(no_output, [&] { const AtomicFile probe(fs::path(folder) / ".probe"); });
      }
  }

  // What has been kept of the studies that are asked for, and which of their runs are to be made.
  void read_results() {
    for (const Document& document : list_.documents)
      for (const Study& study : document.studies) {
        if (!is_wanted(document, study)) continue;
        files_.emplace_back(std::make_unique<ResultFile>(results_, study));
        missing_.push_back({&study, {}});
        for (const RunKey& key : runs_on(study, grids(study)))
          if (options_.again || !files_.back()->runs().contains(key))
            missing_.back().second.push_back(key);
      }
  }

  void measure() {
    std::size_t runs = 0;
    for (const auto& [study, keys] : missing_) runs += keys.size();
    Progress progress("verify", runs, options_.quiet);
    for (std::size_t s = 0; s < missing_.size(); ++s) {
      const Study& study = *missing_[s].first;
      for (const RunKey& key : missing_[s].second) {
        if (options_.minutes > 0 && progress.seconds() > 60 * options_.minutes) break;
        files_[s]->add(key, run(study, key));
        progress.advance(1);
      }
      report_.results[study.name] = files_[s]->runs();
      if (study.kind == "convergence") draw_errors(study);
    }
  }

  void judge_all() {
    for (const Document& document : list_.documents)
      for (const Claim& claim : document.claims)
        if (wanted(list_, document, claim, options_.only)) judge_one(document, claim);
  }

  void write() const {
    const std::string page = verification_page(report_);
    if (options_.out.empty()) {
      std::fputs(page.c_str(), stdout);
      return;
    }
    AtomicFile file(fs::path(options_.out) / "verification.md");
    file.write(page);
    file.commit();
    fill_pages();
    for (const Judged& each : report_.claims)
      std::printf("%-18s %s, %s: %s\n", name_of(each.verdict).c_str(),
                  each.document->source.c_str(), Document::place(*each.claim).c_str(),
                  each.claim->says.c_str());
  }

 private:
  bool is_wanted(const Document& document, const Study& study) const {
    for (const Claim& claim : document.claims)
      if (claim.study == study.name && wanted(list_, document, claim, options_.only)) return true;
    return false;
  }

  std::vector<int> grids(const Study& study) const {
    return options_.full ? joined(study.quick, joined(study.paper, study.finer)) : study.quick;
  }

  Measured run(const Study& study, const RunKey& key) const {
    const Variant* variant = nullptr;
    for (const Variant& each : study.variants)
      if (each.name == key.variant) variant = &each;
    Request request{study,
                    *variant,
                    key.method,
                    key.grid,
                    options_.threads,
                    report_.folder,
                    picture_name(study, key)};
    const Measure make = measure_of(study.kind);
    try {
      return make(request);
    } catch (const InvalidArgument& refusal) {
      return {{}, refusal.what(), true};
    } catch (const FileError& refusal) {  // from reading the problem with these settings
      return {{}, refusal.what(), true};
    }
  }

  // The verdict of a claim whose quantities carry the name of another time.
  std::string verdict_at(const Claim& claim, const Study& study, const std::string& time) const {
    if (study.kind != "convergence") return "";
    Claim other = claim;
    for (Part& part : other.parts)
      for (std::string& of : part.of) of += time;
    return name_of(verdict_of(judge(other, list_.rules, report_.results.at(study.name),
                                    main_grids(study), options_.full)));
  }

  std::vector<int> main_grids(const Study& study) const {
    return options_.full ? study.paper : study.quick;
  }

  void judge_one(const Document& document, const Claim& claim) {
    Judged judged{&document, &claim, {}, Verdict::unknown, claim.why, "", "", "", ""};
    if (claim.study.empty()) {
      for (const Verdict verdict : {Verdict::holds, Verdict::partly, Verdict::fails})
        if (name_of(verdict) == claim.verdict) judged.verdict = verdict;
      report_.claims.push_back(std::move(judged));
      return;
    }
    const Study& study = document.study(claim.study);
    const StudyResults& results = report_.results.at(study.name);
    judged.judgements = judge(claim, list_.rules, results, main_grids(study), options_.full);
    judged.verdict = verdict_of(judged.judgements);
    const auto is_alone = [](const Judgement& each) { return each.alone; };
    if (std::all_of(judged.judgements.begin(), judged.judgements.end(), is_alone)) {
      judged.why = "all runs that it is compared with stopped";
    } else if (judged.verdict == Verdict::unknown) {
      judged.why = "not in the quick verification";
      if (options_.full) {  // better the grids of the quick verification than none, if that is said
        std::vector<Judgement> quick = judge(claim, list_.rules, results, study.quick, false);
        judged.verdict = verdict_of(quick);
        judged.why = "its runs have not all been made";
        if (judged.verdict != Verdict::unknown) {
          judged.judgements = std::move(quick);
          judged.why = "grids of the quick verification only";
        }
      }
    }
    judged.quarter = verdict_at(claim, study, " T/4");
    judged.three_eighths = verdict_at(claim, study, " 3T/8");
    if (options_.full) {
      const auto verdict_on = [&](const std::vector<int>& grids, bool any) {
        const Verdict verdict = verdict_of(judge(claim, list_.rules, results, grids, any));
        return verdict == Verdict::unknown ? "" : name_of(verdict);
      };
      judged.quick = verdict_on(study.quick, false);
      if (!study.finer.empty()) judged.finer = verdict_on(joined(study.paper, study.finer), true);
    }
    report_.claims.push_back(std::move(judged));
  }

  // Absolute errors at T over the cell size: a curve for each method and variant, the displacement.
  void draw_errors(const Study& study) const {
    if (report_.folder.empty()) return;
    LinePlot plot;
    plot.title = study.name + ", displacement at T";
    plot.x_label = "cell size";
    plot.y_label = "error, " + study.norm;
    plot.log_x = plot.log_y = true;
    plot.reference_slope = 2;
    for (const RunKey& first : runs_on(study, {0})) {
      Curve curve{(first.variant.empty() ? "" : first.variant + ", ") + first.method,
                  {},
                  {},
                  CurveStyle::line_and_markers};
      for (const auto& [key, run] : report_.results.at(study.name)) {
        const double error = run.value("displacement");
        if (key.variant != first.variant || key.method != first.method || !(error > 0)) continue;
        curve.x.push_back(1.0 / key.grid);
        curve.y.push_back(error);
      }
      if (!curve.x.empty()) plot.curves.push_back(std::move(curve));
    }
    try {
      if (!plot.curves.empty()) draw(fs::path(report_.folder) / (study.name + ".png"), plot);
    } catch (const std::exception&) {  // no gnuplot, or too few runs: the numbers are what counts
    }
  }

  // The pages beside verification.md that have marks. Only a whole verification has all that they
  // name.
  void fill_pages() const {
    if (!options_.only.empty()) return;
    for (const auto& entry : fs::directory_iterator(options_.out)) {
      if (entry.path().extension() != ".md") continue;
      std::ifstream file(entry.path());
      std::stringstream all;
      all << file.rdbuf();
      const std::string page = filled_page(all.str(), report_);
      if (page == all.str()) continue;
      AtomicFile out(entry.path());
      out.write(page);
      out.commit();
    }
  }

  const VerifyCommand& options_;
  const ClaimList list_;
  std::string results_;
  std::vector<std::unique_ptr<ResultFile>> files_;
  std::vector<std::pair<const Study*, std::vector<RunKey>>> missing_;  // a study for each file
  Report report_;
};

void run(const VerifyCommand& options) {
  Verification verification(options);
  const std::string list = listing(verification.list(), options.only);
  if (list.empty())
    fail_usage("--only '" + options.only +
               "': no figure, table, section, claim or study has this text; --list names them all");
  if (options.list) {
    std::fputs(list.c_str(), stdout);
    return;
  }
  if (!verification.has_claims())
    fail_usage("--only '" + options.only + "': " + list.substr(0, list.find('\n')));
  with_exit_code(wrong_input, [&] { verification.read_results(); });
  verification.make_folders();
  with_exit_code(no_output, [&] { verification.measure(); });
  verification.judge_all();
  with_exit_code(no_output, [&] { verification.write(); });
}

}  // namespace

Command add_verify(CLI::App& app) {
  auto* command = app.add_subcommand("verify", "the claims of the publications, measured");
  auto options = std::make_shared<VerifyCommand>();
  command->add_flag("--list", options->list,
                    "every figure, table and section of the publications, with its claims");
  command->add_flag("--full", options->full, "the grids of the publications and finer ones; hours");
  command
      ->add_option("--only", options->only,
                   "one study by its name, or else all claims whose place or words contain this "
                   "text, as in 'figure 10' or 'Ring'")
      ->type_name("TEXT");
  command
      ->add_option("--out", options->out,
                   "folder for verification.md and verification/ (default: the terminal)")
      ->type_name("FOLDER");
  command
      ->add_option("--results", options->results,
                   "folder for the results of runs, which are not made again "
                   "(default: verification/results in the folder of --out)")
      ->type_name("FOLDER");
  command->add_flag("--again", options->again, "make all runs anew");
  command->add_option("--minutes", options->minutes, "begin no run after this time")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--threads", options->threads, "threads of a run")
      ->check(whole_number(1))
      ->capture_default_str();
  command->add_flag("--quiet", options->quiet, "no progress");
  return [options] { run(*options); };
}

}  // namespace recon::program
