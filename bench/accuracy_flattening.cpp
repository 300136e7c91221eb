// Clouds that approach a plane: where fits break, what the rank handling makes of it.
//
// Random particles, squeezed towards a plane that is tilted against all axes. A quadratic fit in
// 3-D has four terms too many on the plane. Whatever a method does about them, polynomials *along*
// the plane are determined by the particles, and must come back: that is the residual here. Targets
// lie within the squeezed cloud ("on") or half a spacing beside the plane ("beside"), where a fit
// that believes in the thin direction extrapolates.
#include "accuracy.hpp"
#include "accuracy_local.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_plain.hpp"
#include "accuracy_report.hpp"

namespace recon_bench {
namespace {

constexpr int D = 3, degree = 2;
using Terms = recon::Monomials<D, degree>;
constexpr double per_axis = 40;
using Vector = std::array<double, D>;

// Orthonormal: two directions along the plane, and its normal (1, 2, 3) / sqrt(14).
const std::array<Vector, D>& plane_axes() {
  static const double a = std::sqrt(5), n = std::sqrt(14), b = std::sqrt(70);
  static const std::array<Vector, D> axes{Vector{2 / a, -1 / a, 0}, Vector{3 / b, 6 / b, -5 / b},
                                          Vector{1 / n, 2 / n, 3 / n}};
  return axes;
}

// From coordinates along the plane's axes, in a unit cube about its centre, to space.
Vector turned(const Vector& along) {
  Vector x{0.5, 0.5, 0.5};
  for (int i = 0; i < D; ++i)
    for (int d = 0; d < D; ++d) x[d] += along[i] * plane_axes()[i][d];
  return x;
}

Setting<double, D> squeezed(double thickness, bool beside, std::size_t target_count) {
  Setting<double, D> s{{}, {}, 1 / per_axis};
  recon::RandomNumbers random(21);
  for (int i = 0; i < per_axis * per_axis; ++i)
    s.points.push_back(turned({random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                               thickness * random.uniform(-0.5, 0.5)}));
  for (std::size_t i = 0; i < target_count; ++i) {
    const double a = random.uniform(-0.4, 0.4), b = random.uniform(-0.4, 0.4);
    const double height = thickness * random.uniform(-0.5, 0.5);
    s.targets.push_back(turned({a, b, beside ? 0.5 * s.spacing : height}));
  }
  return s;
}

// The shape functions of all targets, entry by entry of the neighbour list.
struct Rows {
  std::vector<double> phi;
  std::vector<bool> failed;
  double handed_over = std::nan(""), reduced = std::nan(""), construct = std::nan("");
};

Rows rows_of(const std::string& name, const Setting<double, D>& s,
             const recon::NeighbourList<double>& list, recon::Options options, recon::Solver solver,
             double budget) {
  options.solver = solver;
  accuracy_of(name, s, options);  // the check
  const auto fit =
      recon::reconstruct(recon::points_of(s.points), recon::points_of(s.targets), list, options);
  const auto& summary = fit.report().summary();
  const double per_cent = 100.0 / static_cast<double>(s.targets.size());
  return {numbers_of(fit.values()), std::vector<bool>(s.targets.size(), false),
          per_cent * static_cast<double>(summary.handed_over),
          per_cent * static_cast<double>(summary.reduced),
          cost_of(s, options, 1, budget).construct};
}

template <class Fit>
Rows plain_rows(const LocalProblems<double, D>& problems,
                const recon::NeighbourList<double>& list) {
  Rows rows{std::vector<double>(list.indices.size()), {}};
  Fit fit;
  for (std::size_t t = 0; t < problems.size(); ++t)
    rows.failed.push_back(!fit.shape_functions(problems[t], rows.phi.data() + list.offsets[t]));
  return rows;
}

struct Result {
  double failed = 0, residual = 0, amplification = 0, rms = 0, worst = 0;
};

// Largest |sum phi s^a t^b - delta| over a + b <= degree, s and t along the plane, in supports.
double residual_along(const Setting<double, D>& s, const recon::NeighbourList<double>& list,
                      std::size_t t, const Rows& rows) {
  using Flat = recon::Monomials<2, degree>;
  std::array<long double, Flat::size> moments{-1.0L};
  for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
    std::array<long double, 2> along{};
    for (int i = 0; i < 2; ++i)
      for (int d = 0; d < D; ++d)
        along[i] += static_cast<long double>(plane_axes()[i][d]) *
                    (static_cast<long double>(s.points[list.indices[e]][d]) - s.targets[t][d]) /
                    list.support[t];
    std::array<long double, Flat::size> terms;
    Flat::evaluate(along, terms.data());
    for (int j = 0; j < Flat::size; ++j) moments[j] += rows.phi[e] * terms[j];
  }
  long double residual = 0;
  for (const auto m : moments) residual = std::abs(m) <= residual ? residual : std::abs(m);
  return static_cast<double>(residual);
}

Result evaluate(const Setting<double, D>& s, const recon::NeighbourList<double>& list,
                const Rows& rows) {
  Result r;
  std::size_t solved = 0;
  for (std::size_t t = 0; t < s.targets.size(); ++t) {
    if (rows.failed[t]) continue;
    ++solved;
    double value = 0, magnitude = 0;
    for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
      value += rows.phi[e] * field(s.points[list.indices[e]]);
      magnitude += std::abs(rows.phi[e]);
    }
    const double error = std::abs(value - field(s.targets[t]));
    r.residual = std::max(r.residual, residual_along(s, list, t, rows));
    r.amplification = std::max(r.amplification, magnitude);
    r.worst = std::max(r.worst, error);
    r.rms += error * error;
  }
  r.failed = 100.0 * static_cast<double>(s.targets.size() - solved) /
             static_cast<double>(s.targets.size());
  if (solved == 0) return {r.failed, std::nan(""), std::nan(""), std::nan(""), std::nan("")};
  r.rms = std::sqrt(r.rms / static_cast<double>(solved));
  return r;
}

