// How many neighbours: error, noise and cost against their number, in multiples of the terms.
#include "accuracy.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_report.hpp"

namespace recon_bench {
namespace {

constexpr double ratios[] = {1.1, 1.5, 2, 3, 4, 6};

std::size_t neighbours_for(double ratio, int terms) {
  return static_cast<std::size_t>(std::ceil(ratio * terms - 1e-9));
}

struct Tables {
  Table all{"accuracy_neighbours",
            {"dimension", "degree", "terms", "neighbours per term", "neighbours", "RMS error",
             "max error", "RMS gradient error", "noise", "amplification", "reduced %",
             "MLS handed over %", "MLS us", "IMLS us", "apply us", "bytes"}};
  Table best{"accuracy_neighbours_best",
             {"dimension", "degree", "terms", "least RMS error", "at neighbours", "per term",
              "error at 2 per term", "least RMS gradient error", "at neighbours (gradient)",
              "per term (gradient)"}};
  recon::LinePlot error, price;
};

struct Best {
  double error = std::numeric_limits<double>::infinity(), ratio = 0;
  std::size_t neighbours = 0;
  void offer(double value, std::size_t k, double per_term) {
    if (!(value < error)) return;
    error = value;
    neighbours = k;
    ratio = per_term;
  }
};

template <int D>
void measure(const Context& context, Tables& tables) {
  constexpr std::size_t per_axis = D == 1 ? 1000 : D == 2 ? 60 : 20;
  const auto s = make_setting<D>(CloudKind::random, per_axis, context.quick ? 500 : 4000);
  for (int degree = 0; degree <= 4; ++degree) {
    const int terms = recon::monomial_count(D, degree);
    Best value, gradient;
    double at_two = 0;
    recon::Curve error{"degree " + std::to_string(degree), {}, {}};
    recon::Curve price = error;
    for (const double ratio : ratios) {
      if (degree == 0 && ratio < 2) continue;
      const auto k = neighbours_for(ratio, terms);
      recon::Options options{.degree = degree,
                             .neighbours = recon::Nearest{k},
                             .solver = recon::Solver::moment_matrix};
      const std::string name = std::to_string(k) + " neighbours, degree " + std::to_string(degree) +
                               ", " + std::to_string(D) + "-D";
      const auto a = accuracy_of(name, s, options);
      const Cost mls = cost_of(s, options, 1, timing_budget(context) / 4);
      options.solver = recon::Solver::gram_schmidt;
      const Cost imls = cost_of(s, options, 1, timing_budget(context) / 4);
      tables.all.add({std::to_string(D), std::to_string(degree), std::to_string(terms),
                      number(ratio), std::to_string(k), number(a.rms_value), number(a.max_value),
                      number(a.rms_gradient), number(a.noise), number(a.amplification),
                      number(a.reduced), number(a.handed_over), number(mls.construct),
                      number(imls.construct), number(mls.apply), number(a.bytes)});
      value.offer(a.rms_value, k, ratio);
      gradient.offer(a.rms_gradient, k, ratio);
      if (ratio == 2) at_two = a.rms_value;
      error.x.push_back(ratio);
      error.y.push_back(a.rms_value);
      price.x.push_back(mls.construct);
      price.y.push_back(a.rms_value);
    }
    tables.best.add({std::to_string(D), std::to_string(degree), std::to_string(terms),
                     number(value.error), std::to_string(value.neighbours), number(value.ratio),
                     number(at_two), number(gradient.error), std::to_string(gradient.neighbours),
                     number(gradient.ratio)});
    if (D != 3) continue;
    tables.error.curves.push_back(std::move(error));
    tables.price.curves.push_back(std::move(price));
  }
}

// One choice, with the two parts of its error: of the fit, and per noise in the data.
struct Choice {
  int degree = 0;
  std::size_t neighbours = 0;
  double fit = 0, noise = 0;
  // Independent errors of standard deviation sigma add up to sigma sqrt(sum phi^2).
  double error(double sigma) const { return std::hypot(fit, sigma * noise); }
};

std::vector<Choice> choices(const Context& context) {
  constexpr int D = 3;
  const auto s = make_setting<D>(CloudKind::random, 20, context.quick ? 200 : 1000);
  std::vector<Choice> all;
  for (int degree = 0; degree <= 4; ++degree)
    for (const double ratio : {1.5, 2., 3., 4., 6., 10., 20., 40.}) {
      const auto k = neighbours_for(ratio, recon::monomial_count(D, degree));
      if (k > 250) break;
      const recon::Options options{.degree = degree,
                                   .neighbours = recon::Nearest{k},
                                   .solver = recon::Solver::moment_matrix};
      const auto a = accuracy_of("choices, " + std::to_string(k) + " neighbours", s, options);
      all.push_back({degree, k, a.rms_value, a.noise});
    }
  return all;
}

// The one with the least error among those of a degree, or (-1) of any.
Choice best_choice(const std::vector<Choice>& all, int degree, double sigma) {
  Choice best;
  for (const Choice& c : all) {
    if (degree >= 0 && c.degree != degree) continue;
    if (best.neighbours == 0 || c.error(sigma) < best.error(sigma)) best = c;
  }
  return best;
}

// Which degree and number of neighbours have the least error when the data are noisy.
Table noise_table(const Context& context) {
  std::vector<std::string> columns{"noise %", "degree", "neighbours", "RMS error"};
  for (int degree = 0; degree <= 4; ++degree)
    for (const char* what : {"degree ", "neighbours of degree "})
      columns.push_back(what + std::to_string(degree));
  Table table("accuracy_noise", columns);
  const auto all = choices(context);
  for (const double per_cent : {0., 0.01, 0.1, 1., 10.}) {
    const double sigma = per_cent / 100;
    const Choice of_all = best_choice(all, -1, sigma);
    std::vector<std::string> row{number(per_cent), std::to_string(of_all.degree),
                                 std::to_string(of_all.neighbours), number(of_all.error(sigma))};
    for (int degree = 0; degree <= 4; ++degree) {
      const Choice c = best_choice(all, degree, sigma);
      row.push_back(number(c.error(sigma)));
      row.push_back(std::to_string(c.neighbours));
    }
    table.add(row);
  }
  return table;
}

}  // namespace

Section neighbour_study(const Context& context) {
  Tables tables;
  const std::string error = "RMS error of a field of size 1";
  tables.error = log_plot("3-D, random particles", "neighbours per term of the basis", error);
  tables.price = log_log_plot("3-D, random particles: 1.1, 1.5, 2, 3, 4, 6 neighbours per term",
                              "microseconds per target (MLS, one thread, neighbours given)", error);
  measure<1>(context, tables);
  measure<2>(context, tables);
  measure<3>(context, tables);
  Section section{
      "How many neighbours",
      "Random particles, the k nearest, cubic B-spline, double, data without noise. Noise: the RMS "
      "of sqrt(sum phi^2), the share of independent errors in the data that gets into a value. "
      "The table of noisy data (3-D; noise in per cent of the size of the field) names the best "
      "degree and number of neighbours, and the least error that each degree reaches with any "
      "number up to 250.",
      {tables.best, noise_table(context), tables.all},
      {}};
  add_picture(section, context, "accuracy_neighbours", tables.error);
  add_picture(section, context, "accuracy_price", tables.price);
  return section;
}

}  // namespace recon_bench
