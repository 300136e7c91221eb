#include "fit_choice.hpp"

#include <algorithm>

#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "recon/basis/monomials.hpp"

namespace recon::program {

namespace {

Solver solver_of(const std::string& name) {
  if (name == "mls") return Solver::moment_matrix;
  if (name == "qr") return Solver::qr;
  if (name == "svd") return Solver::svd;
  return Solver::gram_schmidt;
}

std::vector<std::string> weight_names() {
  std::vector<std::string> names;
  for (const Weight weight : all_weights()) names.emplace_back(name_of(weight));
  return names;
}

std::string unsupported_check(const std::string& text) {
  if (text == "nan" || text == "nearest" || to_number(text)) return "";
  return "'" + text + "' is not nan, nearest or a number";
}

std::string distance_check(const std::string& text) {
  if (const auto value = to_number(text); text == "none" || (value && *value > 0)) return "";
  return "'" + text + "' is not none or a positive number";
}

std::string leverage_check(const std::string& text) {
  if (const auto value = to_number(text); value && *value > 1) return "";
  return "'" + text + "' is not a number above 1";
}

// Three particles per term of the basis, and for a mean as many as for a linear fit, so that it
// smooths no less. Beside walls fits with two amplify errors more.
std::size_t suggested_neighbours(const Particles& particles, int degree) {
  return std::min<std::size_t>(3 * monomial_count(particles.dimension, std::max(degree, 1)),
                               particles.in_all);
}

}  // namespace

std::vector<std::string> method_names() {
  return {"shepard", "mls", "imls", "qr", "svd"};
}

const char* const method_help =
    "shepard  weighted mean (degree 0)\n"
    "mls      moving least squares by the moment matrix; hands\n"
    "         ill-conditioned targets over to imls\n"
    "imls     moving least squares by Gram-Schmidt, drops what\n"
    "         the particles do not resolve (the default)\n"
    "qr, svd  slow references";

void add_fit_options(CLI::App& app, FitChoice& choice) {
  const std::string group = "Reconstruction";
  app.add_option("--degree", choice.degree,
                 "polynomials up to this degree are reproduced: 0 to 4\n(default 1)")
      ->type_name("P")
      ->check(digit('0', '4'))
      ->group(group);
  app.add_option("--radius", choice.radius,
                 "support radius, a length, the same everywhere (default: the\n"
                 "nearest particles, see --k, so that supports follow the\n"
                 "density)")
      ->type_name("R")
      ->check(positive_number())
      ->group(group);
  app.add_option("--k", choice.k,
                 "use the N nearest particles, each target with a support of\n"
                 "its own (default: 3 per term of the degree, in 3-D 12 for\n"
                 "degree 0 and 1); with --radius too: the N nearest of those\n"
                 "within R")
      ->type_name("N")
      ->check(whole_number(1))
      ->group(group);
  app.add_option("--grow", choice.grow,
                 "where the degree is not reached, try again with the support\n"
                 "enlarged by a quarter, up to N times")
      ->type_name("N")
      ->check(whole_number(0))
      ->capture_default_str()
      ->group(group);
  app.add_option("--weight", choice.weight,
                 "weight function: linear, quadratic, cubic, quartic, quintic\n"
                 "(B-splines), wendland_c0, _c2, _c4, _c6, gaussian,\n"
                 "inverse_distance")
      ->type_name("NAME")
      ->check(one_of(weight_names()))
      ->capture_default_str()
      ->group(group);
  app.add_option("--weight-by", choice.weight_by,
                 "a column, as mass, that multiplies the weight of each particle\n"
                 "in the fit (sums over kernels stay as they are)")
      ->type_name("COLUMN")
      ->group(group);
  app.add_option("--form", choice.form,
                 "radial: the weight of the distance, the support a ball;\n"
                 "tensor: a factor for each axis, the support a cube")
      ->type_name("FORM")
      ->check(one_of({"radial", "tensor"}))
      ->capture_default_str()
      ->group(group);
  app.add_option("--leverage", choice.leverage,
                 "drop directions in which a fit would amplify errors in the\n"
                 "data more than L times: the degree falls there")
      ->type_name("L")
      ->check(leverage_check)
      ->capture_default_str()
      ->group(group);
  app.add_option("--limit", choice.limit,
                 "keep values near their data, for each component:\n"
                 "range    between the least and the greatest of the particles\n"
                 "         in the support; no extrapolation at all\n"
                 "relaxed  as far beyond that as it is wide, but in the range of\n"
                 "         all particles; linear fields keep their slope at walls\n"
                 "none     as the fit has it\n"
                 "Gradients and kernel sums are never limited")
      ->type_name("LIMIT")
      ->check(one_of({"range", "relaxed", "none"}))
      ->capture_default_str()
      ->group(group);
  app.add_option("--max-distance", choice.max_distance,
                 "no value where every particle is farther than M local spacings\n"
                 "(the distance from the nearest one to the neighbour that a\n"
                 "linear fit takes last: the 9th in 3-D); none: no such bound")
      ->type_name("M")
      ->check(distance_check)
      ->capture_default_str()
      ->group(group);
  app.add_option("--unsupported", choice.unsupported,
                 "value where no particle is in the support: nan, nearest (that\n"
                 "of the nearest particle) or a number; too far from all\n"
                 "particles, nearest is nan too")
      ->type_name("VALUE")
      ->check(unsupported_check)
      ->check(such_as({"nan", "nearest"}))
      ->capture_default_str()
      ->group(group);
  app.add_option("--threads", choice.threads,
                 "threads (0: all processors); results do not depend on it")
      ->type_name("N")
      ->check(whole_number(0))
      ->capture_default_str()
      ->group(group);
}

Method read_method(const std::string& text, const FitChoice& choice) {
  const std::size_t colon = text.find(':');
  Method method{text.substr(0, colon), 0, Solver::gram_schmidt};
  if (const std::string wrong = one_of(method_names())(method.name); !wrong.empty())
    fail_usage("method: " + wrong);
  method.solver = solver_of(method.name);
  method.degree = choice.degree.value_or(1);
  if (colon != std::string::npos) {
    const std::string degree = text.substr(colon + 1);
    if (const std::string wrong = digit('0', '4')(degree); !wrong.empty())
      fail_usage("method " + text + ": " + wrong);
    method.degree = degree[0] - '0';
  } else if (method.name == "shepard") {
    method.degree = choice.degree.value_or(0);
  }
  if (method.name == "shepard" && method.degree > 0)
    fail_usage("method shepard is a weighted mean, degree 0; for degree " +
               std::to_string(method.degree) + " choose mls or imls");
  return method;
}

void check_weight_by(const FitChoice& choice, Particles& particles) {
  if (choice.weight_by.empty()) return;
  const ParticleTable& table = particles.table;
  if (!table.has(choice.weight_by))
    fail_usage("--weight-by: unknown column '" + choice.weight_by + "'; " +
               suggest(choice.weight_by, table.names()));
  leave_out_missing(particles, {choice.weight_by});
  with_exit_code(wrong_input, [&] {
    const std::vector<double>& weights = table.column(choice.weight_by);
    for (std::size_t row = 0; row < weights.size(); ++row)
      if (!(weights[row] > 0))
        fail_input("--weight-by " + choice.weight_by + ": " + number(weights[row]) + " at " +
                   table.describe_row(row) + " of " + table.source +
                   ": weights must be positive; --where leaves particles out");
  });
}

FitOptions fit_options(const FitChoice& choice, const Method& method, const Particles& particles) {
  FitOptions options;
  options.degree = method.degree;
  options.solver = method.solver;
  options.weight = weight_named(choice.weight);
  options.form = choice.form == "tensor" ? WeightForm::tensor_product : WeightForm::radial;
  options.domain = particles.domain;
  options.grow.steps = choice.grow;
  options.threads = choice.threads;
  options.tolerances.leverage = choice.leverage;
  options.limit = choice.limit == "range"     ? Limit::range
                  : choice.limit == "relaxed" ? Limit::relaxed
                                              : Limit::none;
  if (const auto distance = to_number(choice.max_distance)) options.max_distance = *distance;
  if (choice.k && *choice.k > particles.in_all)
    fail_usage("--k " + std::to_string(*choice.k) + ": there are " +
               counted(particles.in_all, "particle") + " only");
  if (choice.k && choice.radius)
    options.neighbours = NearestWithin{*choice.k, *choice.radius};
  else if (choice.k)
    options.neighbours = Nearest{*choice.k};
  else if (choice.radius)
    options.neighbours = Radius{*choice.radius};
  else
    options.neighbours = Nearest{suggested_neighbours(particles, method.degree)};
  if (!choice.k && !choice.radius && particles.spacing > 0)
    options.sum_radius = suggested_radius(particles, method.degree);
  if (!choice.weight_by.empty())
    options.particle_weights = particles.table.column(choice.weight_by);
  if (choice.unsupported == "nearest")
    options.unsupported = Unsupported::nearest;
  else if (const auto value = to_number(choice.unsupported))
    options.fill_value = *value;
  return options;
}

std::string describe_support(const FitChoice& choice, const Method& method,
                             const Particles& particles, bool kernel_sums) {
  std::string text;
  if (choice.k)
    text = counted(*choice.k, "nearest particle") +
           (choice.radius ? " within radius " + number(*choice.radius) : "");
  else if (choice.radius)
    text = "radius " + number(*choice.radius);
  else
    text = counted(suggested_neighbours(particles, method.degree), "nearest particle") +
           " (chosen for degree " + std::to_string(method.degree) + "; --k or --radius changes it)";
  if (kernel_sums && !choice.k && !choice.radius && particles.spacing > 0)
    text += "; of sums radius " + number(suggested_radius(particles, method.degree));
  if (choice.grow > 0) text += ", growing up to " + counted(choice.grow, "time");
  return text;
}

}  // namespace recon::program
