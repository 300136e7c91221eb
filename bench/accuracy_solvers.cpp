// Cost and error by solver, degree and dimension, on random clouds.
#include "accuracy.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_report.hpp"

namespace recon_bench {
namespace {

template <int D>
void measure(const Context& context, Table& table, recon::LinePlot* plot) {
  constexpr std::size_t per_axis = D == 1 ? 1000 : D == 2 ? 60 : 20;
  const std::size_t fast = context.quick ? 1000 : 10000, few = context.quick ? 200 : 1000;
  const auto s = make_setting<D>(CloudKind::random, per_axis, fast);
  for (int degree = 0; degree <= 4; ++degree) {
    double mls = 0;
    for (const recon::Solver solver : all_solvers) {
      if (degree == 0 && solver != recon::Solver::moment_matrix) continue;
      const int terms = recon::monomial_count(D, degree);
      const auto k = static_cast<std::size_t>(2 * terms + 1);
      recon::Options options{.degree = degree, .neighbours = recon::Nearest{k}, .solver = solver};
      options.threads = context.threads;
      const std::string name = solver_name(solver, degree);
      const auto a =
          accuracy_of(name + ", degree " + std::to_string(degree) + ", " + std::to_string(D) + "-D",
                      with_targets(s, few), options);
      const bool slow = solver == recon::Solver::qr || solver == recon::Solver::svd;
      const Cost c = cost_of(slow ? with_targets(s, few) : s, options, context.threads,
                             timing_budget(context));
      if (solver == recon::Solver::moment_matrix) mls = c.construct;
      table.add({std::to_string(D), std::to_string(degree), name, std::to_string(terms),
                 std::to_string(k), number(a.rms_value), number(a.max_value),
                 number(a.rms_gradient), number(a.max_gradient), number(a.residual),
                 number(a.reduced), number(a.handed_over), number(c.construct),
                 number(c.construct / mls), number(c.construct_parallel), number(c.gradient),
                 number(c.apply), number(c.apply_parallel), number(a.bytes)});
      if (!plot || degree == 0) continue;
      recon::Curve& curve = plot->curves[static_cast<std::size_t>(solver)];
      curve.name = name;
      curve.x.push_back(degree);
      curve.y.push_back(c.construct);
    }
  }
}

}  // namespace

Section solver_study(const Context& context) {
  const std::string threads = std::to_string(context.threads) + " threads";
  Table table("accuracy_solvers",
              {"dimension", "degree", "solver", "terms", "neighbours", "RMS error", "max error",
               "RMS gradient error", "max gradient error", "residual", "reduced %", "handed over %",
               "construct us", "over MLS", "construct us parallel", "gradient us", "apply us",
               "apply us parallel", "bytes"});
  recon::LinePlot plot = log_plot("Shape functions in 3-D, 2 terms + 1 neighbours, one thread",
                                  "degree", "microseconds per target");
  plot.x_range = recon::Range{0.8, 4.2};
  plot.curves.resize(4);
  measure<1>(context, table, nullptr);
  measure<2>(context, table, nullptr);
  measure<3>(context, table, &plot);
  Section section{
      "Solver, degree and dimension",
      "Random particles, the default neighbours (the nearest 2 terms + 1), cubic B-spline, double. "
      "Errors of a smooth field of size 1 and of its gradient (1/length); residual: the largest "
      "|sum phi xi^alpha - delta| up to the reported degree. Microseconds per target with "
      "neighbours given, one thread (parallel: " +
          threads + "); bytes per target of operator and reports.",
      {table},
      {}};
  add_picture(section, context, "accuracy_cost", plot);
  return section;
}

}  // namespace recon_bench
