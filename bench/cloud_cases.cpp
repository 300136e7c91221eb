// The cloud workload against the hand-written loop: search, construct, apply, and all together.
#include <map>
#include <optional>

#include "answers.hpp"
#include "cloud.hpp"
#include "flops.hpp"
#include "hand_written.hpp"
#include "lab.hpp"
#include "pictures.hpp"

namespace recon_bench {
namespace {

constexpr recon::Solver solvers[] = {recon::Solver::moment_matrix, recon::Solver::gram_schmidt};

// Goals in times faster, with the moment matrix; 0: reported without one. Gram-Schmidt is reported.
struct Goals {
  double search = 0, construct = 0, all = 0;
};
Goals goals_of(const CloudSetting& setting) {
  if (setting.dimension == 3) return setting.degree == 2 ? Goals{13, 7, 11} : Goals{0, 2.5, 8};
  return setting.degree == 2 ? Goals{0, 4, 9} : Goals{0, 2, 8};
}
// Float against double and two threads against one are aims of this one.
bool is_aim(const CloudSetting& setting) {
  return setting.dimension == 3 && setting.degree == 2;
}
constexpr double most_reduced = 0.01;  // of all targets
constexpr double float_goal_construct = 1.7, float_goal_all = 1.5, threads_goal = 1.8;

// One cloud in one scalar type, with the results of all stages as members, so that what a run
// leaves behind is freed before the next one, outside of its time.
template <class Scalar, int D, int Degree>
class CloudCase {
 public:
  CloudCase(CloudSize size, int k, int threads) : cloud_(size), k_(k), threads_(threads) {
    hand_list_ = hand_written::search<Scalar, D>(cloud_.sources, cloud_.targets, k, threads);
    hand_fit_ = hand_written::construct<Scalar, D, Degree>(cloud_.sources, cloud_.targets,
                                                           hand_list_, threads);
    hand_out_.resize(cloud_.targets.size());
    out_.resize(cloud_.targets.size());
    hand_apply();
    list_ = call().find(cloud_);
  }

  std::size_t targets() const { return cloud_.targets.size(); }
  std::size_t reduced() const { return reduced_; }

  // All stages once, compared with the hand-written loop.
  bool check(Checks& checks, const std::string& name) {
    const auto compare = [&](const auto& fit, const std::string& what) {
      fit.apply(recon::field_of(cloud_.u), recon::field_of(out_));
      reduced_ = std::max(reduced_, fit.report().reduced());
      return checks.within(compare_values<Scalar>(out_, hand_out_, fit.report(), terms(D, Degree)),
                           name + ", " + what);
    };
    bool good = checks.within(
        compare_neighbours<Scalar, D>(list_, hand_list_, cloud_.sources, cloud_.targets),
        name + ", search");
    for (const recon::Solver solver : solvers) {
      const std::string with = " with " + std::string(name_of(solver));
      const bool given = compare(call(solver).construct(cloud_, list_), "construct" + with);
      const bool found = compare(call(solver).reconstruct(cloud_), "all" + with);
      good = good && given && found;
    }
    // What has a lower degree is not compared, so it must be rare.
    return checks.hold(
               static_cast<double>(reduced_) <= most_reduced * static_cast<double>(targets()),
               name + ": " + std::to_string(reduced_) + " targets of a lower degree") &&
           good;
  }

  // Adds the contestants of a stage; the names end in `suffix`.
  void add_search(std::vector<Contestant>& all, const std::string& suffix, int threads, bool hand) {
    all.push_back({"recon" + suffix, [=, this] { list_ = call({}, threads).find(cloud_); },
                   [this] { list_ = {}; }});
    if (hand)
      all.push_back({"hand" + suffix,
                     [this] {
                       hand_list_ = hand_written::search<Scalar, D>(cloud_.sources, cloud_.targets,
                                                                    k_, threads_);
                     },
                     [this] { hand_list_ = {}; }});
  }

