// Tran et al. (2019), figure 6: the cost of IMLS against MLS, by particles per node.
//
// 3 and 6 terms: linear and quadratic in 2-D. Random particles, the same neighbours for all, one
// thread. Three pairs:
//   reconstruct   the public interface, neighbours given, weights and sparse operator included
//   solver        the template layer's two solvers by themselves
//   plain         Cholesky of the moment matrix and single-pass Gram-Schmidt without rank handling
// The paper's MLS solves with MATLAB's backslash.
#include "accuracy.hpp"
#include "accuracy_local.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_plain.hpp"
#include "accuracy_report.hpp"
#include "recon/local_solve/local_solve.hpp"

namespace recon_bench {
namespace {

constexpr int D = 2;

struct Pair {
  double mls = 0, imls = 0;  // microseconds per node
  double ratio() const { return imls / mls; }
};

class Workload {
 public:
  Workload(const Context& context, std::size_t neighbours)
      : budget_(timing_budget(context) / 2),
        setting_(make_setting<D>(CloudKind::random, 60, context.quick ? 500 : 2000)),
        options_{.neighbours = recon::Nearest{neighbours, 1.05}, .threads = 1},
        list_(neighbours_of<double>(setting_.points, setting_.targets, options_)),
        problems_(setting_.points, setting_.targets, list_, options_.weight),
        phi_(list_.indices.size()) {}

  template <int degree>
  Pair by_reconstruct() {
    options_.degree = degree;
    Pair pair;
    for (const auto solver : {recon::Solver::gram_schmidt, recon::Solver::moment_matrix}) {
      options_.solver = solver;
      accuracy_of("Tran et al., figure 6", setting_, options_);  // the check
      const auto fit = recon::reconstruct(points(), targets(), list_, options_);
      const auto values = numbers_of(fit.values());
      if (expected_.empty()) expected_ = values;
      check(values);
      (solver == recon::Solver::gram_schmidt ? pair.imls : pair.mls) =
          micro() * fastest(
                        Timer::one_thread, budget_, [&] { return list_; },
                        [&](auto& given) {
                          recon::reconstruct(points(), targets(), std::move(given), options_);
                        });
    }
    return pair;
  }

  template <int degree>
  Pair by_solver() {
    using Fit = recon::LocalSolve<double, recon::Monomials<D, degree>>;
    const auto time = [&](recon::Solver solver) {
      Fit fit(solver);
      return timed([&](const auto& cloud, double* phi) {
        fit.fit(cloud);
        fit.shape_functions(cloud, {.value = phi});
      });
    };
    return {time(recon::Solver::moment_matrix), time(recon::Solver::gram_schmidt)};
  }

  template <int degree>
  Pair by_plain() {
    PlainMomentMatrix<double, recon::Monomials<D, degree>> matrix;
    SinglePassGramSchmidt<double, recon::Monomials<D, degree>> gram_schmidt;
    return {
        timed([&](const auto& cloud, double* phi) { matrix.shape_functions(cloud, phi); }),
        timed([&](const auto& cloud, double* phi) { gram_schmidt.shape_functions(cloud, phi); })};
  }

 private:
  recon::PointsView<double> points() const { return recon::points_of(setting_.points); }
  recon::PointsView<double> targets() const { return recon::points_of(setting_.targets); }
  double micro() const { return 1e6 / static_cast<double>(setting_.targets.size()); }

  // Shape functions of all nodes by `solve`, compared with those of reconstruct() before
  // they are timed.
  template <class Solve>
  double timed(Solve&& solve) {
    const auto all = [&] {
      for (std::size_t t = 0; t < problems_.size(); ++t)
        solve(problems_[t], phi_.data() + list_.offsets[t]);
    };
    all();
    check(phi_);
    return micro() * fastest(Timer::one_thread, budget_, all);
  }

  void check(const std::vector<double>& phi) const {
    for (std::size_t e = 0; e < phi.size(); ++e)
      if (!(std::abs(phi[e] - expected_[e]) < 1e-9))
        fail("Tran et al., figure 6", "two solvers disagree about a shape function");
  }

  double budget_;
  Setting<double, D> setting_;
  recon::Options options_;
  recon::NeighbourList<double> list_;
  LocalProblems<double, D> problems_;
  std::vector<double> phi_, expected_;  // entry by entry of the list
};

template <int degree>
void measure(const Context& context, std::size_t step, Table& table, recon::LinePlot& plot) {
  const int terms = recon::monomial_count(D, degree);
  const std::string label = ", " + std::to_string(terms) + " terms";
  recon::Curve imls{"IMLS" + label, {}, {}}, mls{"MLS" + label, {}, {}};
  for (std::size_t n = 20; n <= 200; n += step) {
    Workload workload(context, n);
    const Pair whole = workload.by_reconstruct<degree>();
    const Pair solver = workload.by_solver<degree>();
    const Pair plain = workload.by_plain<degree>();
    table.add({std::to_string(terms), std::to_string(n), number(whole.mls), number(whole.imls),
               number(whole.ratio()), number(solver.mls), number(solver.imls),
               number(solver.ratio()), number(plain.mls), number(plain.imls),
               number(plain.ratio())});
    for (auto* curve : {&imls, &mls}) curve->x.push_back(static_cast<double>(n));
    imls.y.push_back(whole.imls);
    mls.y.push_back(whole.mls);
  }
  plot.curves.push_back(imls);
  plot.curves.push_back(mls);
}

}  // namespace

Section tran_cost_study(const Context& context) {
  Table table("tran_figure_6", {"terms", "points per node", "MLS us", "IMLS us", "IMLS / MLS",
                                "solver MLS us", "solver IMLS us", "solver IMLS / MLS",
                                "plain MLS us", "plain IMLS us", "plain IMLS / MLS"});
  recon::LinePlot plot = log_plot("Figure 6 of Tran et al.: cost of a node, 2-D, one thread",
                                  "particles per node", "microseconds per node, neighbours given");
  const std::size_t step = context.quick ? 90 : 20;
  measure<1>(context, step, table, plot);
  measure<2>(context, step, table, plot);
  Section section{
      "Tran et al. (2019), figure 6: cost",
      "Microseconds per node in 2-D on one thread, for the same particles: reconstruct() with "
      "neighbours given; the solvers by themselves; and plain Cholesky against single-pass "
      "Gram-Schmidt as the paper prints it (with corrections). The paper states that IMLS is "
      "cheaper; a ratio above 1 says that it is not.",
      {table},
      {}};
  add_picture(section, context, "tran_figure_6", plot);
  return section;
}

}  // namespace recon_bench