struct Output {
  Table table{"accuracy_flattening",
              {"targets", "thickness", "method", "failed %", "handed over %", "reduced %",
               "residual along plane", "amplification", "RMS error", "max error", "construct us"}};
  recon::LinePlot residual, amplification;
};

void add(Output& out, bool beside, double thickness, const std::string& method, const Rows& rows,
         const Result& r) {
  out.table.add({beside ? "beside" : "on", number(thickness), method, number(r.failed),
                 number(rows.handed_over), number(rows.reduced), number(r.residual),
                 number(r.amplification), number(r.rms), number(r.worst), number(rows.construct)});
  if (method == "QR" || method == "SVD") return;
  recon::LinePlot& plot = beside ? out.amplification : out.residual;
  auto curve = std::find_if(plot.curves.begin(), plot.curves.end(),
                            [&](const recon::Curve& c) { return c.name == method; });
  if (curve == plot.curves.end()) curve = plot.curves.insert(curve, {method, {}, {}});
  curve->x.push_back(thickness);
  curve->y.push_back(beside ? r.amplification : std::max(r.residual, 1e-17));
}

void measure(const Context& context, bool beside, double thickness, Output& out) {
  const auto s = squeezed(thickness, beside, context.quick ? 200 : 2000);
  const recon::Options options{.degree = degree, .neighbours = recon::Nearest{2 * Terms::size + 1}};
  const auto list = neighbours_of<double>(s.points, s.targets, options);
  const LocalProblems<double, D> problems(s.points, s.targets, list, options.weight);
  const auto add_rows = [&](const std::string& method, const Rows& rows) {
    add(out, beside, thickness, method, rows, evaluate(s, list, rows));
  };
  add_rows("plain moment matrix", plain_rows<PlainMomentMatrix<double, Terms>>(problems, list));
  add_rows("single-pass Gram-Schmidt",
           plain_rows<SinglePassGramSchmidt<double, Terms>>(problems, list));
  for (const auto solver : all_solvers) {
    const std::string name = "thickness " + number(thickness) + ", " + solver_name(solver);
    const Rows rows = rows_of(name, s, list, options, solver, timing_budget(context) / 8);
    add_rows(solver_name(solver), rows);
  }
}

}  // namespace

Section flattening_study(const Context& context) {
  Output out;
  const std::string thickness = "thickness / width of the cloud";
  out.residual = log_log_plot("3-D, degree 2: targets within a cloud squeezed to a plane",
                              thickness, "largest residual along the plane");
  out.amplification = log_log_plot("3-D, degree 2: targets half a spacing beside the plane",
                                   thickness, "largest factor on errors in the data, sum |phi|");
  for (const bool beside : {false, true})
    for (int digits = 1; digits <= 12; digits += context.quick ? 2 : 1)
      measure(context, beside, std::pow(10.0, -digits), out);
  Section section{
      "Clouds that approach a plane",
      "3-D, degree 2, the 21 nearest particles, double, a plane tilted against all axes. Residual "
      "along plane: the largest error of a polynomial of degree 2 in the two directions that the "
      "particles do determine. The plain moment matrix and single-pass Gram-Schmidt have no rank "
      "handling; failed: Cholesky stopped. Beside the plane a residual in proportion to the "
      "thickness is no error: the plane of the nearest particles is tilted by as much.",
      {out.table},
      {}};
  add_picture(section, context, "accuracy_flattening", out.residual);
  add_picture(section, context, "accuracy_flattening_beside", out.amplification);
  return section;
}

}  // namespace recon_bench
