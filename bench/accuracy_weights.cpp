// Which weight, and how wide: every weight at several widths, on even and uneven clouds.
#include "accuracy.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_report.hpp"

namespace recon_bench {
namespace {

constexpr int D = 3;
constexpr double ratios[] = {1.5, 2, 3, 4, 6};

struct Row {
  std::size_t neighbours = 0;
  Accuracy accuracy;
};

// The accuracy with this many neighbours per term, and the best over all widths.
struct Widths {
  Row standard, best_value, best_gradient;
};

Widths measure(const std::string& name, const Setting<double, D>& s, recon::Options options,
               recon::Curve& curve) {
  Widths widths;
  const int terms = recon::monomial_count(D, options.degree);
  for (const double ratio : ratios) {
    const auto k = static_cast<std::size_t>(std::ceil(ratio * terms));
    options.neighbours = recon::Nearest{k};
    const Row row{k, accuracy_of(name + ", " + std::to_string(k) + " neighbours", s, options)};
    if (ratio == 2) widths.standard = row;
    const auto take = [&](Row& best, double Accuracy::*error) {
      if (best.neighbours == 0 || row.accuracy.*error < best.accuracy.*error) best = row;
    };
    take(widths.best_value, &Accuracy::rms_value);
    take(widths.best_gradient, &Accuracy::rms_gradient);
    curve.x.push_back(static_cast<double>(k));
    curve.y.push_back(row.accuracy.rms_value);
  }
  return widths;
}

}  // namespace

Section weight_study(const Context& context) {
  Table table("accuracy_weights",
              {"cloud", "degree", "weight", "RMS error", "RMS gradient error", "noise",
               "amplification", "reduced %", "MLS handed over %", "least RMS error",
               "at neighbours", "least RMS gradient error", "at neighbours (gradient)", "MLS us"});
  recon::LinePlot plot =
      log_plot("3-D, random particles, degree 2", "neighbours", "RMS error of a field of size 1");
  for (const CloudKind kind : {CloudKind::jittered, CloudKind::random})
    for (const int degree : {1, 2}) {
      const auto s = make_setting<D>(kind, 20, context.quick ? 200 : 2000);
      for (const recon::Weight weight : recon::all_weights()) {
        recon::Options options{
            .degree = degree, .weight = weight, .solver = recon::Solver::moment_matrix};
        recon::Curve curve{std::string(recon::name_of(weight)), {}, {}};
        const std::string name = std::string(name_of(kind)) + " cloud, degree " +
                                 std::to_string(degree) + ", " + curve.name;
        const Widths w = measure(name, s, options, curve);
        options.neighbours = recon::Nearest{w.standard.neighbours};
        const Cost cost = cost_of(s, options, 1, timing_budget(context) / 4);
        const Accuracy& a = w.standard.accuracy;
        table.add({name_of(kind), std::to_string(degree), curve.name, number(a.rms_value),
                   number(a.rms_gradient), number(a.noise), number(a.amplification),
                   number(a.reduced), number(a.handed_over),
                   number(w.best_value.accuracy.rms_value), std::to_string(w.best_value.neighbours),
                   number(w.best_gradient.accuracy.rms_gradient),
                   std::to_string(w.best_gradient.neighbours), number(cost.construct)});
        using recon::Weight;
        const bool shown = weight == Weight::linear_b_spline || weight == Weight::cubic_b_spline ||
                           weight == Weight::quintic_b_spline || weight == Weight::wendland_c2 ||
                           weight == Weight::wendland_c6 || weight == Weight::gaussian ||
                           weight == Weight::inverse_distance;
        if (shown && kind == CloudKind::random && degree == 2) plot.curves.push_back(curve);
      }
    }
  Section section{"Which weight",
                  "3-D, double. The first numbers are for the nearest 2 particles per term, the "
                  "least errors over 1.5, 2, 3, 4 and 6 per term; the support is 1.5 times the "
                  "distance of the farthest. A sharp weight wants more neighbours than a flat one.",
                  {table},
                  {}};
  add_picture(section, context, "accuracy_weights", plot);
  return section;
}

}  // namespace recon_bench