  void add_construct(std::vector<Contestant>& all, const std::string& suffix, int threads,
                     bool hand) {
    for (const recon::Solver solver : solvers)
      all.push_back(
          {std::string(name_of(solver)) + suffix,
           [=, this] { fit_.emplace(call(solver, threads).construct(cloud_, std::move(copy_))); },
           [this] {
             fit_.reset();
             copy_ = list_;
           }});
    if (hand)
      all.push_back({"hand" + suffix,
                     [this] {
                       hand_fit_ = hand_written::construct<Scalar, D, Degree>(
                           cloud_.sources, cloud_.targets, hand_list_, threads_);
                     },
                     [this] { hand_fit_.reset(); }});
  }

  void add_apply(std::vector<Contestant>& all, const std::string& suffix, int threads, bool hand) {
    auto fit = std::make_shared<recon::BasicReconstruction<Scalar>>(
        call(recon::Solver::moment_matrix, threads).construct(cloud_, list_));
    all.push_back({"recon" + suffix,
                   [=, this] { fit->apply(recon::field_of(cloud_.u), recon::field_of(out_)); }});
    if (hand) all.push_back({"hand" + suffix, [this] { hand_apply(); }});
  }

  void add_all(std::vector<Contestant>& all, const std::string& suffix, int threads, bool hand) {
    for (const recon::Solver solver : solvers)
      all.push_back({std::string(name_of(solver)) + suffix,
                     [=, this] {
                       fit_.emplace(call(solver, threads).reconstruct(cloud_));
                       fit_->apply(recon::field_of(cloud_.u), recon::field_of(out_));
                     },
                     [this] { fit_.reset(); }});
    if (hand)
      all.push_back({"hand" + suffix,
                     [this] {
                       hand_list_ = hand_written::search<Scalar, D>(cloud_.sources, cloud_.targets,
                                                                    k_, threads_);
                       hand_fit_ = hand_written::construct<Scalar, D, Degree>(
                           cloud_.sources, cloud_.targets, hand_list_, threads_);
                       hand_apply();
                     },
                     [this] {
                       hand_list_ = {};
                       hand_fit_.reset();
                     }});
  }

 private:
  ReconCall call(recon::Solver solver = recon::Solver::gram_schmidt, int threads = 0) const {
    return {.degree = Degree,
            .k = static_cast<std::size_t>(k_),
            .threads = threads ? threads : threads_,
            .solver = solver};
  }

  void hand_apply() {
    hand_written::apply(hand_list_, hand_fit_.get(), cloud_.u.data(), hand_out_.size(),
                        hand_out_.data(), threads_);
  }

  Cloud<Scalar, D> cloud_;
  int k_, threads_;
  std::size_t reduced_ = 0;
  recon::NeighbourList<Scalar> list_, copy_;
  std::optional<recon::BasicReconstruction<Scalar>> fit_;
  hand_written::Neighbours<Scalar> hand_list_;
  hand_written::Array<Scalar> hand_fit_;
  std::vector<Scalar> out_, hand_out_;
};

// The times of one setting by stage ("search", ...) and contestant ("hand", "recon_float", ...).
struct Timed {
  std::map<std::string, std::map<std::string, Times>> stage;
  double targets = 1;
  std::size_t reduced = 0;
  bool good = true;

