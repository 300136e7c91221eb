// Good and bad clouds: error, exactness, orthogonality, and what becomes of the targets.
#include "accuracy.hpp"
#include "accuracy_local.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_plain.hpp"
#include "recon/local_solve/gram_schmidt.hpp"
#include "recon/local_solve/reference.hpp"

namespace recon_bench {
namespace {

constexpr int D = 3, degree = 2;
using Terms = recon::Monomials<D, degree>;
constexpr std::size_t neighbours = 2 * Terms::size + 1;
using Problems = LocalProblems<double, D>;

// The largest loss over the targets that the solver keeps for itself; NaN for the moment matrix.
double orthogonality_of(recon::Solver solver, const Problems& problems) {
  if (solver == recon::Solver::moment_matrix) return std::nan("");
  double loss = 0;
  if (solver == recon::Solver::gram_schmidt) {
    recon::GramSchmidt<double, Terms> fit;
    for (std::size_t t = 0; t < problems.size(); ++t) {
      fit.fit(problems[t]);
      loss = std::max(loss, loss_of_orthogonality(fit.result()));
    }
  } else {
    recon::ReferenceFit<double, Terms> fit(solver);
    recon::FitReport report;
    for (std::size_t t = 0; t < problems.size(); ++t)
      if (fit.fit(problems[t], report)) loss = std::max(loss, loss_of_orthogonality(fit.result()));
  }
  return loss;
}

struct Plain {
  Accuracy accuracy;
  double failed = 0, orthogonality = std::nan("");  // failed in per cent
};

// A reference without rank handling, held to the full degree everywhere.
template <class Fit>
Plain measure_plain(const Setting<double, D>& s, const recon::NeighbourList<double>& list,
                    const Problems& problems) {
  Plain plain;
  Fit fit;
  RowTally<double, D> tally(s.points);
  std::vector<double> phi(problems.most_neighbours());
  for (std::size_t t = 0; t < problems.size(); ++t) {
    const auto cloud = problems[t];
    if (!fit.shape_functions(cloud, phi.data())) {
      plain.failed += 100.0 / static_cast<double>(problems.size());
      continue;
    }
    tally.add(s.targets[t], list.support[t], {phi.data(), static_cast<std::size_t>(cloud.size)},
              list.of(t), degree);
    if constexpr (requires { fit.loss_of_orthogonality(cloud); })
      plain.orthogonality = std::fmax(plain.orthogonality, fit.loss_of_orthogonality(cloud));
  }
  plain.accuracy = tally.result();
  return plain;
}

void add_row(Table& table, CloudKind kind, const char* supports, const std::string& solver,
             const Accuracy& a, double orthogonality) {
  table.add({name_of(kind), supports, solver, number(a.neighbours), number(a.rms_value),
             number(a.max_value), number(a.rms_gradient), number(a.reduced), number(a.no_support),
             number(a.handed_over), number(a.residual), number(orthogonality),
             number(a.amplification)});
}

void measure_nearest(Table& table, CloudKind kind, const Setting<double, D>& s) {
  recon::Options options{.degree = degree, .neighbours = recon::Nearest{neighbours}};
  const auto list = neighbours_of<double>(s.points, s.targets, options);
  const Problems problems(s.points, s.targets, list, options.weight);
  recon::Options shepard = options;
  shepard.degree = 0;
  const std::string name = std::string(name_of(kind)) + " cloud, ";
  add_row(table, kind, "nearest", "Shepard", accuracy_of(name + "Shepard", s, shepard),
          std::nan(""));
  for (const recon::Solver solver : all_solvers) {
    options.solver = solver;
    add_row(table, kind, "nearest", solver_name(solver),
            accuracy_of(name + solver_name(solver), s, options),
            orthogonality_of(solver, problems));
  }
  using Matrix = PlainMomentMatrix<double, Terms>;
  using SinglePass = SinglePassGramSchmidt<double, Terms>;
  const auto add_plain = [&](const char* method, Plain plain) {
    plain.accuracy.neighbours = neighbours;
    plain.accuracy.rms_gradient = plain.accuracy.reduced = plain.accuracy.handed_over =
        std::nan("");
    plain.accuracy.no_support = plain.failed;
    add_row(table, kind, "nearest", method, plain.accuracy, plain.orthogonality);
  };
  add_plain("plain moment matrix", measure_plain<Matrix>(s, list, problems));
  add_plain("single-pass Gram-Schmidt", measure_plain<SinglePass>(s, list, problems));
}

void measure_radius(Table& table, CloudKind kind, const Setting<double, D>& s) {
  recon::Options options{.degree = degree,
                         .neighbours = recon::Radius{radius_for<D>(neighbours, s.spacing)}};
  for (const bool grown : {false, true})
    for (const auto solver : {recon::Solver::moment_matrix, recon::Solver::gram_schmidt}) {
      options.solver = solver;
      options.grow.steps = grown ? 8 : 0;
      const char* supports = grown ? "radius, growing" : "radius";
      const std::string name = std::string(name_of(kind)) + " cloud, " + supports + ", ";
      add_row(table, kind, supports, solver_name(solver),
              accuracy_of(name + solver_name(solver), s, options), std::nan(""));
    }
}

}  // namespace

Section cloud_study(const Context& context) {
  Table table("accuracy_clouds", {"cloud", "supports", "solver", "neighbours", "RMS error",
                                  "max error", "RMS gradient error", "reduced %", "no value %",
                                  "handed over %", "residual", "orthogonality", "amplification"});
  for (const CloudKind kind :
       {CloudKind::regular, CloudKind::jittered, CloudKind::random, CloudKind::clustered,
        CloudKind::one_sided, CloudKind::plane, CloudKind::line}) {
    // Flat clouds have as many particles per axis as others have per two.
    const std::size_t per_axis = kind == CloudKind::line ? 400 : kind == CloudKind::plane ? 60 : 20;
    const auto s = make_setting<D>(kind, per_axis, context.quick ? 200 : 2000);
    measure_nearest(table, kind, s);
    if (kind != CloudKind::plane && kind != CloudKind::line) measure_radius(table, kind, s);
  }
  return {
      "Good and bad clouds",
      "3-D, degree 2, double, cubic B-spline. Supports: the 21 nearest particles, or one radius "
      "in which a random cloud has 21. The last two methods have no rank handling and are held "
      "to the full degree everywhere; \"no value\" are then the targets where Cholesky stopped. "
      "Orthogonality: largest |u_i . u_j - delta_ij| of the weighted columns; amplification: "
      "largest sum |phi|, by which errors in the data can grow.",
      {table},
      {}};
}

}  // namespace recon_bench