  const Times& of(const std::string& which, const std::string& name) const {
    static const Times none;
    const auto found = stage.find(which);
    if (found == stage.end()) return none;
    const auto times = found->second.find(name);
    return times == found->second.end() ? none : times->second;
  }
  double us(const std::string& which, const std::string& name) const {
    return of(which, name).best() / targets * 1e6;
  }
};

template <int D, int Degree>
Timed time_setting(Lab& lab, const CloudSetting& setting) {
  progress("cloud, " + setting.name());
  const int threads = lab.context.threads;
  const bool one_thread_too = threads > 1 && (!lab.context.quick || is_aim(setting));
  const CloudSize size = lab.context.smoke ? smoke_cloud_size : cloud_size;
  CloudCase<double, D, Degree> wide(size, setting.k, threads);
  CloudCase<float, D, Degree> narrow(size, setting.k, threads);

  Timed timed;
  timed.targets = static_cast<double>(wide.targets());
  timed.good = wide.check(lab.checks, setting.name() + " double");
  timed.good = narrow.check(lab.checks, setting.name() + " float") && timed.good;
  timed.reduced = wide.reduced();
  if (!timed.good) return timed;

  const auto contest = [&](const std::string& stage, auto add) {
    std::vector<Contestant> all;
    add(wide, all, "", threads, true);
    add(narrow, all, "_float", threads, true);
    if (one_thread_too) add(wide, all, "_one_thread", 1, false);
    const auto times = lab.stopwatch.run("cloud/" + setting.name() + "/" + stage, all);
    for (std::size_t i = 0; i < all.size(); ++i) timed.stage[stage][all[i].name] = times[i];
  };
  contest("search", [](auto& one, auto&&... how) { one.add_search(how...); });
  contest("construct", [](auto& one, auto&&... how) { one.add_construct(how...); });
  contest("apply", [](auto& one, auto&&... how) { one.add_apply(how...); });
  contest("all", [](auto& one, auto&&... how) { one.add_all(how...); });
  return timed;
}

Timed time_setting(Lab& lab, const CloudSetting& setting) {
  if (setting.dimension == 3)
    return setting.degree == 2 ? time_setting<3, 2>(lab, setting)
                               : time_setting<3, 1>(lab, setting);
  return setting.degree == 2 ? time_setting<2, 2>(lab, setting) : time_setting<2, 1>(lab, setting);
}

struct Row {
  const char *stage, *subject;
};
constexpr Row rows[] = {{"search", "recon"},           {"construct", "moment_matrix"},
                        {"construct", "gram_schmidt"}, {"apply", "recon"},
                        {"all", "moment_matrix"},      {"all", "gram_schmidt"}};

std::string label(const Row& row) {
  const std::string subject = row.subject;
  return std::string(row.stage) + (subject == "recon" ? "" : " " + subject);
}

double goal_of(const CloudSetting& setting, const Row& row) {
  const Goals goals = goals_of(setting);
  const std::string stage = row.stage, subject = row.subject;
  if (stage == "search") return goals.search;
  if (subject != "moment_matrix") return 0;
  return stage == "all" ? goals.all : goals.construct;
}

void add_aims(Summary& summary, const CloudSetting& setting, const Timed& timed) {
  const std::string per_target = ", us per target against the hand-written loop";
  for (const Row& row : rows) {
    const double ours = timed.us(row.stage, row.subject), theirs = timed.us(row.stage, "hand");
    const double ratio = speedup(timed.of(row.stage, row.subject), timed.of(row.stage, "hand"));
    const double goal = goal_of(setting, row);
    if (goal > 0)
      summary.at_least(setting.name(), label(row) + per_target, ours, theirs, ratio, goal);
    else
      summary.note(setting.name(), label(row) + per_target, ours, theirs, ratio);
  }
}

void add_own_aims(Summary& summary, const CloudSetting& setting, const Timed& timed, int threads) {
  for (const Row& row : rows) {
    const std::string subject = row.subject, stage = row.stage;
    const Times& plain = timed.of(stage, subject);
    if (stage == "construct" || stage == "all")
      summary.at_least(setting.name(), label(row) + ", us per target: float against double",
                       timed.us(stage, subject + "_float"), timed.us(stage, subject),
                       speedup(timed.of(stage, subject + "_float"), plain),
                       stage == "all" ? float_goal_all : float_goal_construct);
    if (threads > 1)
      summary.at_least(
          setting.name(),
          label(row) + ", us per target: " + std::to_string(threads) + " threads against one",
          timed.us(stage, subject), timed.us(stage, subject + "_one_thread"),
          speedup(plain, timed.of(stage, subject + "_one_thread")), threads_goal);
  }
}

void add_rows(const CloudSetting& setting, const Timed& timed, Table& table) {
  for (const Row& row : rows) {
    const std::string subject = row.subject, stage = row.stage;
    if (!timed.good) {
      table.add({setting.name(), label(row), wrong_answer, "", "", "", "", "", "", "", ""});
      continue;
    }
    const auto& plain = timed.of(stage, subject);
    const auto& narrow = timed.of(stage, subject + "_float");
    const auto& one = timed.of(stage, subject + "_one_thread");
    table.add({setting.name(), label(row), number(timed.us(stage, subject)),
               number(timed.us(stage, "hand")), number(speedup(plain, timed.of(stage, "hand"))),
               number(timed.us(stage, subject + "_float")), number(timed.us(stage, "hand_float")),
               number(speedup(narrow, timed.of(stage, "hand_float"))),
               number(speedup(narrow, plain)), number(speedup(plain, one)),
               std::to_string(plain.seconds.size())});
  }
}

// The share of the measured peak that the direct formulas reach.
void add_share(const Lab& lab, const CloudSetting& setting, const Timed& timed, Table& table) {
  const double flops = construct_flops(setting.dimension, setting.degree, setting.k);
  const auto share = [&](const std::string& name, double peak) {
    return number(100 * flops * timed.targets / timed.of("construct", name).best() / peak);
  };
  table.add({setting.name(), number(flops), share("moment_matrix", lab.limits.flops_double),
             share("gram_schmidt", lab.limits.flops_double), share("hand", lab.limits.flops_double),
             share("moment_matrix_float", lab.limits.flops_float),
             share("gram_schmidt_float", lab.limits.flops_float)});
}

}  // namespace

Section run_cloud(Lab& lab) {
  Section section{
      "Cloud: against the hand-written loop",
      "200,000 uniform random sources in the unit cube (square), 100,000 random targets in "
      "[0.1, 0.9]^d, the k nearest neighbours, cubic B-spline weight with 1.5 times the k-th "
      "distance as support. Least times in microseconds per target; `ratio` is how many times "
      "faster "
      "recon is, the median over the rounds of the ratio within a round. search: both build their "
      "search and find all neighbours. construct: coefficients for given neighbours; recon's whole "
      "call, with its checks of the input and its report per target. apply: into an own array. "
      "all: "
      "from points to values. Before anything is timed, the neighbours and the values of both are "
      "compared at all targets where recon keeps the full degree.\n\n"
      "The share of the peak counts the operations of the direct formulas (offsets, distance, "
      "cubic "
      "B-spline, monomials, lower triangle of the moment matrix, LDLT, one solve, coefficients), "
      "whatever the solver really does; see flops.hpp.",
      {},
      {}};
  Table table("cloud", {"workload", "stage", "recon us", "hand us", "ratio", "recon float us",
                        "hand float us", "ratio float", "float / double",
                        std::to_string(lab.context.threads) + " threads / 1", "rounds"});
  Table share("cloud_peak",
              {"workload", "flops per target", "moment_matrix % of peak", "gram_schmidt %",
               "hand %", "moment_matrix float %", "gram_schmidt float %"});
  recon::LinePlot plot = log_plot("How many times faster than the hand-written loop",
                                  "neighbours (2-D: 6, 12; 3-D: 8, 20)", "ratio");
  for (const Row& row : rows) plot.curves.emplace_back().name = label(row);

  for (const CloudSetting& setting : cloud_settings) {
    const Timed timed = time_setting(lab, setting);
    add_rows(setting, timed, table);
    add_aims(lab.summary, setting, timed);
    if (is_aim(setting)) add_own_aims(lab.summary, setting, timed, lab.context.threads);
    if (!timed.good) continue;
    add_share(lab, setting, timed, share);
    section.text +=
        "\n\n" + setting.name() + ": " + std::to_string(timed.reduced) +
        " targets get a lower degree from recon (too far outside their neighbours), and "
        "are not compared.";
    for (std::size_t i = 0; i < std::size(rows); ++i) {
      plot.curves[i].x.push_back(setting.k);
      plot.curves[i].y.push_back(
          speedup(timed.of(rows[i].stage, rows[i].subject), timed.of(rows[i].stage, "hand")));
    }
  }
  for (recon::Curve& curve : plot.curves) sort_by_x(curve);
  section.tables = {table, share};
  draw_picture(lab.context, section, "cloud_ratio", plot);
  return section;
}

}  // namespace recon_bench
